"""The equations of a step: constraints, and the reduced system with its preconditioner.

In: a topology and angles. Out: residuals (eq. 5-10); matrices whose solutions are the steps' multipliers.
"""

from .circles import central_angles, inscribed_sums
from .constants import LARGE_SYSTEM, SMALLEST_SINE
from .constraints import (
    ClosedPath,
    Constraints,
    HolonomyResidual,
    Residual,
    constraints_of,
    holonomy_residual,
    largest_magnitude,
    residual,
)
from .holonomy import HolonomyConstraints, HolonomyRows
from .patterns import Pattern, Symmetric, solve_pairs, with_identity
from .preconditioner import Slivers, correct_at_slivers, laplacian_inverse
from .reduced_system import System
from .schur_columns import SchurColumns
