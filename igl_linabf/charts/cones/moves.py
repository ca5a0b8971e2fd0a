"""Move cones along the surface until closed paths turn by nearly whole quarters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...angles import HolonomyAngles
from ..cut_graphs import MAX_LOG_SCALE
from .constants import DISTORTION_PER_LOG_STRETCH, MAX_ANGLE_AT_CONE, QUARTER_TURN
from .placement import ConeComponent
from .quantisation import QuantisedCurvatures, quantise_holonomy
from .scale import ConeScale

# log stretch above which cones do not move: the expansion of second order is not valid
MAX_MOVED_LOG_STRETCH = 3.0
MAX_MOVE_ROUNDS = 4  # rounds of moves, each within balls around the current cones
MAX_SWEEPS = 30  # sweeps over all cones in a round
MIN_MISSING_COST = 0.05  # least cost of missing quarter turns, as log stretch, for cones to move
# growth of the log stretch that is as bad as F/3nt of 1, when cones move
MISSING_TURN_PER_LOG_STRETCH = 200.0
MAX_QUARTER_DISTORTION = 0.02  # largest F/3nt of a missing quarter turn, because triangles at cones yield
COST_DAMPING = 1e-12  # share of the trace of the costs that is added to their diagonal, for a Cholesky factor
BALL_RADIUS = 0.3  # radius of the balls, over the square root of the surface's area
MAX_WAY_TO_CONE = 0.4  # share of the distance to the nearest other cone that a cone may move in a round
MAX_BALL_VERTICES = 1_500  # nodes of a ball that are tried, evenly chosen
FITTED_VERTICES = 200  # number of nodes in a ball for fitting slopes
SLOPES_RTOL = 0.05  # singular value, relative to the largest, below which a ball has no slope in a direction
MIN_MOVE_GAIN = 0.01  # cost, as log stretch, that a round of moves must save
MIN_SWEEP_GAIN = 1e-4  # log stretch that a sweep over all cones must save


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Cones with curvatures in quarter turns, and the resulting scale and holonomy.

    Attributes
    ----------
    scale : ConeScale
        The scale with these cones.
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
        """The log scale at each node, (n,)."""
        return self.scale.log_scale_of(np.asarray(self.k * QUARTER_TURN))

    @cached_property
    def _powers(self) -> tuple[FloatArray, FloatArray]:
        """The squares of the scale and of its inverse at each node, weighted by area."""
        area = self.scale.piece.area / self.scale.piece.area.sum()
        return area * np.exp(2 * self.log_scale), area * np.exp(-2 * self.log_scale)

    @cached_property
    def log_stretch(self) -> float:
        """Log of the expected L2 stretch."""
        return float(sum(np.log(power.sum()) for power in self._powers)) / 2

    @cached_property
    def shares(self) -> tuple[FloatArray, FloatArray]:
        """Share of each node in the integrals of the squared scale and of its squared inverse.

        The derivative of the log stretch with respect to the log scale is their difference.
        """
        grown, shrunk = self._powers
        return grown / grown.sum(), shrunk / shrunk.sum()

    @cached_property
    def slope(self) -> FloatArray:
        """Derivative of the log stretch with respect to the curvature at each node, per radian, (n,)."""
        grown, shrunk = self.shares
        scale, share = self.scale, grown - shrunk
        share[np.arange(scale.piece.graph.n_holes) if scale.first < 0 else scale.first] = 0.0
        return scale.factor.solve(share)

    def with_nodes(self, nodes: IntArray, path_turns: FloatArray) -> Arrangement:
        """Return the arrangement with the cones at other nodes; the ground does not move."""
        scale = self.scale
        others = nodes if scale.first < 0 else nodes[1:]
        (new,) = np.nonzero(others != scale.others)
        unit, green = np.zeros((scale.piece.graph.n, len(new))), scale.green.copy()
        unit[others[new], np.arange(len(new))] = 1.0
        green[new] = scale.factor.solve(unit).T
        return Arrangement(replace(scale, others=others, green=green), self.k, path_turns)


@dataclass(frozen=True, eq=False)
class Ball:
    """The possible nodes of a cone after one round of moves.

    Attributes
    ----------
    cone : int
        The number of the cone.
    nodes : (m,) int64
        The nodes; the cone's own node comes first.
    way : (m, 3) float64
        Vector from the cone to each node, over the square root of the surface's area.
    path_turns : (m, #paths) float64
        Change of each closed path's holonomy if the cone moves to the node, quarter turns.
    weighed_turns : (m, #paths) float64
        The same in coordinates whose squared norm is the cost.
    slope : (m,) float64
        Change of the log stretch to first order.
    stiffness : float
        Coefficient of second order: the change over r² log(2 / r), with the conformal radius r.
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
        """Gradients of `path_turns` and `slope` with respect to `way`, (3, #paths + 1), by least squares."""
        few = slice(None, None, max(1, len(self.nodes) // FITTED_VERTICES))
        values = np.column_stack((self.path_turns, self.slope))
        return np.asarray(np.linalg.lstsq(self.way[few], values[few], rcond=SLOPES_RTOL)[0])

    def find_nearest(self, way: FloatArray) -> int:
        """Return the index of the node nearest to the end of this way."""
        return int(np.argmin(((self.way - way) ** 2).sum(axis=1)))


@dataclass(frozen=True, eq=False)
class ConeMoves:
    """Moves of cones after which closed paths turn by nearly whole quarters.

    If a cone of curvature k moves from one vertex to another, the holonomy angle of a path changes by k times
    the difference of a harmonic function. Each handle has two paths, and each cone has two coordinates.
    Therefore moves alone can make all paths turn by whole quarters, and the map remains conformal (Abel's
    theorem). Without moves, all triangles have to change their angles, most of all the triangles at cones
    with large angles. If a cone crosses a path, the path turns by k more quarters, which is a whole number.

    Attributes
    ----------
    place : ConeComponent
    quarters : QuantisedCurvatures
        The curvatures of the cones at their initial nodes.
    holonomy : HolonomyAngles
        The holonomy of these cones; `by_vertex` has a row for each node.
    """

    place: ConeComponent
    quarters: QuantisedCurvatures
    holonomy: HolonomyAngles

    def find_best(self) -> Arrangement | None:
        """Return the arrangement of least cost; None if moves save too little."""
        fixed = self._exchange_quarters(self.holonomy.cost)
        if fixed.log_stretch > MAX_MOVED_LOG_STRETCH:
            return None
        if self._cost(fixed) < fixed.log_stretch + MIN_MISSING_COST:
            return None
        free = self._exchange_quarters(self._soft_form / DISTORTION_PER_LOG_STRETCH / QUARTER_TURN**2)
        starts = [fixed] if np.array_equal(free.k, fixed.k) else [fixed, free]
        now = min((self._improve(start) for start in starts), key=self._cost)
        for _ in range(MAX_MOVE_ROUNDS - 1):
            further = self._improve(now)
            gain = self._cost(now) - self._cost(further)
            now = further if gain > 0 else now
            if gain < MIN_MOVE_GAIN:
                break
        return now if self._cost(now) < self._cost(fixed) - MIN_MOVE_GAIN else None

    def _exchange_quarters(self, cost: FloatArray) -> Arrangement:
        """Return the initial cones after exchanges of quarter turns for this cost of missing quarters."""
        found, by_node = self._initial, self.holonomy.by_vertex[self._initial.scale.nodes]
        k, _ = self.quarters.fit_paths(replace(self.holonomy, by_vertex=by_node, cost=cost))
        change = k - found.k
        return replace(found, k=k, path_turns=found.path_turns - change @ by_node) if change.any() else found

    @cached_property
    def _initial(self) -> Arrangement:
        """The arrangement of the cones at their initial nodes."""
        return Arrangement(self.quarters.scale, self.quarters.for_stretch, self.holonomy.angle / QUARTER_TURN)

    def _cost(self, now: Arrangement) -> float:
        """Return the log stretch, plus the cost of quarters that paths miss in the same unit."""
        missing = now.path_turns - quantise_holonomy(now.path_turns[None], self._stiff_form)[0]
        return now.log_stretch + float(missing @ self._stiff_form @ missing)

    @cached_property
    def _stiff_form(self) -> FloatArray:
        """Quadratic form of the cost of missing quarters, as log stretch, (#paths, #paths)."""
        cost = self.holonomy.cost * QUARTER_TURN**2
        least = COST_DAMPING * np.trace(cost) * np.eye(len(cost))
        return MISSING_TURN_PER_LOG_STRETCH * _combine_in_series(
            cost + least, np.eye(len(cost)) / MAX_QUARTER_DISTORTION
        )

    @cached_property
    def _root(self) -> FloatArray:
        """Cholesky factor of the quadratic form."""
        return np.asarray(np.linalg.cholesky(self._stiff_form))

    @cached_property
    def _soft_form(self) -> FloatArray:
        """The same form if cones may move: each move takes up a part, like a spring in series."""
        give = np.zeros_like(self._stiff_form)
        for ball in self._balls(self._initial):
            slopes = ball.slopes[:, :-1]
            give += slopes.T @ slopes / (ball.stiffness * np.log(4 / BALL_RADIUS))
        return _combine_in_series(self._stiff_form, give)

    def _improve(self, now: Arrangement) -> Arrangement:
        """Return the arrangement with the cones at the nodes of their balls that cost least.

        First, all ways together minimise a quadratic form that treats the balls as flat. Then each cone in
        turn goes to its best node, until a sweep over all cones gains little.
        """
        balls = self._balls(now)
        if not balls:
            return now
        missing = (now.path_turns - quantise_holonomy(now.path_turns[None], self._soft_form)[0]) @ self._root
        slopes = np.concatenate([ball.slopes for ball in balls])
        turns = slopes[:, :-1] @ self._root
        stiff = np.repeat([2 * ball.stiffness * np.log(4 / BALL_RADIUS) for ball in balls], 3)
        way = np.linalg.solve(np.diag(stiff) + 2 * turns @ turns.T, -slopes[:, -1] - 2 * turns @ missing)
        at = [ball.find_nearest(there) for ball, there in zip(balls, way.reshape(-1, 3), strict=True)]
        missing = missing + sum(ball.weighed_turns[j] for ball, j in zip(balls, at, strict=True))
        least = np.inf
        for _ in range(MAX_SWEEPS):
            for i, ball in enumerate(balls):
                others = missing - ball.weighed_turns[at[i]]
                at[i] = int(np.argmin(((others + ball.weighed_turns) ** 2).sum(axis=1) + ball.price))
                missing = others + ball.weighed_turns[at[i]]
            cost = float(missing @ missing) + sum(ball.price[j] for ball, j in zip(balls, at, strict=True))
            if not cost < least - MIN_SWEEP_GAIN:
                break
            least = cost
        nodes, path_turns = now.scale.nodes.copy(), now.path_turns.copy()
        for ball, j in zip(balls, at, strict=True):
            nodes[ball.cone] = ball.nodes[j]
            path_turns += ball.path_turns[j]
        return now.with_nodes(nodes, path_turns)

    def _balls(self, now: Arrangement) -> list[Ball]:
        """Return the balls of all cones that have curvature, except the ground."""
        first = int(now.scale.first >= 0)
        return [self._ball(now, i) for i in range(first, len(now.k)) if now.k[i]]

    def _ball(self, now: Arrangement, i: int) -> Ball:
        """Return the ball of cone i, measured by conformal radii.

        In a plane, Green's function decreases with log r / 2 pi at the distance r; along a limb, it decreases
        linearly. The radius r for a value of Green's function is therefore the radius in a conformal map,
        which grows fast along limbs.
        """
        piece, scale, k = self.place.piece, now.scale, int(now.k[i])
        c, green, size = scale.nodes[i], scale.green[i - (scale.first >= 0)], piece.area.sum()
        at, matrix = piece.graph.position, piece.graph.adjacency[0]
        ring = matrix.indices[matrix.indptr[c] : matrix.indptr[c + 1]]
        edge = np.linalg.norm(at[ring] - at[c], axis=1).mean() / np.sqrt(size)
        rim = green[ring].mean()  # at a distance of one edge
        nodes = np.flatnonzero(green > rim - np.log(BALL_RADIUS / edge) / (2 * np.pi))
        others = np.delete(scale.nodes, i)
        gap = ((at[others] - at[c]) ** 2).sum(axis=1).min(initial=np.inf)
        fits = ((at[nodes] - at[c]) ** 2).sum(axis=1) < MAX_WAY_TO_CONE**2 * gap
        fits &= (4 - k) * QUARTER_TURN <= MAX_ANGLE_AT_CONE * self.place.valence[nodes]
        nodes = nodes[fits & (nodes >= piece.graph.n_holes) & (nodes != c)]
        nodes = np.append(c, nodes[:: max(1, -(-len(nodes) // MAX_BALL_VERTICES))])
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


def _combine_in_series(stiff: FloatArray, give: FloatArray) -> FloatArray:
    """Return the stiffness of a spring in series with another whose compliance is `give`."""
    both = np.linalg.inv(np.linalg.inv(stiff) + give)
    return np.asarray(both + both.T) / 2
