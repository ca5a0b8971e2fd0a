"""The boundary layout: the boundary loop is drawn from its angles, both coordinates are harmonic inside."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from .._types import ComplexArray, FloatArray
from ..angles import Residual
from ..errors import FallbackWarning, stack_level
from ..linalg import Analysis, NotConvergedError, Pattern, Solvers
from ..surface import Topology, complex_positions, signed_double_areas


@dataclass(frozen=True, eq=False)
class Boundary:
    """The outer loop drawn from its angles.

    Attributes
    ----------
    z : (#loop,) complex128
        Positions of the vertices of `topology.loops[0]`, closed.
    gap : float
        By how much the loop failed to close, relative to its length.
    """

    z: ComplexArray
    gap: float


def develop_boundary(topology: Topology, b: Residual) -> Boundary:
    """Draw the outer loop from its exterior angles and the ratios of its successive edges.

    The exterior angles are shifted to sum to 2 pi, the logarithms of the ratios to sum to 0. The gap
    that remains is closed by the smallest change of lengths, min sum delta^2 / l.
    """
    loop = topology.loops[0]
    turning, log_ratio = b.turning[loop], b.log_ratio[loop]
    turning = turning + (2 * np.pi - turning.sum()) / len(loop)
    log_length = np.cumsum(log_ratio - log_ratio.mean())
    length = np.exp(log_length - log_length.max())
    edge = np.exp(1j * np.cumsum(turning))  # edge i leaves loop vertex i
    gap = (length * edge).sum()
    # delta = l Re(conj(edge) mu) closes it: a 2 by 2 system for mu
    u = np.stack((edge.real, edge.imag))
    mu = np.linalg.solve((u * length) @ u.T, -np.array([gap.real, gap.imag]))
    ends = np.cumsum(length * (1 + mu @ u) * edge)
    return Boundary(np.concatenate(([0], ends[:-1])), float(abs(gap) / length.sum()))


def harmonic(
    topology: Topology,
    boundary: Boundary,
    cot: FloatArray,
    pattern: Pattern,
    laplacian: Analysis | None,
    solvers: Solvers,
) -> tuple[ComplexArray, str]:
    """Both coordinates harmonic inside the drawn boundary, by the target angles' Laplacian.

    Returns the map and the solver's name.
    """
    z = np.zeros(topology.n, dtype=np.complex128)
    z[topology.loops[0]] = boundary.z
    if not pattern.n:
        return z, "none"
    weight = topology.sum_at_edges(cot) / 2
    lower = pattern.laplacian(weight)
    factored = (laplacian or solvers.laplacian(lower)).factor(lower)
    rhs = pattern.pull(weight, z[topology.edges.T])  # the inside being zero yet
    inside = topology.interior
    try:
        z[inside] = complex_positions(factored.solve(rhs))
    except NotConvergedError:
        good = False
    else:
        good = factored.exact or bool((signed_double_areas(z, topology.corner) > 0).all())
    if not good:
        # a map whose scale varies a lot needs more digits than multigrid gives
        warnings.warn(
            f"{factored.name} did not solve the layout without flipping triangles: the Laplacian is factored "
            "instead",
            FallbackWarning,
            stacklevel=stack_level(),
        )
        factored = solvers.whole(lower).factor(lower)
        z[inside] = complex_positions(factored.solve(rhs))
    return z, factored.name
