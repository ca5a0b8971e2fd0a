"""Moves of found cones, after which holonomy angles are nearly multiples of 90 degrees by themselves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ..cut_graphs import MAX_LOG_SCALE
from .component import ConeComponent
from .constants import (
    FULL_TURN,
    LEAST_MOVE_GAIN,
    MOVE_RADIUS,
    NEEDLE_DISTORTION,
    QUARTER_TURN,
    SAMPLED_NODES,
    STRETCH_PER_DISTORTION,
    STRETCH_PER_MOVE_DISTORTION,
    WIDE_CORNER,
)
from .quantisation import QuantisedCurvatures, quantise_holonomy
from .scale import ConeScale


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Places and curvatures of cones, and the holonomy angles that follow.

    Attributes
    ----------
    scale : ConeScale
        With these cones.
    k : (#C,) int64
        The curvature of each of its `nodes`, quarter turns.
    holonomy : (#paths,) float64
        Predicted holonomy angles, quarter turns.
    """

    scale: ConeScale
    k: IntArray
    holonomy: FloatArray

    @cached_property
    def _powers(self) -> tuple[FloatArray, FloatArray]:
        """Area shares times e^2u and e^-2u, with the log scale u."""
        area = self.scale.closed.area / self.scale.closed.area.sum()
        u = self.scale.log_scale_of(np.asarray(self.k * QUARTER_TURN))
        return area * np.exp(2 * u), area * np.exp(-2 * u)

    @cached_property
    def log_stretch(self) -> float:
        """The logarithm of the L2 stretch that is expected."""
        return float(sum(np.log(power.sum()) for power in self._powers)) / 2

    @cached_property
    def shares(self) -> tuple[FloatArray, FloatArray]:
        """Each node's shares p_+ and p_- in the sums of e^2u and e^-2u: d log stretch = (p_+ - p_-) du."""
        grown, shrunk = self._powers
        return grown / grown.sum(), shrunk / shrunk.sum()

    @cached_property
    def slope(self) -> FloatArray:
        """d log stretch by one radian more of curvature at each node, (n,)."""
        grown, shrunk = self.shares
        scale, share = self.scale, grown - shrunk
        share[np.arange(scale.closed.graph.n_holes) if scale.ground_cone < 0 else scale.ground_cone] = 0.0
        return scale.factored.solve(share)

    def at_nodes(self, nodes: IntArray, holonomy: FloatArray) -> Arrangement:
        """With the cones at other nodes; the ground stays."""
        scale = self.scale
        others = nodes if scale.ground_cone < 0 else nodes[1:]
        (new,) = np.nonzero(others != scale.others)
        unit, green = np.zeros((scale.closed.graph.n, len(new))), scale.green.copy()
        unit[others[new], np.arange(len(new))] = 1.0
        green[new] = scale.factored.solve(unit).T
        return Arrangement(replace(scale, others=others, green=green), self.k, holonomy)


@dataclass(frozen=True, eq=False)
class Ball:
    """The nodes near a cone to which it may move, and what each move changes.

    Attributes
    ----------
    cone : int
        Index among the cones.
    nodes : (m,) int64
        The cone's own comes first.
    way : (m, 3) float64
        Displacements to them, as shares of the surface's size.
    holonomy : (m, #paths) float64
        Changes of the holonomy angles, quarter turns.
    weighted : (m, #paths) float64
        The same times a root of the cost matrix: what missing holonomy costs is then a sum of squares.
    slope : (m,) float64
        Changes of the log stretch to first order.
    stiffness : float
        The second-order change of the log stretch is this times r^2 log(2 / r) at the distance r.
    cost : (m,) float64
        Both changes of the log stretch together.
    """

    cone: int
    nodes: IntArray
    way: FloatArray
    holonomy: FloatArray
    weighted: FloatArray
    slope: FloatArray
    stiffness: float
    cost: FloatArray

    @cached_property
    def gradients(self) -> FloatArray:
        """Gradients of `holonomy` and, last, of `slope`, (3, #paths + 1)."""
        values = np.column_stack((self.holonomy, self.slope))
        return np.asarray(np.linalg.lstsq(self.way, values)[0])

    @property
    def planar_stiffness(self) -> float:
        """The factor of r^2 where r is about half of the ball's radius."""
        return self.stiffness * float(np.log(4 / MOVE_RADIUS))


