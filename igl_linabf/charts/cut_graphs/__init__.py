"""Cut graphs: edges along which a component opens to a disk, and how they are made shorter.

In: a component. Out: `ClosedSurface`, its graph with a hole as a node; trees through nodes; the stretch to
expect of the map that a cut leaves.
"""

from .branches import prune_branches
from .closed_surface import ClosedSurface
from .clusters import Levels
from .constants import ISOMETRIC_STRETCH_WEIGHT, MAX_LOG_SCALE
from .graph import SurfaceGraph, join_terminals, without_stubs
from .handles import open_handles
from .laplacians import DirichletSolver
from .stretch import expected, expected_stretch, isometric_stretch, log_scale, stretch_weight
