from .flow import MixedFlow as MixedFlow
from .flow import mixed_flow as mixed_flow
from .newton import robust as robust
from .newton import solve as solve
from .spaces import taylor_hood as taylor_hood
