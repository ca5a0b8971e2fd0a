"""The conformal scale of a surface with cones: where the next cone helps most, and which angles they have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .._types import FloatArray, IntArray
from .cut_graph import ClosedSurface
from .expected import MAX_LOG_SCALE, expected_stretch


@dataclass(frozen=True, eq=False)
class ConeScale:
    """The logarithm u of the conformal scale that flattens a surface everywhere but at its cones.

    u is zero at the cones and at the boundary. With the curvature K, the cotangent Laplacian L, the
    cones' curvatures k and Green's functions g_i, which are zero at the ground,

        L u = -K + sum_i k_i e_i,    u = u_0 + sum_i k_i g_i,    u = 0 at the cones.

    So one factor serves for any number of cones. The ground is the boundary; on a closed surface it is
    the first cone, whose curvature is what Gauss-Bonnet leaves for it.

    Attributes
    ----------
    piece : ClosedSurface
    solve : callable
        L^-1 with zero at the ground, for (n,) or (n, k).
    first : int
        The node that is the ground; -1 where the boundary is.
    bare : (n,) float64
        u_0, with no cone but the ground.
    others : (#C,) int64
        The cones, without the ground.
    green : (#C, n) float64
        Their Green's functions.
    """

    piece: ClosedSurface
    solve: Callable[[FloatArray], FloatArray]
    first: int
    bare: FloatArray
    others: IntArray
    green: FloatArray

    @classmethod
    def of(cls, piece: ClosedSurface, first: int | None = None) -> ConeScale:
        """Without cones; on a closed surface with one, where the scale is farthest from its mean."""
        if piece.holes:
            first, ground = -1, np.arange(piece.holes)
        else:
            first = _farthest(piece) if first is None else first
            ground = np.array([first])
        solve = piece.zero_at_nodes.solver(ground)
        none = np.zeros(0, dtype=np.int64)
        return cls(piece, solve, first, solve(-piece.curvature), none, np.zeros((0, piece.n)))

    @classmethod
    def at(cls, piece: ClosedSurface, nodes: IntArray) -> ConeScale:
        """With these cones, of which there is one at least."""
        first = int(nodes[0])
        ground = cls.of(piece, first)
        return ground.with_cones(nodes[len(ground.nodes) :])

    def with_cones(self, nodes: IntArray) -> ConeScale:
        """With more cones."""
        unit = np.zeros((self.piece.n, len(nodes)))
        unit[nodes, np.arange(len(nodes))] = 1.0
        green = np.concatenate((self.green, self.solve(unit).T))
        return replace(self, others=np.append(self.others, nodes), green=green)

    @property
    def nodes(self) -> IntArray:
        """All cones."""
        return self.others if self.first < 0 else np.append(self.first, self.others)

    @cached_property
    def curvature(self) -> FloatArray:
        """The curvature of each of `nodes` with which the scale is one at all of them, radians."""
        k = np.linalg.solve(self.green[:, self.others], -self.bare[self.others])
        return np.asarray(k if self.first < 0 else np.append(self.piece.curvature.sum() - k.sum(), k))

    @cached_property
    def log_scale(self) -> FloatArray:
        """u, (n,)."""
        k = self.curvature if self.first < 0 else self.curvature[1:]
        return np.clip(self.bare + k @ self.green, -MAX_LOG_SCALE, MAX_LOG_SCALE)

    @property
    def stretch(self) -> float:
        """The L2 stretch that is expected of the map."""
        return expected_stretch(self.piece, self.log_scale)


def _farthest(piece: ClosedSurface) -> int:
    """The node where the scale that spreads all curvature evenly is farthest from its mean."""
    weight = piece.area / piece.area.sum()
    u = piece.zero_at_nodes.solve(np.array([0]), weight * piece.curvature.sum() - piece.curvature)
    return int(np.argmax(np.abs(u - weight @ u)))
