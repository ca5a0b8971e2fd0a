"""Attempt to find a map by methods of increasing cost, until a map has no flipped triangles.

Takes a problem at its initial estimate. Returns the attempts, and the best map as a `Flattening`.
"""

from .attempts import (
    Problem,
    ProblemOptions,
    Stage,
    StageResult,
    StageResults,
    build_result,
    run_stages,
    set_up_problem,
)
from .injective import describe_newton_steps, make_injective_map, make_isometric_map
from .stages import (
    ACTIVE_SET_RTOL,
    MAX_ACTIVE_SET_STEPS,
    STEP_AND_CHORD_RTOL,
    add_layout,
    continue_active_set,
    fall_back_to_linear,
    iterate_active_set,
    reach_prescribed_sums,
    run_anchored_abf,
    run_feasible_abf,
    solve_one_system,
)
