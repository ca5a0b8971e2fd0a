"""Steps from the initial estimate to angles that are flat.

In: an `AngleProblem`. Out: a `State` with its angles, residuals and steps: the linear step, the active set
(section 6), converged ABF, steps to prescribed angle sums.
"""

from .conformal_corrections import ROUGH_RTOL, astray, corrected_steps, step_by_same_factor, step_from_surface
from .holonomy_angles import Turnings
from .iterates import REACH, AngleProblem, Blocks, Iterate, Step
from .iterations import State, StepAndChord, active_set, linear_step, step_and_chord
from .linearisation import Direction, Linearised, advance, linearise, solve
from .local_elimination import within_patches
from .newton import LEAST_SHARE, AbfResult, converge, converge_feasibly
from .prescribed import prescribed_steps
