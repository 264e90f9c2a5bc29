"""cases.kinds.planar: bags in the plane, chapters 4 and 5 of the thesis, as scenes of their own kind."""
