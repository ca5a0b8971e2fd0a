"""From the angles of a surface to the angles of a flat mesh (the paper's sections 4 and 6).

In: a checked mesh and its angles. Out: target angles, steps, residuals (eq. 5-16).
Zayer, Levy, Seidel 2007; converged ABF is Sheffer and de Sturler 2001, with the same steps.
"""

from .across import Across
from .circles import central_angles, inscribed_sums
from .closure import ClosingRows
from .constraints import Constraints, Residual, constraints_of, largest, residual
from .converged import LEAST_SHARE, AbfResult, converge, converge_feasibly
from .estimate import CAP_ANGLE, corner_angles, initial_estimate, opened, rescaled
from .full_system import LEFT, RIGHT, fan_rows, least_norm, triangle_rows, vertex_rows
from .iterates import REACH, AngleProblem, Blocks, Iterate, Step
from .iterations import State, StepAndChord, active_set, linear_step, step_and_chord
from .last_steps import ROUGH_RTOL, astray, corrected_steps, step_by_same_factor, step_from_surface
from .linearised import Direction, Linearised, advance, linearise, solve
from .loops import ClosedPath, Closure, closure_of
from .patches import within_patches
from .patterns import Pattern, held
from .reduced import System
from .to_order import prescribed_steps
from .turnings import Turnings
