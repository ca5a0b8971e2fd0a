"""Attempts at a map, of increasing cost, until one has no flipped triangle.

In: a problem at its initial estimate. Out: the attempts that were made, and the best as a `Flattening`.
"""

from .attempts import (
    ACTIVE_SET_RTOL,
    MAX_ACTIVE_SET,
    ONE_SYSTEM_RTOL,
    Candidate,
    Problem,
    Stage,
    Tried,
    anchored,
    climb,
    continued,
    drawn,
    feasible,
    iterated,
    one_system,
    posed,
    prescribed,
)
from .injective import by_newton, injective_map, isometric_map
from .linear import linear_instead
from .preview import looked_at
from .reports import report
