"""An elastic capsule in a flow: the coupling against small-deformation theory."""
