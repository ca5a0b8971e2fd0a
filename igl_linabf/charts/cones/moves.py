"""Cones moved along the surface until closed paths turn by nearly whole quarters of themselves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ..cut_graphs import MAX_LOG_SCALE
from . import constants
from .constants import QUARTER_TURN
from .placement import ConeComponent
from .quantisation import QuantisedCurvatures, quantise_holonomy
from .scale import ConeScale


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Cones with curvatures in quarter turns, and what follows from them.

    Attributes
    ----------
    scale : ConeScale
        With these cones.
    k : (#C,) int64
        Curvature of each of its `nodes`, quarter turns.
    path_turns : (#paths,) float64
        Holonomy angle of each closed path, quarter turns.
    """

    scale: ConeScale
    k: IntArray
    path_turns: FloatArray

    @cached_property
    def log_scale(self) -> FloatArray:
        return self.scale.log_scale_of(np.asarray(self.k * QUARTER_TURN))

    @cached_property
    def _powers(self) -> tuple[FloatArray, FloatArray]:
        area = self.scale.piece.area / self.scale.piece.area.sum()
        return area * np.exp(2 * self.log_scale), area * np.exp(-2 * self.log_scale)

    @cached_property
    def log_stretch(self) -> float:
        return float(sum(np.log(power.sum()) for power in self._powers)) / 2

    @cached_property
    def shares(self) -> tuple[FloatArray, FloatArray]:
        """Shares of each node in the sums of squares of the scale and of its inverse, both by area.

        The log stretch changes by the first less the second, times the change of the log scale.
        """
        grown, shrunk = self._powers
        return grown / grown.sum(), shrunk / shrunk.sum()

    @cached_property
    def slope(self) -> FloatArray:
        """Change of the log stretch by a radian of curvature at each node, to first order, (n,)."""
        grown, shrunk = self.shares
        scale, share = self.scale, grown - shrunk
        share[np.arange(scale.piece.graph.n_holes) if scale.first < 0 else scale.first] = 0.0
        return scale.factored.solve(share)

    def moved(self, nodes: IntArray, path_turns: FloatArray) -> Arrangement:
        """With the cones at other nodes; the ground stays."""
        scale = self.scale
        others = nodes if scale.first < 0 else nodes[1:]
        (new,) = np.nonzero(others != scale.others)
        unit, green = np.zeros((scale.piece.graph.n, len(new))), scale.green.copy()
        unit[others[new], np.arange(len(new))] = 1.0
        green[new] = scale.factored.solve(unit).T
        return Arrangement(replace(scale, others=others, green=green), self.k, path_turns)


