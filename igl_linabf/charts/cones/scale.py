"""Compute the conformal scale of a surface with cones, which determines their positions and angles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...linalg import Factor, NotPositiveDefiniteError
from ..cut_graphs import MAX_LOG_SCALE, ClosedSurface, DirichletSolver, predict_conformal_stretch


@dataclass(frozen=True, eq=False)
class ConeScale:
    """The logarithm u of the conformal scale that flattens a surface everywhere except at its cones.

    u is zero at the cones and at the boundary. The *ground* is the boundary; on a closed surface it is the
    first cone, whose curvature follows from Gauss-Bonnet. With the curvature K, the cotangent Laplacian L,
    the curvatures k of the cones, and Green's functions g_i, which are zero at the ground,

        L u = -K + sum_i k_i e_i,    u = u_0 + sum_i k_i g_i,    u = 0 at the cones.

    Therefore L is factored only once, with zero at the ground, for any number of cones.

    Attributes
    ----------
    piece : ClosedSurface
    laplacian : DirichletSolver
        L with cotangent weights. The weights are clipped if L is not positive definite in double precision.
    factor : Factor
        The factorisation of L with zero at the ground.
    first : int
        The first cone if it is the ground; -1 if the boundary is the ground.
    bare : (n,) float64
        u_0, the logarithm of the scale without cones, or with the first cone if it is the ground.
    others : (#C,) int64
        The nodes of all cones except the ground.
    green : (#C, n) float64
        The Green's functions g_i of `others`.
    """

    piece: ClosedSurface
    laplacian: DirichletSolver
    factor: Factor
    first: int
    bare: FloatArray
    others: IntArray
    green: FloatArray

    @classmethod
    def with_least_cones(cls, piece: ClosedSurface, first: int | None = None) -> ConeScale:
        """Return the conformal scale without cones except, on a closed surface, the cone `first`.

        By default `first` is the node whose log scale is farthest from the mean if the curvature is
        distributed evenly.
        """
        if piece.graph.n_holes:
            first = -1
        elif first is None:
            first = _find_farthest(piece)
        ground, bare = _find_ground_nodes(piece, first), -piece.curvature
        laplacian = piece.laplacian.unclipped_dirichlet_solver
        try:
            factor = laplacian.factor(ground)
        except NotPositiveDefiniteError:
            laplacian = piece.laplacian.dirichlet_solver
            factor = laplacian.factor(ground)
        bare[ground] = 0.0
        none = np.zeros(0, dtype=np.int64)
        return cls(piece, laplacian, factor, first, factor.solve(bare), none, np.zeros((0, piece.graph.n)))

    @classmethod
    def from_nodes(cls, piece: ClosedSurface, nodes: IntArray) -> ConeScale:
        """Return the conformal scale with cones at `nodes`, at least one."""
        first = int(nodes[0])
        ground = cls.with_least_cones(piece, first)
        return ground.add_cones(nodes[len(ground.nodes) :])

    def add_cones(self, nodes: IntArray) -> ConeScale:
        """Return the conformal scale with additional cones at `nodes`."""
        unit = np.zeros((self.piece.graph.n, len(nodes)))
        unit[nodes, np.arange(len(nodes))] = 1.0
        green = np.concatenate((self.green, self.factor.solve(unit).T))
        return replace(self, others=np.append(self.others, nodes), green=green)

    @property
    def nodes(self) -> IntArray:
        """The nodes of all cones."""
        return self.others if self.first < 0 else np.append(self.first, self.others)

    @property
    def ground_free_factor(self) -> Factor | None:
        """Factorisation of the Laplacian without the ground nodes; None if weights were clipped."""
        zero, piece = self.laplacian, self.piece
        if zero is not piece.laplacian.unclipped_dirichlet_solver or zero is piece.laplacian.dirichlet_solver:
            return None
        free = zero.mask_free_nodes(_find_ground_nodes(piece, self.first))

        def solve_without_ground(b: FloatArray) -> FloatArray:
            every = np.zeros((len(free), *b.shape[1:]))
            every[free] = b
            return np.asarray(self.factor.solve(every)[free])

        return replace(self.factor, solve=solve_without_ground)

    @cached_property
    def cone_curvatures(self) -> FloatArray:
        """Curvatures of the cones `nodes`, radians, that make the conformal scale 1 at all cones."""
        k = np.linalg.solve(self.green[:, self.others], -self.bare[self.others])
        return np.asarray(k if self.first < 0 else np.append(self.piece.curvature.sum() - k.sum(), k))

    @cached_property
    def log_scale(self) -> FloatArray:
        """Logarithm u of the scale at each node, (n,)."""
        return self.compute_log_scale(self.cone_curvatures)

    def compute_log_scale(self, curvature: FloatArray) -> FloatArray:
        """Return the log scale, (n,), for given curvatures of the cones, radians; 0 at the ground."""
        k = curvature if self.first < 0 else curvature[1:]
        return np.clip(self.bare + k @ self.green, -MAX_LOG_SCALE, MAX_LOG_SCALE)

    @property
    def expected_stretch(self) -> float:
        """Expected L2 stretch of the conformal map with these cones."""
        return predict_conformal_stretch(self.piece, self.log_scale)

    @property
    def log_scale_deviation(self) -> float:
        """Standard deviation of the log scale u over the surface."""
        weight = self.piece.area / self.piece.area.sum()
        u = self.log_scale - weight @ self.log_scale
        return float(np.sqrt(weight @ u**2))


def _find_ground_nodes(piece: ClosedSurface, first: int) -> IntArray:
    """Return the nodes where the log scale is 0: the holes or, on a closed surface, the first cone."""
    return np.arange(piece.graph.n_holes) if first < 0 else np.array([first])


def _find_farthest(piece: ClosedSurface) -> int:
    """Distribute the curvature evenly; return the node where the log scale is farthest from its mean."""
    weight = piece.area / piece.area.sum()
    u = piece.laplacian.dirichlet_solver.solve(
        np.array([0]), weight * piece.curvature.sum() - piece.curvature
    )
    return int(np.argmax(np.abs(u - weight @ u)))
