"""Find and shorten cut graphs, the sets of edges along which a component is cut open to a disk.

Takes a component as a `ClosedSurface`, whose graph has one node for each hole. Returns trees that join nodes,
and the expected stretch of the map after a cut.
"""

from .branches import move_branch_points, prune_branches
from .closed_surface import ClosedSurface
from .clusters import Levels
from .graph import SurfaceGraph, join_terminals
from .handles import open_handles
from .laplacians import DirichletSolver
from .stretch import (
    ISOMETRIC_STRETCH_WEIGHT,
    MAX_LOG_SCALE,
    get_stretch_weight,
    predict_conformal_stretch,
    predict_isometric_stretch,
    predict_stretch,
    solve_log_scale,
)
