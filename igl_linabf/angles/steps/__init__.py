"""Take steps from the initial estimate to the angles of a flat mesh.

Takes an `AngleProblem`. Returns a `State` with angles, residuals and steps. The modules provide the linear
step, the active set (section 6), converged ABF, and steps to prescribed angle sums.
"""

from .conformal_corrections import (
    is_diverging,
    iterate_with_corrections,
    step_from_surface,
    step_with_known_factor,
)
from .constants import ROUGH_RTOL
from .holonomy_angles import HolonomyAngles
from .iterates import AngleProblem, DiskRanges, Iterate, Step
from .iterations import State, StepAndChord, run_active_set, take_linear_step, take_step_and_chord
from .linearisation import Direction, Linearisation, apply_direction, linearise, solve_for_errors
from .newton import ANGLE_BOUND, AbfResult, converge, converge_feasibly
from .prescribed import iterate_to_prescribed_sums
