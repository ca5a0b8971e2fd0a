"""Local elimination: steps within patches around the few triangles that are far from their constraints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..._core import undirected
from ..._types import BoolArray, FloatArray, IntArray
from ...errors import SingularSystemError
from ...linalg import Solvers
from ...surface import Topology, compact
from ..system import Constraints, Pattern
from .constants import (
    LARGE_FOR_PATCHES,
    LARGE_FOR_PATCHES_WITH_PATHS,
    LARGEST_PATCHES,
    PATCH_END,
    PATCH_RESIDUAL,
    PATCH_RINGS,
    PATCH_STEPS,
)
from .iterates import AngleProblem, Step
from .iterations import State
from .linearisation import advance, linearise, solve


def eliminate_locally(state: State, far: float = PATCH_RESIDUAL) -> State:
    """The state after steps within patches around the rows with large residuals; the other angles stay.

    After a step that was limited in few triangles, much is missing there, and next to nothing elsewhere. More
    steps of the whole surface would serve these triangles alone. Steps within patches cost less (nonlinear
    elimination, Cai and Keyes 2002): what is missing comes to the rims of the patches, spread along them.
    Where the surface is small, patches would be large, or nothing is gained, the state stays as it is.
    Patches are laid around the rows with residuals above `far`.
    """
    constraints, before = state.problem.constraints, state.at.residual
    if constraints.n < (LARGE_FOR_PATCHES_WITH_PATHS if constraints.paths else LARGE_FOR_PATCHES):
        return state
    inside = _patch_vertices(constraints, np.maximum(np.abs(before.vertex), np.abs(before.wheel)), far)
    if inside is None:
        return state
    faces, problem = _patch_problem(state, inside)
    at, limited, lin = problem.start, 0, None
    try:
        for _ in range(PATCH_STEPS):
            lin = linearise(problem, at, reuse=lin)
            at, step, _ = advance(problem, at, solve(lin, at, 0.0), "patches")
            limited = step.limited
            if at.residual.at_vertices <= PATCH_END * far:
                break
    except SingularSystemError:
        return state
    alpha = state.at.alpha.copy()
    alpha[:, faces] = at.alpha
    after = state.problem.at(alpha)
    if not after.residual.at_vertices < before.at_vertices:
        return state
    made = Step("patches", 0, limited, after.residual.largest)
    return replace(state, at=after, steps=(*state.steps, made))


def _patch_vertices(constraints: Constraints, missing: FloatArray, far: float) -> BoolArray | None:
    """(#V,) bool: the vertices inside of patches; None if there are none, or too many."""
    row, corner = constraints.row, constraints.topology.corner
    vertices_of_row = np.bincount(row + 1, minlength=constraints.n + 1)[1:]
    own = np.append(vertices_of_row == 1, False).take(row, mode="wrap")
    inside = own & np.append(missing > far, False).take(row, mode="wrap")
    for _ in range(PATCH_RINGS if inside.any() else 0):
        wider = np.zeros_like(inside)
        wider[corner[:, _faces_at(corner, inside)]] = True
        inside = wider & own
        if np.count_nonzero(inside) > LARGEST_PATCHES * constraints.n:
            return None
    return inside if inside.any() else None


def _faces_at(corner: IntArray, inside: BoolArray) -> IntArray:
    """The faces at some vertices."""
    return np.flatnonzero(inside.take(corner).any(axis=0))


def _patch_problem(state: State, inside: BoolArray) -> tuple[IntArray, AngleProblem]:
    """The faces around some vertices, and the problem of the constraints at these vertices alone."""
    constraints = state.problem.constraints
    corner, row = constraints.topology.corner, constraints.row
    faces = _faces_at(corner, inside)
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
