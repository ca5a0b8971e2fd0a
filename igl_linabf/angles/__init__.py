"""From the angles of a surface to the angles of a flat mesh (the paper's sections 4 and 6).

In: a checked mesh and its angles. Out: target angles, steps, residuals (eq. 5-16).
Zayer, Levy, Seidel 2007; converged ABF is Sheffer and de Sturler 2001, with the same steps.
"""

from .estimate import CAP_ANGLE, corner_angles, initial_estimate, open_caps, rescaled
from .full_system import Corner, fan_rows, least_norm, triangle_rows, vertex_rows
from .steps import (
    ANGLE_BOUND,
    ROUGH_RTOL,
    AbfResult,
    AngleProblem,
    Direction,
    DiskBlocks,
    HolonomyAngles,
    Iterate,
    Linearised,
    State,
    Step,
    StepAndChord,
    active_set,
    advance,
    converge,
    converge_feasibly,
    diverges,
    iterate_to_prescribed_sums,
    iterate_with_corrections,
    linear_step,
    linearise,
    solve,
    step_and_chord,
    step_from_surface,
    step_with_known_factor,
)
from .system import (
    SMALLEST_SINE,
    ClosedPath,
    Constraints,
    HolonomyConstraints,
    HolonomyResidual,
    HolonomyRows,
    Pattern,
    Residual,
    SchurColumns,
    System,
    central_angles,
    constraints_of,
    holonomy_residual,
    inscribed_sums,
    largest_magnitude,
    residual,
    with_identity,
)
