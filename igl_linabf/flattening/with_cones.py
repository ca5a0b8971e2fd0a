"""A surface with cones: its angles are found on the surface itself, and laid out on the same surface cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .._runtime import stopwatch
from .._types import FloatArray
from ..angles import AngleProblem, ClosedPath, State, active_set, constraints_of, initial_estimate
from ..surface import Mesh, Topology
from .ladder import ACTIVE_SET_RTOL, MAX_ACTIVE_SET, Problem, Stage, anchored, climb, drawn, feasible
from .ladder import Candidate, Tried, injective_map, iterated, posed, report
from .methods import ABF, ABF_TOL, STAGES, LinABF, Method
from .result import Flattening

SEAM_TOL = 1e-10  # residual at which both sides of a seam are equally long to 1e-7 and better
TURNING_STEPS = 3  # after which the turning along a path is known to far less than a quarter turn


def flatten_with_cones(
    cut: Mesh,
    topology: Topology,
    sums: FloatArray,
    paths: Sequence[ClosedPath],
    quarter: bool,
    method: Method,
) -> Flattening:
    """Flatten a surface with prescribed angle sums.

    Parameters
    ----------
    cut : Mesh
        The surface cut to a disk along a seam through all cones.
    topology : Topology
        Of the surface before the cut; its faces are those of `cut`, in the same order.
    sums : (#V,) float64
        Angle sums of its vertices, radians; NaN at the boundary, which is free.
    paths : sequence of ClosedPath
        Along which the scale comes back.
    quarter : bool
        They turn by multiples of 90 degrees: the nearest ones to what they turn by freely.
    method : Method
        Linear ABF or converged ABF.

    Raises
    ------
    ValueError
        Another method.
    """
    if not isinstance(method, LinABF | ABF):
        raise ValueError(f"cones need a method that is based on angles, 'linabf' or 'abf', not {method.name!r}")
    with stopwatch(*STAGES) as seconds:
        problem = _posed(cut, topology, sums, paths, method)
        if quarter and paths:
            state = active_set(problem.start, ACTIVE_SET_RTOL, SEAM_TOL, TURNING_STEPS)
            problem = _posed(cut, topology, sums, [_in_quarters(path, state) for path in paths], method)
        tried = climb(problem, _stages(method))
        return report(problem, method.name, tried, seconds)


def _posed(
    cut: Mesh, topology: Topology, sums: FloatArray, paths: Sequence[ClosedPath], method: LinABF | ABF
) -> Problem:
    safeguard = method.safeguard if isinstance(method, LinABF) else True
    problem = posed(cut, None, method.layout, method.threshold, method.solver, safeguard)
    alpha = problem.surface
    estimate = initial_estimate(topology, alpha, method.threshold, safeguard, sums)
    constraints = constraints_of(replace(topology, n_outer=len(topology.loops)), sums, paths)
    angles = replace(problem.angles, constraints=constraints, estimate=estimate)
    return replace(problem, angles=angles, cut=problem.angles.constraints)


def _stages(method: LinABF | ABF) -> list[Stage]:
    rtol, most = ACTIVE_SET_RTOL, MAX_ACTIVE_SET
    if isinstance(method, LinABF):
        stages: list[Stage] = []
