"""Steps within small patches, where a few triangles alone are far from what is asked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..._core import undirected
from ..._types import BoolArray, FloatArray, IntArray
from ...errors import SingularSystemError
from ...linalg import Solvers
from ...surface import Topology, compact
from ..system import Constraints, Pattern
from .iterates import AngleProblem, Step
from .iterations import State
from .linearisation import advance, linearise, solve

SMALL, SMALL_WITH_PATHS = 2_000, 10_000  # rows up to which a step of the whole surface takes as little time
FAR = 0.1  # of a step that is followed by them
RINGS = 4  # of triangles around such rows
LARGEST = 1 / 8  # share of all rows that patches may have: they are solved directly
NEAR = 0.2  # share of that at which the steps within them end
MOST = 4  # of these


def eliminate_locally(state: State, far: float = FAR) -> State:
    """The state after steps within patches around the rows that miss most; the other angles stay.

    A step that is cut short in few triangles leaves much there, and next to nothing elsewhere. Further steps
    of the whole surface would only serve these. So they are taken there alone (nonlinear elimination, Cai and
    Keyes 2002): what is missing comes to the rims of the patches, spread along them. Where patches would be
    large, the surface is small, or nothing is gained, the state stays as it is. `far` is the residual of a
    row from which a patch is laid around it.
    """
    before = state.at.residual
    if len(before.vertex) < (SMALL_WITH_PATHS if state.problem.constraints.paths else SMALL):
        return state
    inside = _patches(state.problem.constraints, np.maximum(np.abs(before.vertex), np.abs(before.wheel)), far)
    if inside is None:
        return state
    faces, problem = _problem(state, inside)
    at, cut, lin = problem.start, 0, None
    try:
        for _ in range(MOST):
            lin = linearise(problem, at, reuse=lin)
            at, step, _ = advance(problem, at, solve(lin, at, 0.0), "patches")
            cut = step.limited
            if at.residual.at_vertices <= NEAR * far:
                break
    except SingularSystemError:
        return state
    alpha = state.at.alpha.copy()
    alpha[:, faces] = at.alpha
    after = state.problem.at(alpha)
    if not after.residual.at_vertices < before.at_vertices:
        return state
    made = Step("patches", 0, cut, after.residual.largest)
    return replace(state, at=after, steps=(*state.steps, made))


def _patches(constraints: Constraints, missing: FloatArray, far: float) -> BoolArray | None:
    """(#V,) bool: the vertices inside of patches; None if there are none, or many."""
    row, corner = constraints.row, constraints.topology.corner
    of_one = np.bincount(row + 1, minlength=constraints.n + 1)[1:] == 1
    own = np.append(of_one, False).take(row, mode="wrap")
    inside = own & np.append(missing > far, False).take(row, mode="wrap")
    for _ in range(RINGS if inside.any() else 0):
        wider = np.zeros_like(inside)
        wider[corner[:, _touched(corner, inside)]] = True
        inside = wider & own
        if np.count_nonzero(inside) > LARGEST * constraints.n:
            return None
    return inside if inside.any() else None


def _touched(corner: IntArray, inside: BoolArray) -> IntArray:
    """The faces at some vertices."""
    return np.flatnonzero(inside.take(corner).any(axis=0))


def _problem(state: State, inside: BoolArray) -> tuple[IntArray, AngleProblem]:
    """The faces around some vertices, and the problem of the constraints at these vertices alone."""
    constraints = state.problem.constraints
    corner, row = constraints.topology.corner, constraints.row
    faces = _touched(corner, inside)
    used, F = compact(corner[:, faces].T, constraints.topology.n)
    corner = np.ascontiguousarray(F.T)
    edges, sides, _ = undirected(corner, len(used))
    topology = Topology(len(used), corner, edges, sides, ())  # its rim is no boundary: it has no row
    rows = np.sort(row[inside])
    own = np.where(inside[used], np.searchsorted(rows, row[used]), -1)
    wheels = int(np.searchsorted(rows, constraints.wheels))
    target = constraints.target_at(state.at.residual.log_ratio)[rows]
    pattern = Pattern(topology, own, len(target))
    here = Constraints(topology, own, target, constraints.sums[used], wheels, pattern)
    return faces, AngleProblem(here, state.at.alpha[:, faces], Solvers("direct"))
