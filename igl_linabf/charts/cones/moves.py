"""Found cones moved along the surface, so that closed paths turn by nearly whole quarters of themselves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ..cut_graphs import MAX_LOG_SCALE
from .placement import WIDE, ConeComponent
from .quantisation import FIDELITY, QUARTER_TURN, QuantisedCurvatures, quantise_holonomy
from .scale import ConeScale

BENT = 200.0  # growth of the log stretch as bad as one of F/3nt by one: missing turns bend needles
NEEDLES = 0.02  # F/3nt of a quarter turn that the triangles right at cones give for: more it never costs
BALL = 0.3  # radius of the balls within which cones move; lengths are shares of the surface's size
APART = 0.4  # share of the way to the nearest other cone that one may go
CANDIDATES, FITTED = 1_500, 200  # vertices of a ball that are tried; and to which its slopes are fitted
ROUNDS, SWEEPS = 4, 30
LITTLE = 0.05  # cost of missing turns for which none moves
LEAST_GAIN = 0.01  # of a round, for another one
SETTLED = 1e-4  # gain of a sweep, for another one
LARGEST = 3.0  # log stretch above which the linear expectation does not hold
SLOPES_RTOL = 0.05  # of singular values: a ball has two directions, and hardly a third one
ROUNDING = 1e-12  # of the cost's trace


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Cones in quarter turns.

    Attributes
    ----------
    scale : ConeScale
        With these cones.
    k : (#C,) int64
        Curvature of each of its `nodes`, quarter turns.
    turned : (#paths,) float64
        What paths turn by, quarter turns.
    """

    scale: ConeScale
    k: IntArray
    turned: FloatArray

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
        """Each node's share of the map's area, and of what shrinks: d log stretch = (one - other) du."""
        grown, shrunk = self._powers
        return grown / grown.sum(), shrunk / shrunk.sum()

    @cached_property
    def slope(self) -> FloatArray:
        """d log stretch by one radian of curvature at each node, (n,)."""
        grown, shrunk = self.shares
        scale, share = self.scale, grown - shrunk
        share[np.arange(scale.piece.graph.n_holes) if scale.first < 0 else scale.first] = 0.0
        return scale.factored.solve(share)

    def moved(self, nodes: IntArray, turned: FloatArray) -> Arrangement:
        """With the cones at other nodes; the ground stays."""
        scale = self.scale
        others = nodes if scale.first < 0 else nodes[1:]
        (new,) = np.nonzero(others != scale.others)
        unit, green = np.zeros((scale.piece.graph.n, len(new))), scale.green.copy()
        unit[others[new], np.arange(len(new))] = 1.0
        green[new] = scale.factored.solve(unit).T
        return Arrangement(replace(scale, others=others, green=green), self.k, turned)


