"""The equations of a step: constraints, and the reduced system with its preconditioner.

In: a topology and angles. Out: residuals (eq. 5-10); matrices whose solutions are the steps' multipliers.
"""

from .circles import central_angles, inscribed_sums
from .constraints import (
    ClosedPath,
    Closure,
    Constraints,
    Residual,
    closure_of,
    constraints_of,
    largest,
    residual,
)
from .holonomy import ClosingRows
from .patterns import Pattern, Symmetric, held
from .preconditioner import SliverRows, conformal_inverse, corrected, laplacian_inverse
from .reduced_system import System
from .schur_columns import Across
