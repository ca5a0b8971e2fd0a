"""Set up the equations of a step: the constraints, and the reduced system with its preconditioner.

Takes a topology and angles. Returns residuals (eq. 5-10), and the matrices of the systems for multipliers.
"""

from .circles import compute_central_angles, compute_inscribed_sums
from .constraints import (
    SMALLEST_SINE,
    ClosedPath,
    Constraints,
    HolonomyResidual,
    Residual,
    build_constraints,
    compute_holonomy_residual,
    largest_magnitude,
    residual,
)
from .holonomy import HolonomyConstraints, HolonomyRows
from .patterns import Pattern, Symmetric, replace_rows_by_identity, solve_pairs
from .preconditioner import LARGE_SYSTEM, Slivers, factor_laplacians, make_sliver_preconditioner
from .reduced_system import System
from .schur_columns import SchurColumns