@dataclass(frozen=True, eq=False)
class Ball:
    """Where a cone may go.

    Attributes
    ----------
    cone : int
        Its number.
    nodes : (m,) int64
        The cone's own comes first.
    way : (m, 3) float64
        To them.
    turned : (m, #paths) float64
        By how many quarters paths turn more then.
    turns : (m, #paths) float64
        The same, weighed so that their squares are what that costs.
    slope : (m,) float64
        Change of the log stretch to first order.
    stiffness : float
        Its growth by the square of the way, but for a logarithm.
    price : (m,) float64
        All of that change.
    """

    cone: int
    nodes: IntArray
    way: FloatArray
    turned: FloatArray
    turns: FloatArray
    slope: FloatArray
    stiffness: float
    price: FloatArray

    @cached_property
    def slopes(self) -> FloatArray:
        """Of `turned` and `slope`, (3, #paths + 1)."""
        few = slice(None, None, max(1, len(self.nodes) // FITTED))
        values = np.column_stack((self.turned, self.slope))
        return np.asarray(np.linalg.lstsq(self.way[few], values[few], rcond=SLOPES_RTOL)[0])

    def nearest(self, way: FloatArray) -> int:
        return int(np.argmin(((self.way - way) ** 2).sum(axis=1)))


@dataclass(frozen=True, eq=False)
class ConeMoves:
    """What moves of cones change.

    A cone of curvature k that goes from one vertex to another changes what paths turn by, and by k times the
    change of a harmonic function. So the coordinates of all cones serve the turnings, two of each handle, and
    the map stays conformal (Abel's theorem). Else all triangles have to give, and most of all those right at
    cones of large angles. A path that a cone crosses turns by k quarters more, which is as good.

    Attributes
    ----------
    place : ConeComponent
    quarters : QuantisedCurvatures
        Of the cones where they were found.
    turnings : Turnings
        There; `by_vertex` is of all nodes.
    """

    place: ConeComponent
    quarters: QuantisedCurvatures
    holonomy: HolonomyAngles

    def best(self) -> Arrangement | None:
        """The cones for which stretch and missing turns cost least; None if they had better stay."""
        fixed = self._exchanged(self.holonomy.cost)
        if fixed.log_stretch > LARGEST or self._cost(fixed) < fixed.log_stretch + LITTLE:
            return None
        free = self._exchanged(self._softened / FIDELITY / QUARTER_TURN**2)
        starts = [fixed] if np.array_equal(free.k, fixed.k) else [fixed, free]
        now = min((self._further(start) for start in starts), key=self._cost)
        for _ in range(ROUNDS - 1):
            further = self._further(now)
            gain = self._cost(now) - self._cost(further)
            now = further if gain > 0 else now
            if gain < LEAST_GAIN:
                break
        return now if self._cost(now) < self._cost(fixed) - LEAST_GAIN else None

    def _exchanged(self, cost: FloatArray) -> Arrangement:
        """The cones where they were found, with quarter turns for this cost of missing ones."""
        found, by_node = self._found, self.holonomy.by_vertex[self._found.scale.nodes]
        k, _ = self.quarters.for_paths(replace(self.holonomy, by_vertex=by_node, cost=cost))
        change = k - found.k
        return replace(found, k=k, turned=found.turned - change @ by_node) if change.any() else found

    @cached_property
    def _found(self) -> Arrangement:
        return Arrangement(self.quarters.scale, self.quarters.for_stretch, self.holonomy.angle / QUARTER_TURN)

    def _cost(self, now: Arrangement) -> float:
        """The log stretch, and what missing turns cost."""
        missing = now.turned - quantise_holonomy(now.turned[None], self._stiff)[0]
        return now.log_stretch + float(missing @ self._stiff @ missing)

    @cached_property
    def _stiff(self) -> FloatArray:
        """What missing quarter turns cost in log stretch, (#paths, #paths)."""
        cost = self.holonomy.cost * QUARTER_TURN**2
        least = ROUNDING * np.trace(cost) * np.eye(len(cost))
        return BENT * _in_series(cost + least, np.eye(len(cost)) / NEEDLES)

    @cached_property
    def _root(self) -> FloatArray:
        return np.asarray(np.linalg.cholesky(self._stiff))

    @cached_property
    def _softened(self) -> FloatArray:
        """The same if cones go as far as that costs less."""
        give = np.zeros_like(self._stiff)
        for ball in self._balls(self._found):
            slopes = ball.slopes[:, :-1]
            give += slopes.T @ slopes / (ball.stiffness * np.log(4 / BALL))
        return _in_series(self._stiff, give)

    def _further(self, now: Arrangement) -> Arrangement:
        """The cones at the vertices of their balls that cost least: as in a plane, and then tried in turn."""
        balls = self._balls(now)
        if not balls:
            return now
        missing = (now.turned - quantise_holonomy(now.turned[None], self._softened)[0]) @ self._root
        slopes = np.concatenate([ball.slopes for ball in balls])
        turns = slopes[:, :-1] @ self._root
        stiff = np.repeat([2 * ball.stiffness * np.log(4 / BALL) for ball in balls], 3)
        way = np.linalg.solve(np.diag(stiff) + 2 * turns @ turns.T, -slopes[:, -1] - 2 * turns @ missing)
        at = [ball.nearest(there) for ball, there in zip(balls, way.reshape(-1, 3), strict=True)]
        missing = missing + sum(ball.turns[j] for ball, j in zip(balls, at, strict=True))
        least = np.inf
        for _ in range(SWEEPS):
            for i, ball in enumerate(balls):
                others = missing - ball.turns[at[i]]
                at[i] = int(np.argmin(((others + ball.turns) ** 2).sum(axis=1) + ball.price))
                missing = others + ball.turns[at[i]]
            cost = float(missing @ missing) + sum(ball.price[j] for ball, j in zip(balls, at, strict=True))
            if not cost < least - SETTLED:
                break
            least = cost
        nodes, turned = now.scale.nodes.copy(), now.turned.copy()
        for ball, j in zip(balls, at, strict=True):
            nodes[ball.cone] = ball.nodes[j]
            turned += ball.turned[j]
        return now.moved(nodes, turned)

    def _balls(self, now: Arrangement) -> list[Ball]:
        """Where the cones may go, but the ground and those without curvature."""
        first = int(now.scale.first >= 0)
        return [self._ball(now, i) for i in range(first, len(now.k)) if now.k[i]]

    def _ball(self, now: Arrangement, i: int) -> Ball:
        """By radii after a conformal map: Green's function falls by log r / 2 pi, but evenly along limbs."""
        piece, scale, k = self.place.piece, now.scale, int(now.k[i])
        c, green, size = scale.nodes[i], scale.green[i - (scale.first >= 0)], piece.area.sum()
        at, matrix = piece.graph.position, piece.graph.adjacency[0]
        ring = matrix.indices[matrix.indptr[c] : matrix.indptr[c + 1]]
        edge = np.linalg.norm(at[ring] - at[c], axis=1).mean() / np.sqrt(size)
        rim = green[ring].mean()  # at the distance of an edge
        nodes = np.flatnonzero(green > rim - np.log(BALL / edge) / (2 * np.pi))
        others = np.delete(scale.nodes, i)
        gap = ((at[others] - at[c]) ** 2).sum(axis=1).min(initial=np.inf)
        fits = ((at[nodes] - at[c]) ** 2).sum(axis=1) < APART**2 * gap
        fits &= (4 - k) * QUARTER_TURN <= WIDE * self.place.valence[nodes]
        nodes = nodes[fits & (nodes >= piece.graph.n_holes) & (nodes != c)]
        nodes = np.append(c, nodes[:: max(1, -(-len(nodes) // CANDIDATES))])
        way = (at[nodes] - at[c]) / np.sqrt(size)
        radius = edge * np.exp(np.minimum(2 * np.pi * (rim - green[nodes]), MAX_LOG_SCALE))
        radius[0] = 0.0
        change = self.holonomy.by_vertex[nodes] - self.holonomy.by_vertex[c]
        turned = -k * (change - np.round(change))
        density = max(2.0, size * float(sum(share[c] for share in now.shares)) / piece.area[c])
        stiffness = density * (k * QUARTER_TURN) ** 2 / (2 * np.pi)
        slope = k * QUARTER_TURN * (now.slope[nodes] - now.slope[c])
        square = radius**2 * np.log(2 / np.maximum(radius, np.finfo(float).tiny))
        return Ball(i, nodes, way, turned, turned @ self._root, slope, stiffness, slope + stiffness * square)


def _in_series(stiff: FloatArray, give: FloatArray) -> FloatArray:
    """The stiffness of a spring and one that yields by `give`."""
    both = np.linalg.inv(np.linalg.inv(stiff) + give)
    return np.asarray(both + both.T) / 2