@dataclass(frozen=True, eq=False)
class Ball:
    """The nodes around a cone to which it may move in one round.

    Attributes
    ----------
    cone : int
        Its number.
    nodes : (m,) int64
        The cone's own comes first.
    way : (m, 3) float64
        From the cone to each node, over the square root of the surface's area.
    path_turns : (m, #paths) float64
        By how many quarters each closed path turns more, with the cone at that node.
    weighed_turns : (m, #paths) float64
        The same in coordinates in which the sum of their squares is their cost.
    slope : (m,) float64
        Change of the log stretch to first order.
    stiffness : float
        Of second order: the change over r² log(2 / r), with the conformal radius r.
    price : (m,) float64
        Change of the log stretch to second order.
    """

    cone: int
    nodes: IntArray
    way: FloatArray
    path_turns: FloatArray
    weighed_turns: FloatArray
    slope: FloatArray
    stiffness: float
    price: FloatArray

    @cached_property
    def slopes(self) -> FloatArray:
        """Gradients by the way of `path_turns` and of `slope`, (3, #paths + 1), by least squares."""
        few = slice(None, None, max(1, len(self.nodes) // constants.FITTED_VERTICES))
        values = np.column_stack((self.path_turns, self.slope))
        return np.asarray(np.linalg.lstsq(self.way[few], values[few], rcond=constants.SLOPES_RTOL)[0])

    def nearest(self, way: FloatArray) -> int:
        """The number of the node at the end of this way."""
        return int(np.argmin(((self.way - way) ** 2).sum(axis=1)))


@dataclass(frozen=True, eq=False)
class ConeMoves:
    """Moves of cones for which closed paths turn by nearly whole quarters.

    If a cone of curvature k goes from one vertex to another, the angle by which a path turns changes by k
    times the difference of a harmonic function. Each handle has two paths, and each cone two coordinates: so
    moves alone can make all paths turn by quarters, and the map stays conformal (Abel's theorem). Without
    moves, all triangles have to change their angles for it, most of all those at cones of large angles. A
    path that a cone crosses turns by k quarters more, which are whole ones.

    Attributes
    ----------
    place : ConeComponent
    quarters : QuantisedCurvatures
        Of the cones where they were found.
    holonomy : HolonomyAngles
        With these; `by_vertex` has a row for each node.
    """

    place: ConeComponent
    quarters: QuantisedCurvatures
    holonomy: HolonomyAngles

    def best(self) -> Arrangement | None:
        """The cones for which stretch and missing quarters cost least; None if moves save too little."""
        fixed = self._exchanged(self.holonomy.cost)
        if fixed.log_stretch > constants.MAX_MOVED_LOG_STRETCH:
            return None
        if self._cost(fixed) < fixed.log_stretch + constants.MIN_MISSING_COST:
            return None
        free = self._exchanged(self._softened / constants.DISTORTION_PER_LOG_STRETCH / QUARTER_TURN**2)
        starts = [fixed] if np.array_equal(free.k, fixed.k) else [fixed, free]
        now = min((self._further(start) for start in starts), key=self._cost)
        for _ in range(constants.MAX_MOVE_ROUNDS - 1):
            further = self._further(now)
            gain = self._cost(now) - self._cost(further)
            now = further if gain > 0 else now
            if gain < constants.MIN_MOVE_GAIN:
                break
        return now if self._cost(now) < self._cost(fixed) - constants.MIN_MOVE_GAIN else None

    def _exchanged(self, cost: FloatArray) -> Arrangement:
        """The cones where they were found, with quarter turns exchanged for this cost of missing quarters."""
        found, by_node = self._found, self.holonomy.by_vertex[self._found.scale.nodes]
        k, _ = self.quarters.for_paths(replace(self.holonomy, by_vertex=by_node, cost=cost))
        change = k - found.k
        return replace(found, k=k, path_turns=found.path_turns - change @ by_node) if change.any() else found

    @cached_property
    def _found(self) -> Arrangement:
        return Arrangement(self.quarters.scale, self.quarters.for_stretch, self.holonomy.angle / QUARTER_TURN)

    def _cost(self, now: Arrangement) -> float:
        """The log stretch, and what is missing to whole quarters of paths, in the same unit."""
        missing = now.path_turns - quantise_holonomy(now.path_turns[None], self._stiff)[0]
        return now.log_stretch + float(missing @ self._stiff @ missing)

    @cached_property
    def _stiff(self) -> FloatArray:
        """The quadratic form of what quarters that paths miss cost, as log stretch, (#paths, #paths)."""
        cost = self.holonomy.cost * QUARTER_TURN**2
        least = constants.COST_DAMPING * np.trace(cost) * np.eye(len(cost))
        return constants.MISSING_TURN_PER_LOG_STRETCH * _in_series(
            cost + least, np.eye(len(cost)) / constants.MAX_QUARTER_DISTORTION
        )

    @cached_property
    def _root(self) -> FloatArray:
        return np.asarray(np.linalg.cholesky(self._stiff))

    @cached_property
    def _softened(self) -> FloatArray:
        """The same form where cones may move for it: each move takes up a part, like a spring in series."""
        give = np.zeros_like(self._stiff)
        for ball in self._balls(self._found):
            slopes = ball.slopes[:, :-1]
            give += slopes.T @ slopes / (ball.stiffness * np.log(4 / constants.BALL_RADIUS))
        return _in_series(self._stiff, give)

    def _further(self, now: Arrangement) -> Arrangement:
        """The cones at those nodes of their balls that cost least.

        First all ways together are the minimum of a quadratic form, with balls taken as flat. Then each
        cone in turn goes to its best node, until a sweep over them gains little.
        """
        balls = self._balls(now)
        if not balls:
            return now
        missing = (now.path_turns - quantise_holonomy(now.path_turns[None], self._softened)[0]) @ self._root
        slopes = np.concatenate([ball.slopes for ball in balls])
        turns = slopes[:, :-1] @ self._root
        stiff = np.repeat([2 * ball.stiffness * np.log(4 / constants.BALL_RADIUS) for ball in balls], 3)
        way = np.linalg.solve(np.diag(stiff) + 2 * turns @ turns.T, -slopes[:, -1] - 2 * turns @ missing)
        at = [ball.nearest(there) for ball, there in zip(balls, way.reshape(-1, 3), strict=True)]
        missing = missing + sum(ball.weighed_turns[j] for ball, j in zip(balls, at, strict=True))
        least = np.inf
        for _ in range(constants.MAX_SWEEPS):
            for i, ball in enumerate(balls):
                others = missing - ball.weighed_turns[at[i]]
                at[i] = int(np.argmin(((others + ball.weighed_turns) ** 2).sum(axis=1) + ball.price))
                missing = others + ball.weighed_turns[at[i]]
            cost = float(missing @ missing) + sum(ball.price[j] for ball, j in zip(balls, at, strict=True))
            if not cost < least - constants.MIN_SWEEP_GAIN:
                break
            least = cost
        nodes, path_turns = now.scale.nodes.copy(), now.path_turns.copy()
        for ball, j in zip(balls, at, strict=True):
            nodes[ball.cone] = ball.nodes[j]
            path_turns += ball.path_turns[j]
        return now.moved(nodes, path_turns)

    def _balls(self, now: Arrangement) -> list[Ball]:
        """Of all cones but the ground, and but those without curvature, whose moves change nothing."""
        first = int(now.scale.first >= 0)
        return [self._ball(now, i) for i in range(first, len(now.k)) if now.k[i]]

    def _ball(self, now: Arrangement, i: int) -> Ball:
        """The ball of cone i, by conformal radii.

        In a plane Green's function falls by log r / 2 pi with the distance r; along a limb it falls evenly.
        So the radius r that belongs to its value is that of a conformal map, and grows fast along limbs.
        """
        piece, scale, k = self.place.piece, now.scale, int(now.k[i])
        c, green, size = scale.nodes[i], scale.green[i - (scale.first >= 0)], piece.area.sum()
        at, matrix = piece.graph.position, piece.graph.adjacency[0]
        ring = matrix.indices[matrix.indptr[c] : matrix.indptr[c + 1]]
        edge = np.linalg.norm(at[ring] - at[c], axis=1).mean() / np.sqrt(size)
        rim = green[ring].mean()  # at the distance of an edge
        nodes = np.flatnonzero(green > rim - np.log(constants.BALL_RADIUS / edge) / (2 * np.pi))
        others = np.delete(scale.nodes, i)
        gap = ((at[others] - at[c]) ** 2).sum(axis=1).min(initial=np.inf)
        fits = ((at[nodes] - at[c]) ** 2).sum(axis=1) < constants.MAX_WAY_TO_CONE**2 * gap
        fits &= (4 - k) * QUARTER_TURN <= constants.MAX_ANGLE_AT_CONE * self.place.valence[nodes]
        nodes = nodes[fits & (nodes >= piece.graph.n_holes) & (nodes != c)]
        nodes = np.append(c, nodes[:: max(1, -(-len(nodes) // constants.MAX_BALL_VERTICES))])
        way = (at[nodes] - at[c]) / np.sqrt(size)
        radius = edge * np.exp(np.minimum(2 * np.pi * (rim - green[nodes]), MAX_LOG_SCALE))
        radius[0] = 0.0
        change = self.holonomy.by_vertex[nodes] - self.holonomy.by_vertex[c]
        path_turns = -k * (change - np.round(change))
        density = max(2.0, size * float(sum(share[c] for share in now.shares)) / piece.area[c])
        stiffness = density * (k * QUARTER_TURN) ** 2 / (2 * np.pi)
        slope = k * QUARTER_TURN * (now.slope[nodes] - now.slope[c])
        square = radius**2 * np.log(2 / np.maximum(radius, np.finfo(float).tiny))
        return Ball(
            i, nodes, way, path_turns, path_turns @ self._root, slope, stiffness, slope + stiffness * square
        )


def _in_series(stiff: FloatArray, give: FloatArray) -> FloatArray:
    """The stiffness of a spring in series with one whose compliance is `give`."""
    both = np.linalg.inv(np.linalg.inv(stiff) + give)
    return np.asarray(both + both.T) / 2
