"""Compute the angles of a flat mesh from the angles of a surface (sections 4 and 6 of the paper).

Takes a checked mesh and its angles. Returns target angles, steps, and residuals (eq. 5-16). Linear ABF
follows Zayer, Levy, Seidel 2007. Converged ABF solves the problem of Sheffer and de Sturler 2001 by steps of
the same kind.
"""

from .estimate import CAP_ANGLE, compute_rescaled_angles, corner_angles, initial_estimate, limit_obtuse_angles
from .full_system import Corner, build_fan_rows, least_norm, triangle_rows, vertex_rows
from .steps import (
    ANGLE_BOUND,
    ROUGH_RTOL,
    AbfResult,
    AngleProblem,
    DiskRanges,
    HolonomyAngles,
    Iterate,
    Linearisation,
    State,
    Step,
    StepAndChord,
    converge,
    converge_feasibly,
    is_diverging,
    iterate_to_prescribed_sums,
    iterate_with_corrections,
    linearise,
    run_active_set,
    step_from_surface,
    step_with_known_factor,
    take_linear_step,
    take_step_and_chord,
)
from .system import (
    SMALLEST_SINE,
    ClosedPath,
    Constraints,
    HolonomyConstraints,
    HolonomyRows,
    Pattern,
    Residual,
    System,
    build_constraints,
    compute_central_angles,
    compute_holonomy_residual,
    compute_inscribed_sums,
    largest_magnitude,
    replace_rows_by_identity,
    residual,
)
