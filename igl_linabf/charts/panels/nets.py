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
from ..cut_graphs import DIRECT, ClosedSurface, expected_stretch, handles_of_clusters, join_terminals
from ..features import TIP_CURVATURE, apexes
from . import constants

Seam = IntArray
LogScale = Callable[[Seam], FloatArray]
Grow = Callable[[Seam], Seam]
Grown = Callable[[int], Seam]
Parts = Callable[[Seam], list[Submesh]]


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
        price = 1 - (1 - constants.SHARP_CREASE_PRICE) * features.sharpness
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
        kept = list[IntArray]()
        for level in constants.NET_LEVELS:
            nodes = np.flatnonzero(self._bent > np.where(on_crease, level, TIP_CURVATURE))
            if len(nodes) and (not kept or len(nodes) < constants.NEXT_LEVEL_SHARE * len(kept[-1])):
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
        return np.asarray(self._on_sharp | (self._bent > TIP_CURVATURE))

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
        least = constants.CREASED_CURVATURE_OF_NETS * float(self._bent.sum())
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

    def _is_exact(self, seam: Seam) -> bool:
        """Whether hardly any distortion is expected of it."""
        return self.expected(seam) <= 1 + constants.EXACT_NET_DISTORTION

    def cost(self, seam: Seam) -> float:
        """What to expect of it, and its price."""
        return self.expected(seam) + self._price(seam)

    def _price(self, seam: Seam) -> float:
        """Of a seam, in units of stretch."""
        piece = self.piece
        features = piece.features
        length, sharp = (features.length * features.hiding)[seam] / piece.size, features.sharpness[seam]
        hard = constants.SHARP_CREASE_PRICE * max(0.0, float(length @ sharp) - self.trade)
        return (float(length @ (1 - sharp)) + hard) / self.trade

    def _least_price(self, nodes: IntArray) -> float:
        """Less than which no tree through these nodes costs: each has an edge, and an edge has two nodes."""
        piece = self.piece
        least = np.full(piece.graph.n, np.inf)
        np.minimum.at(least, piece.graph.ends.ravel(), np.repeat(self._priced.graph.length, 2))
        length = float(least[nodes].sum()) / 2 / piece.size
        return max(0.0, length - constants.SHARP_CREASE_PRICE * self.trade) / self.trade

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
        nearly = constants.MAX_CREASED_COST if self.creased else constants.EXPECTED_COST_MARGIN
        most = nearly + self._price(self._loops) if hard else constants.EXACT_NET_DISTORTION
        found: Seam | None = None
        for level in range(len(self._nodes) if hard else min(1, len(self._nodes))):
            net = self._through(level, most)
            if net is not None and self._price(net) < most and self._is_exact(net):
                found, most = net, self._price(net)
        return found

    def cheaper(self, seam: Seam, gain: float | None, parts: Parts, grow: Grow) -> Seam | None:
        """The net, with branches of `grow`, that costs least when it is flattened; None if `seam` costs less.

        With a `gain`, no seam is needed, and one has to save this.
        """
        grown = cache(lambda level: grow(self._net(level)))
        levels = range(len(self._nodes)) if self.piece.graph.n <= DIRECT else self._promising(seam, grown)
        if not levels:
            return None
        left = cache(lambda level: self._left(level, parts, grown))
        uncut = np.inf if gain is None else sketched_distortion(parts(seam[:0])) - gain
        expected = self.cost(seam)
        best, least = self._cheapest(levels, min(expected, uncut), left)
        if best is None or least > expected - constants.SURE_NET_GAIN:
            measured = sketched_distortion(parts(seam)) + self._price(seam)
            best, _ = self._cheapest(levels, min(measured, uncut), left)
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
            cost, creased = stretch + self._price(net), stretch <= 1 + constants.CREASED_NET_DISTORTION
            if cost < least - (0.0 if creased else constants.MIN_SMOOTH_NET_GAIN):
                best, least = net, cost
        return best, least

    def _left(self, level: int, parts: Parts, grown: Grown) -> tuple[Seam, float]:
        """The net of a level, with branches where they help, and the stretch of its map."""
        net = self._net(level)
        if not self._is_exact(net):
            net = grown(level)
        return net, sketched_distortion(parts(net))

    def _promising(self, seam: Seam, grown: Grown) -> list[int]:
        """The levels of nets that are exact, or with branches are expected to cost clearly less than a seam.

        A large surface takes long to flatten, which only these are worth.
        """
        cost, margin, promising = self.cost(seam), constants.EXPECTED_COST_MARGIN, list[int]()
        for level in range(len(self._nodes)):
            net = self._through(level, cost + margin - 1)
            if net is None or 1 + self._price(net) >= cost + margin:
                continue
            clearly = 1 + self._price(net) < cost - margin and self.cost(grown(level)) < cost - margin
            if clearly or self._is_exact(net):
                promising.append(level)
        return promising

    def _through(self, level: int, most: float) -> Seam | None:
        """The net of a level, unless no net can be had at the price `most`."""
        if self._least_prices[level] >= most:
            return None
        net = self._net(level)
        return net if len(net) > 1 or self.piece.graph.n_holes else None