@dataclass(frozen=True, eq=False)
class ConeMoves:
    """Moves of cones that lower the expected stretch and the cost of missing holonomy together.

    A cone of k quarter turns that moves to another vertex changes each holonomy angle by k times the change
    of a harmonic function. So the coordinates of all cones serve the holonomy angles, two of each handle, and
    the map stays conformal (Abel's theorem). Without moves all triangles have to make up for what is missing,
    most of all those right at cones of large angles. A cone that crosses a path adds k whole quarter turns.

    Attributes
    ----------
    component : ConeComponent
    quantised : QuantisedCurvatures
        Of the cones where they were found.
    holonomy : HolonomyAngles
        Predicted for these; `by_vertex` is of all nodes.
    """

    component: ConeComponent
    quantised: QuantisedCurvatures
    holonomy: HolonomyAngles

    def best(self) -> Arrangement | None:
        """The arrangement for which stretch and missing holonomy cost least; None if none moves."""
        fixed = self._exchanged(self.holonomy.cost)
        if self._cost(fixed) < fixed.log_stretch + LEAST_MOVE_GAIN:
            return None
        free = self._exchanged(self._softened_stiffness / STRETCH_PER_DISTORTION / QUARTER_TURN**2)
        starts = [fixed] if np.array_equal(free.k, fixed.k) else [fixed, free]
        now = min((self._improved(start) for start in starts), key=self._cost)
        while True:
            further = self._improved(now)
            gain = self._cost(now) - self._cost(further)
            now = further if gain > 0 else now
            if gain < LEAST_MOVE_GAIN:
                break
        return now if self._cost(now) < self._cost(fixed) - LEAST_MOVE_GAIN else None

    def _exchanged(self, cost: FloatArray) -> Arrangement:
        """The cones where they were found, with quarter turns exchanged for this cost of missing holonomy."""
        found, by_node = self._found, self.holonomy.by_vertex[self._found.scale.nodes]
        k, _ = self.quantised.for_holonomy(replace(self.holonomy, by_vertex=by_node, cost=cost))
        change = k - found.k
        return replace(found, k=k, holonomy=found.holonomy - change @ by_node) if change.any() else found

    @cached_property
    def _found(self) -> Arrangement:
        quantised = self.quantised
        return Arrangement(quantised.scale, quantised.for_stretch, self.holonomy.angle / QUARTER_TURN)

    def _cost(self, now: Arrangement) -> float:
        """The log stretch, and what missing holonomy costs."""
        missing = now.holonomy - quantise_holonomy(now.holonomy[None], self._stiffness)[0]
        return now.log_stretch + float(missing @ self._stiffness @ missing)

    @cached_property
    def _stiffness(self) -> FloatArray:
        """What missing quarter turns cost in log stretch, (#paths, #paths).

        All triangles give, and those right at cones more easily: springs in series.
        """
        needles = np.eye(len(self.holonomy.cost)) / NEEDLE_DISTORTION
        return STRETCH_PER_MOVE_DISTORTION * _in_series(self.holonomy.cost * QUARTER_TURN**2, needles)

    @cached_property
    def _root(self) -> FloatArray:
        return np.asarray(np.linalg.cholesky(self._stiffness))

    @cached_property
    def _softened_stiffness(self) -> FloatArray:
        """The same where cones move as far as that costs less."""
        give = np.zeros_like(self._stiffness)
        for ball in self._balls(self._found):
            gradients = ball.gradients[:, :-1]
            give += gradients.T @ gradients / ball.planar_stiffness
        return _in_series(self._stiffness, give)

    def _improved(self, now: Arrangement) -> Arrangement:
        """All cones moved within their balls: solved for as in a plane, and then by coordinate descent."""
        balls = self._balls(now)
        if not balls:
            return now
        missing = (
            now.holonomy - quantise_holonomy(now.holonomy[None], self._softened_stiffness)[0]
        ) @ self._root
        gradients = np.concatenate([ball.gradients for ball in balls])
        turns = gradients[:, :-1] @ self._root
        stiff = np.repeat([2 * ball.planar_stiffness for ball in balls], 3)
        way = np.linalg.solve(np.diag(stiff) + 2 * turns @ turns.T, -gradients[:, -1] - 2 * turns @ missing)
        at = [
            int(np.argmin(((ball.way - aim) ** 2).sum(axis=1)))
            for ball, aim in zip(balls, way.reshape(-1, 3), strict=True)
        ]
        missing = missing + sum(ball.weighted[j] for ball, j in zip(balls, at, strict=True))
        least = np.inf
        while True:
            for i, ball in enumerate(balls):
                others = missing - ball.weighted[at[i]]
                at[i] = int(np.argmin(((others + ball.weighted) ** 2).sum(axis=1) + ball.cost))
                missing = others + ball.weighted[at[i]]
            cost = float(missing @ missing) + sum(ball.cost[j] for ball, j in zip(balls, at, strict=True))
            if not cost < least:
                break
            least = cost
        nodes, holonomy = now.scale.nodes.copy(), now.holonomy.copy()
        for ball, j in zip(balls, at, strict=True):
            nodes[ball.cone] = ball.nodes[j]
            holonomy += ball.holonomy[j]
        return now.at_nodes(nodes, holonomy)

    def _balls(self, now: Arrangement) -> list[Ball]:
        """Those of all cones but the ground, and those without curvature."""
        first = int(now.scale.ground_cone >= 0)
        return [self._ball(now, i) for i in range(first, len(now.k)) if now.k[i]]

    def _ball(self, now: Arrangement, i: int) -> Ball:
        """The ball of a cone, by the radius r after a conformal map, so that it is short on thin limbs.

        Green's function falls by log(r) / 2 pi.
        """
        closed, scale, k = self.component.closed, now.scale, int(now.k[i])
        c, green, size = scale.nodes[i], scale.green[i - (scale.ground_cone >= 0)], closed.area.sum()
        at, matrix = closed.graph.position, closed.graph.adjacency[0]
        ring = matrix.indices[matrix.indptr[c] : matrix.indptr[c + 1]]
        edge = np.linalg.norm(at[ring] - at[c], axis=1).mean() / np.sqrt(size)
        rim = green[ring].mean()  # at the distance of an edge
        nodes = np.flatnonzero(green > rim - np.log(MOVE_RADIUS / edge) / (2 * np.pi))
        others = np.delete(scale.nodes, i)
        gap = ((at[others] - at[c]) ** 2).sum(axis=1).min(initial=np.inf)
        fits = 4 * ((at[nodes] - at[c]) ** 2).sum(axis=1) < gap  # so two cones cannot meet
        fits &= (FULL_TURN - k) * QUARTER_TURN <= WIDE_CORNER * self.component.n_triangles[nodes]
        nodes = nodes[fits & (nodes >= closed.graph.n_holes) & (nodes != c)]
        nodes = np.append(c, nodes[:: max(1, -(-len(nodes) // SAMPLED_NODES))])
        way = (at[nodes] - at[c]) / np.sqrt(size)
        radius = edge * np.exp(np.minimum(2 * np.pi * (rim - green[nodes]), MAX_LOG_SCALE))
        radius[0] = 0.0
        change = self.holonomy.by_vertex[nodes] - self.holonomy.by_vertex[c]
        holonomy = -k * (change - np.round(change))
        density = max(2.0, size * float(sum(share[c] for share in now.shares)) / closed.area[c])
        stiffness = density * (k * QUARTER_TURN) ** 2 / (2 * np.pi)
        slope = k * QUARTER_TURN * (now.slope[nodes] - now.slope[c])
        square = radius**2 * np.log(2 / np.maximum(radius, np.finfo(float).tiny))
        cost = slope + stiffness * square
        return Ball(i, nodes, way, holonomy, holonomy @ self._root, slope, stiffness, cost)


def _in_series(stiffness: FloatArray, give: FloatArray) -> FloatArray:
    """The stiffness of a spring in series with one that yields by `give`."""
    both = np.linalg.inv(np.linalg.inv(stiffness) + give)
    return np.asarray(both + both.T) / 2
