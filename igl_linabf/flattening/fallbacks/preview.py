"""A look at the map of linear ABF's first two solves, before further steps close its boundary."""

from collections.abc import Callable
from dataclasses import replace

from ..._types import FloatArray
from ...angles import State
from ...errors import SingularSystemError
from ...layouts import develop_boundary
from ...surface import coordinates
from .attempts import Candidate, Problem, Stage, Tried, drawn

STEEP = 0.2  # residual, below which no tip of the surface is steep, and there is nothing to see


def looked_at(is_enough: Callable[[FloatArray], bool], gap: float) -> Stage:
    """The map of a disk after the first stage, if that is enough.

    It has no flips, and its boundary a relative gap of at most `gap`.
    """

    def stage(problem: Problem, tried: Tried) -> Candidate | None:
        made = _drawn(problem, tried[-1].state, gap)
        if made is None or made.layout is None or len(made.flipped):
            return None
        return made if is_enough(coordinates(made.layout.z)) else None

    return stage


def _drawn(problem: Problem, state: State, gap: float) -> Candidate | None:
    residual = state.at.residual
    if len(problem.mesh.topology.loops) > 1 or residual.at_vertices < STEEP:
        return None
    boundary = develop_boundary(problem.angles.constraints, residual)
    if boundary.gap > gap:
        return None
    try:
        as_drawn = replace(problem, layout="boundary")
        return drawn(as_drawn, "linear step", state, converged=False, boundary=boundary)
    except SingularSystemError:  # later stages have other angles
        return None
