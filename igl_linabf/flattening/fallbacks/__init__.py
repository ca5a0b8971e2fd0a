"""Attempts at a map, of increasing cost, until one has no flipped triangle.

In: a problem at its initial estimate. Out: the attempts that were made, and the best as a `Flattening`.
"""

from .attempts import (
    Problem,
    ProblemOptions,
    Stage,
    StageResult,
    StageResults,
    build_result,
    initial_problem,
    run_stages,
)
from .constants import ACTIVE_SET_RTOL, LARGEST_FOR_ABF, MAX_ACTIVE_SET_STEPS, STEP_AND_CHORD_RTOL
from .injective import by_newton, injective_map, isometric_map
from .stages import (
    anchored,
    continued,
    feasible,
    iterated,
    linear_fallback,
    one_system,
    prescribed,
    with_layout,
)
