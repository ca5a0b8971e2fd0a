"""Nets: seams through all curved vertices at creases, which lay planes, cylinders and cones flat exactly.

A surface that is cut along a tree through all of its curved vertices is developable: a box falls into its
net, a cylinder into a rectangle and two disks.
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

    Sharp creases show anyway. So a seam on them is cheap, and free up to a length of `trade` times the square
    root of the area: a net is worth more than the few percent of stretch that it saves.

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
        """The surface whose lengths are what a net pays for them."""
        features = self.piece.features
        price = 1 - (1 - constants.SHARP_CREASE_PRICE) * features.sharpness
        return self.piece.with_lengths(features.length * features.hiding * price)

    @cached_property
    def _loops(self) -> Seam:
        """The edges that open the handles."""
        return handles_of_clusters(self._priced) if self.piece.graph.genus else np.zeros(0, dtype=np.int64)

    @cached_property
    def _bent(self) -> FloatArray:
        """The absolute curvature of each node; 0 at holes, and where rounding may make it."""
        size = np.abs(self.piece.curvature)
        size[: self.piece.graph.n_holes] = 0
        return np.where(size > self.piece.noise, size, 0.0)

    @cached_property
    def _nodes(self) -> list[IntArray]:
        """The nodes of the net of each level, of those levels that leave out more than a few nodes."""
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
        """The nodes on sharp creases, and those that may be tips."""
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
        """Whether much of the curvature is on sharp creases, as that of corners is, or at tips.

        It is not on a smooth surface whose triangles were split into coplanar ones, though these lie flat.
        """
        least = constants.CREASED_CURVATURE_OF_NETS * float(self._bent.sum())
        if float(self._bent[self._perhaps_cornered].sum()) < least:  # of more nodes, which take less time
            return False
        return float(self._bent[self._cornered].sum()) >= least

    def expected(self, seam: Seam) -> float:
        """The expected distortion: L2 stretch, and the shear of coarse faces at vertices pressed flat."""
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
        """The expected distortion of a seam, and its price."""
        return self.expected(seam) + self._price(seam)

    def _price(self, seam: Seam) -> float:
        """The price of a seam, in units of L2 stretch."""
        piece = self.piece
        features = piece.features
        length, sharp = (features.length * features.hiding)[seam] / piece.size, features.sharpness[seam]
        hard = constants.SHARP_CREASE_PRICE * max(0.0, float(length @ sharp) - self.trade)
        return (float(length @ (1 - sharp)) + hard) / self.trade

    def _least_price(self, nodes: IntArray) -> float:
        """A lower bound of the price of a tree through these nodes: each has an edge, which has two nodes."""
        piece = self.piece
        least = np.full(piece.graph.n, np.inf)
        np.minimum.at(least, piece.graph.ends.ravel(), np.repeat(self._priced.graph.length, 2))
        length = float(least[nodes].sum()) / 2 / piece.size
        return max(0.0, length - constants.SHARP_CREASE_PRICE * self.trade) / self.trade

    @cached_property
    def _least_prices(self) -> list[float]:
        """That of the nodes of each level."""
        return [self._least_price(nodes) for nodes in self._nodes]

    @cached_property
    def _joined(self) -> dict[int, Seam]:
        """The nets that have been found, by their levels."""
        return {}

    def _net(self, level: int) -> Seam:
        if level not in self._joined:
            self._joined[level] = join_terminals(self._priced.graph, self._loops, self._nodes[level])
        return self._joined[level]

    def settled(self, hard: bool) -> Seam | None:
        """An exact net that costs so little that it needs no comparison; None if there is none.

        On a hard surface it may cost a little more than the loops that open the handles, which every seam
        has; and still more if all that is curved is on sharp creases, as other seams press corners flat.
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
        """The net, with branches of `grow`, that costs least once it is flattened; None if `seam` costs less.

        With a `gain`, no seam is needed, and a net has to save that much.
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
        if best is None or least > expected - constants.SURE_NET_GAIN:
            measured = sketched_distortion(parts(seam)) + self._price(seam)
            best, _ = self._cheapest(levels, min(measured, uncut), left)
        return best

    def _cheapest(
        self, levels: Sequence[int], least: float, left: Callable[[int], tuple[Seam, float]]
    ) -> tuple[Seam | None, float]:
        """The net that costs least, if less than `least`, and its cost. `left(level)` flattens a net."""
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
        """The net of a level, with branches if it is not exact, and the distortion of its map."""
        net = self._net(level)
        if not self._is_exact(net):
            net = grown(level)
        return net, sketched_distortion(parts(net))

    def _promising(self, seam: Seam, grown: Grown) -> list[int]:
        """The levels whose nets are worth flattening a large surface, which takes long.

        They are exact, or are expected to cost clearly less than the seam with their branches.
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
        """The net of a level; None if no tree through its nodes has a price below `most`."""
        if self._least_prices[level] >= most:
            return None
        net = self._net(level)
        return net if len(net) > 1 or self.piece.graph.n_holes else None
