"""Steps from the initial estimate to angles that are flat.

In: an `AngleProblem`. Out: a `State` with its angles, residuals and steps: the linear step, the active set
(section 6), converged ABF, steps to prescribed angle sums.
"""

from .conformal_corrections import (
    diverges,
    iterate_with_corrections,
    step_from_surface,
    step_with_known_factor,
)
from .constants import ANGLE_BOUND, ROUGH_RTOL
from .holonomy_angles import HolonomyAngles
from .iterates import AngleProblem, DiskBlocks, Iterate, Step
from .iterations import State, StepAndChord, active_set, linear_step, step_and_chord
from .linearisation import Direction, Linearised, advance, linearise, solve
from .newton import AbfResult, converge, converge_feasibly
from .prescribed import iterate_to_prescribed_sums
