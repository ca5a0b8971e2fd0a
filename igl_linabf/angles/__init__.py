"""From the angles of a surface to the angles of a flat mesh (the paper's sections 4 and 6).

In: a checked mesh and its angles. Out: target angles, steps, residuals (eq. 5-16).
Zayer, Levy, Seidel 2007; converged ABF is Sheffer and de Sturler 2001, with the same steps.
"""

from .estimate import CAP_ANGLE, corner_angles, initial_estimate, opened, rescaled
from .full_system import LEFT, RIGHT, fan_rows, least_norm, triangle_rows, vertex_rows
from .steps import (
    LEAST_SHARE,
    REACH,
    ROUGH_RTOL,
    AbfResult,
    AngleProblem,
    Blocks,
    Direction,
    Iterate,
    Linearised,
    State,
    Step,
    StepAndChord,
    Turnings,
    active_set,
    advance,
    astray,
    converge,
    converge_feasibly,
    corrected_steps,
    linear_step,
    linearise,
    prescribed_steps,
    solve,
    step_and_chord,
    step_by_same_factor,
    step_from_surface,
    within_patches,
)
from .system import (
    Across,
    ClosedPath,
    ClosingRows,
    Closure,
    Constraints,
    Pattern,
    Residual,
    System,
    central_angles,
    closure_of,
    constraints_of,
    held,
    inscribed_sums,
    largest,
    residual,
)
