from .boundary_loop import adapt_boundary as adapt_boundary
from .boundary_stokes import boundary_flow as boundary_flow
from .interface_iterations import partitioned as partitioned
from .substructure import cut as cut
from .substructure import monolithic as monolithic
