"""Nets: seams through all that is curved at creases. Planes, cylinders and cones are then laid flat exactly.

Cut along a tree through all of its curved vertices, a surface is developable: a box falls into its net, a
cylinder into a rectangle and two disks.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from ..._types import BoolArray, FloatArray, IntArray
from ...surface import Submesh
from ..atlas import sketched_distortion
from ..cut_graphs import (
    MAX_DIRECT_NODES,
    ClosedSurface,
    expected_stretch,
    handles_of_clusters,
    join_terminals,
)
from ..features import TIP, apexes

Seam = IntArray
LogScale = Callable[[Seam], FloatArray]
Grow = Callable[[Seam], Seam]
Grown = Callable[[int], Seam]
Parts = Callable[[Seam], list[Submesh]]

# share of the area that lies flat, from which a surface has planes, and nets are compared
FLAT_SHARE_OF_NETS = 0.5
FLAT_SHARE_OF_LARGE_NETS = 0.8  # the same, of a surface of many vertices, on which comparing takes long
MOST_HANDLES_OF_NETS = 8  # of such a surface
CREASED_CURVATURE_OF_NETS = 0.5  # share of the curvature that is on sharp creases then
LEVELS = (0.0, 0.02, 0.2)  # radians of curvature at a crease, from which on a net goes through it
FEWER = 0.9  # times the nodes of the level before that another one has at most
SHARP_CREASE_PRICE = 0.15  # of its length: what a sharp crease counts, beyond what is free
LEFT = 0.05  # of stretch and shear that a net may leave; more is a smooth surface with some creases, of which
MUCH = 0.1  # a net has to save so much more
EXACT = 1e-3  # of stretch and bend that a net may leave
CLEAR = 0.02  # of cost below that expected of a seam, at which a net needs no comparison with the seam's map
NEAR, NEAR_CREASED = 0.05, 0.5  # of price above the least that is not worth to look for another seam


@dataclass(frozen=True, eq=False)
class Nets:
    """Seams of a surface with creases, and what they cost.

    Creases show anyway. So a seam on a sharp one is cheap, and a length of `trade` times the square root of
    the area is free: a net is worth more than the few percent of stretch that it saves.

    Attributes
    ----------
    piece : ClosedSurface
    trade : float
    log_scale : callable
        The logarithm of the conformal scale of the surface cut along a seam.
    """

    piece: ClosedSurface
    trade: float
    log_scale: LogScale

    @cached_property
    def _priced(self) -> ClosedSurface:
        """The surface with lengths as a net is charged for them."""
        features = self.piece.features
        price = 1 - (1 - SHARP_CREASE_PRICE) * features.sharpness
        return self.piece.with_lengths(features.length * features.hiding * price)

    @cached_property
    def _loops(self) -> Seam:
        """The edges that open the handles."""
        return handles_of_clusters(self._priced) if self.piece.graph.genus else np.zeros(0, dtype=np.int64)

    @cached_property
    def _bent(self) -> FloatArray:
        """The size of the curvature at each node, beyond what rounding makes; zero at holes."""
        size = np.abs(self.piece.curvature)
        size[: self.piece.graph.n_holes] = 0
        return np.where(size > self.piece.noise, size, 0.0)

    @cached_property
    def _nodes(self) -> list[IntArray]:
        """What a net has to go through, for each level that leaves out more than a few of the last one."""
        piece = self.piece
        on_crease = np.zeros(piece.graph.n, dtype=bool)
        on_crease[piece.graph.ends[piece.features.sharpness > 0]] = True
        found = [np.flatnonzero(self._bent > np.where(on_crease, level, TIP)) for level in LEVELS]
        kept = list[IntArray]()
        for nodes in found:
            if len(nodes) and (not kept or len(nodes) < FEWER * len(kept[-1])):
                kept.append(nodes)
        return kept

    @cached_property
    def _on_sharp(self) -> BoolArray:
        """The nodes on sharp creases."""
        on_sharp = np.zeros(self.piece.graph.n, dtype=bool)
        on_sharp[self.piece.graph.ends[self.piece.features.sharpness == 1]] = True
        return on_sharp

    @cached_property
    def _perhaps_cornered(self) -> BoolArray:
        """These, and the nodes that may be tips."""
        return np.asarray(self._on_sharp | (self._bent > TIP))

    @cached_property
    def _cornered(self) -> BoolArray:
        """The nodes on sharp creases, and the tips."""
        on_soft = np.zeros(self.piece.graph.n, dtype=bool)
        on_soft[self.piece.graph.ends[self.piece.features.sharpness > 0]] = True
        return self._on_sharp | apexes(self._bent, self.piece.graph.ends, self._on_sharp, on_soft)

    @cached_property
    def creased(self) -> bool:
        """Whether all that is curved is on sharp creases, or a tip."""
        curved = self._bent > 0
        return not (curved & ~self._perhaps_cornered).any() and not (curved & ~self._cornered).any()

    @cached_property
    def angular(self) -> bool:
        """Whether most of what is curved is on sharp creases, as corners are, or a tip.

        On a smooth surface whose triangles were split into coplanar ones it is not, though each lies flat.
        """
        least = CREASED_CURVATURE_OF_NETS * float(self._bent.sum())
        if float(self._bent[self._perhaps_cornered].sum()) < least:  # which takes less time to find
            return False
        return float(self._bent[self._cornered].sum()) >= least

    def expected(self, seam: Seam) -> float:
        """L2 stretch to expect, and the shear of coarse faces at vertices that are pressed flat."""
        piece = self.piece
        bent = self._bent.copy()
        bent[piece.graph.ends[seam]] = 0
        if not bent.any():
            return 1.0
        weight, stretch = piece.area / piece.area.sum(), expected_stretch(piece, self.log_scale(seam))
        flat = np.abs(piece.curvature) / (2 * np.pi)
        flat[: piece.graph.n_holes] = 0
        flat[piece.graph.ends[seam]] = 0
        return stretch + 3 * float(weight @ flat)

    def cost(self, seam: Seam) -> float:
        """What to expect of it, and its price."""
        return self.expected(seam) + self._price(seam)

    def _price(self, seam: Seam) -> float:
        """Of a seam, in units of stretch."""
        piece = self.piece
        features = piece.features
        length, sharp = (features.length * features.hiding)[seam] / piece.size, features.sharpness[seam]
        hard = SHARP_CREASE_PRICE * max(0.0, float(length @ sharp) - self.trade)
        return (float(length @ (1 - sharp)) + hard) / self.trade

    def _least_price(self, nodes: IntArray) -> float:
        """Less than which no tree through these nodes costs: each has an edge, and an edge has two nodes."""
        piece = self.piece
        least = np.full(piece.graph.n, np.inf)
        np.minimum.at(least, piece.graph.ends.ravel(), np.repeat(self._priced.graph.length, 2))
        length = float(least[nodes].sum()) / 2 / piece.size
        return max(0.0, length - SHARP_CREASE_PRICE * self.trade) / self.trade

    @cached_property
    def _least_prices(self) -> list[float]:
        """The same of each level."""
        return [self._least_price(nodes) for nodes in self._nodes]

    @cached_property
    def _joined(self) -> dict[int, Seam]:
        """The nets that are known, by their levels."""
        return {}

    def _net(self, level: int) -> Seam:
        if level not in self._joined:
            self._joined[level] = join_terminals(self._priced.graph, self._loops, self._nodes[level])
        return self._joined[level]

    def settled(self, hard: bool) -> Seam | None:
        """A net that leaves nothing to be stretched, and costs so little that nothing else is to be compared.

        On a hard surface it may cost a little more than the loops that open the handles, which every seam
        has. If all that is curved is on sharp creases, it may cost more: seams past corners press them flat.
        """
        nearly = NEAR_CREASED if self.creased else NEAR
        most = nearly + self._price(self._loops) if hard else EXACT
        found: Seam | None = None
        for level in range(len(self._nodes) if hard else min(1, len(self._nodes))):
            net = self._through(level, most)
            if net is not None and self._price(net) < most and self.expected(net) <= 1 + EXACT:
                found, most = net, self._price(net)
        return found

    def cheaper(self, seam: Seam, gain: float | None, parts: Parts, grow: Grow) -> Seam | None:
        """The net, with branches of `grow`, that costs least when it is flattened; None if `seam` costs less.

        With a `gain`, no seam is needed, and one has to save this.
        """
        grown = cache(lambda level: grow(self._net(level)))
        few = self.piece.graph.n <= MAX_DIRECT_NODES
        levels = range(len(self._nodes)) if few else self._promising(seam, grown)
        if not levels:
            return None
        left = cache(lambda level: self._left(level, parts, grown))
        uncut = np.inf if gain is None else sketched_distortion(parts(seam[:0])) - gain
        expected = self.cost(seam)
        best, least = self._cheapest(levels, min(expected, uncut), left)
        if best is None or least > expected - CLEAR:  # less than that a map's stretch hardly is
            best, _ = self._cheapest(
                levels, min(sketched_distortion(parts(seam)) + self._price(seam), uncut), left
            )
        return best

    def _cheapest(
        self, levels: Sequence[int], least: float, left: Callable[[int], tuple[Seam, float]]
    ) -> tuple[Seam | None, float]:
        """The net that costs least, if that is less than `least`; what is `left` is measured if it may be."""
        best = None
        for level in levels:
            net = self._through(level, least - 1)
            if net is None or 1 + self._price(net) >= least:
                continue
            net, stretch = left(level)
            cost = stretch + self._price(net)
            if cost < least - (MUCH if stretch > 1 + LEFT else 0.0):
                best, least = net, cost
        return best, least

    def _left(self, level: int, parts: Parts, grown: Grown) -> tuple[Seam, float]:
        """The net of a level, with branches where they help, and the stretch of its map."""
        net = self._net(level)
        if self.expected(net) > 1 + EXACT:
            net = grown(level)
        return net, sketched_distortion(parts(net))

    def _promising(self, seam: Seam, grown: Grown) -> list[int]:
        """The levels of nets that are exact, or with branches are expected to cost clearly less than a seam.

        A large surface takes long to flatten, which only these are worth.
        """
        cost, promising = self.cost(seam), list[int]()
        for level in range(len(self._nodes)):
            net = self._through(level, cost + NEAR - 1)
            if net is None or 1 + self._price(net) >= cost + NEAR:
                continue
            clearly = 1 + self._price(net) < cost - NEAR and self.cost(grown(level)) < cost - NEAR
            if clearly or self.expected(net) <= 1 + EXACT:
                promising.append(level)
        return promising

    def _through(self, level: int, most: float = EXACT) -> Seam | None:
        """The net of a level, unless no net can be had at the price `most`."""
        if self._least_prices[level] >= most:
            return None
        net = self._net(level)
        return net if len(net) > 1 or self.piece.graph.n_holes else None
