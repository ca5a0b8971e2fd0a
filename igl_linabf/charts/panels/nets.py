"""Nets: seams through all that is curved at creases. Planes, cylinders and cones are then laid flat exactly.

Cut along a tree through all of its curved vertices, a surface is developable: a box falls into its net, a
cylinder into a rectangle and two disks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...surface import Submesh
from ..atlas import sketched_distortion
from ..cut_graphs import (
    DIRECT,
    ClosedSurface,
    expected_stretch,
    handles_of_clusters,
    join_terminals,
    log_scale,
)
from ..features import APEX_CURVATURE, apexes
from .constants import (
    CHEAP_NET,
    CHEAP_NET_AT_CREASES,
    EXACT_NET,
    FACETED_SHARE,
    NET_CURVATURES,
    SHARP_CREASE_PRICE,
)

Seam = IntArray


@dataclass(frozen=True, eq=False)
class Nets:
    """The nets of a surface, to compare with other seams.

    Creases show anyway. So a seam on a sharp one is cheap, and a length of `trade` times the square root of
    the area is free: a net is worth more than the few percent of stretch that it saves.

    Attributes
    ----------
    piece : ClosedSurface
    trade : float
    parts : callable
        The pieces into which a seam cuts the surface.
    with_branches : callable
        A seam with branches to the tips that its map would shrink.
    """

    piece: ClosedSurface
    trade: float
    parts: Callable[[Seam], list[Submesh]]
    with_branches: Callable[[Seam], Seam]

    @cached_property
    def smooth_share(self) -> float:
        """Share of the curvature that is not on sharp creases, as that of corners is, nor in a tip.

        On a smooth surface whose triangles were split into coplanar ones it is large, though each lies flat.
        """
        graph, sharpness, bent = self.piece.graph, self.piece.features.sharpness, self._bent
        on_sharp, on_soft = np.zeros((2, graph.n), dtype=bool)
        on_sharp[graph.ends[sharpness == 1]] = True
        total, smooth = float(bent.sum()), float(bent[~on_sharp & (bent <= APEX_CURVATURE)].sum())
        if total > 0 and smooth <= (1 - FACETED_SHARE) * total:  # else it is most of it whatever is a tip
            on_soft[graph.ends[sharpness > 0]] = True
            smooth = float(bent[~on_sharp & ~apexes(bent, graph.ends, on_sharp, on_soft)].sum())
        return smooth / max(total, np.finfo(float).tiny)

    @cached_property
    def _bent(self) -> FloatArray:
        """The size of the curvature at each node, beyond what rounding makes; zero at holes."""
        size = np.abs(self.piece.curvature)
        size[: self.piece.graph.n_holes] = 0
        return np.where(size > self.piece.noise, size, 0.0)

    @cached_property
    def priced(self) -> ClosedSurface:
        """The surface with lengths as a net is charged for them."""
        features = self.piece.features
        price = 1 - (1 - SHARP_CREASE_PRICE) * features.sharpness
        return self.piece.with_lengths(features.length * features.hiding * price)

    @cached_property
    def loops(self) -> Seam:
        """The edges that open the handles."""
        return handles_of_clusters(self.priced) if self.piece.graph.genus else np.zeros(0, dtype=np.int64)

    @cached_property
    def _nets(self) -> list[_Net]:
        """The net through all that is curved, and nets that leave out what is curved little on creases."""
        graph = self.piece.graph
        on_crease = np.zeros(graph.n, dtype=bool)
        on_crease[graph.ends[self.piece.features.sharpness > 0]] = True
        nets = list[_Net]()
        for least in NET_CURVATURES:
            nodes = np.flatnonzero(self._bent > np.where(on_crease, least, APEX_CURVATURE))
            if len(nodes) and (not nets or len(nodes) < len(nets[-1].nodes)):
                nets.append(_Net(self, nodes))
        return nets

    def expected(self, seam: Seam) -> float:
        """L2 stretch to expect, and the shear of coarse faces at vertices that are pressed flat."""
        piece, graph = self.piece, self.piece.graph
        bent = self._bent.copy()
        bent[graph.ends[seam]] = 0
        if not bent.any():
            return 1.0
        weight = piece.area / piece.area.sum()
        stretch = expected_stretch(piece, log_scale(piece, graph.boundary_nodes(seam), piece.curvature))
        flat = np.abs(piece.curvature) / (2 * np.pi)
        flat[: graph.n_holes] = 0
        flat[graph.ends[seam]] = 0
        return stretch + 3 * float(weight @ flat)

    def cost(self, seam: Seam) -> float:
        """What to expect of it, and its price."""
        return self.expected(seam) + self.price(seam)

    def price(self, seam: Seam) -> float:
        """Of a seam, in units of stretch."""
        features = self.piece.features
        length, sharp = (features.length * features.hiding)[seam] / self.piece.size, features.sharpness[seam]
        on_sharp = SHARP_CREASE_PRICE * max(0.0, float(length @ sharp) - self.trade)
        return (float(length @ (1 - sharp)) + on_sharp) / self.trade

    def settled(self, compared: bool) -> Seam | None:
        """A net that leaves nothing to be stretched, and costs so little that nothing else is to be compared.

        On a surface whose nets are `compared` with seams it may cost a little more than the loops that open
        the handles, which every seam has. If all that is curved is on sharp creases, it may cost more: seams
        past corners press them flat.
        """
        most = EXACT_NET
        if compared:
            most = (CHEAP_NET if self.smooth_share else CHEAP_NET_AT_CREASES) + self.price(self.loops)
        found: Seam | None = None
        for net in self._nets if compared else self._nets[:1]:
            if net.costs_less(most) and net.is_exact:
                found, most = net.seam, net.price
        return found

    def cheaper(self, seam: Seam, gain: float | None) -> Seam | None:
        """The net, with branches, that costs least when it is flattened; None if `seam` costs less.

        With a `gain`, no seam is needed, and one has to save this.
        """
        nets = self._nets if self.piece.graph.n <= DIRECT else self._promising(seam)
        if not nets:
            return None
        uncut = np.inf if gain is None else sketched_distortion(self.parts(seam[:0])) - gain
        expected = self.cost(seam)
        best = _cheapest(nets, min(expected, uncut))
        # the stretch of a map is hardly less than expected by more than this
        if best is None or best.cost > expected - CHEAP_NET:
            best = _cheapest(nets, min(sketched_distortion(self.parts(seam)) + self.price(seam), uncut))
        return None if best is None else best.grown

    def _promising(self, seam: Seam) -> list[_Net]:
        """The nets that are exact, or with branches are expected to cost clearly less than a seam.

        A large surface takes long to flatten, which only these are worth.
        """
        cost, promising = self.cost(seam), list[_Net]()
        for net in self._nets:
            if net.costs_less(cost + CHEAP_NET - 1):
                least = cost - CHEAP_NET
                if net.is_exact or (net.costs_less(least - 1) and self.cost(net.grown) < least):
                    promising.append(net)
        return promising


@dataclass(frozen=True, eq=False)
class _Net:
    """The shortest tree through some nodes, and the loops that open the handles."""

    nets: Nets
    nodes: IntArray

    @cached_property
    def seam(self) -> Seam:
        return join_terminals(self.nets.priced.graph, self.nets.loops, self.nodes)

    @cached_property
    def price(self) -> float:
        return self.nets.price(self.seam)

    @cached_property
    def _least_price(self) -> float:
        """Less than which no tree through the nodes costs: each has an edge, and an edge has two nodes."""
        graph, trade = self.nets.priced.graph, self.nets.trade
        least = np.full(graph.n, np.inf)
        np.minimum.at(least, graph.ends.ravel(), np.repeat(graph.length, 2))
        length = float(least[self.nodes].sum()) / 2 / self.nets.piece.size
        return max(0.0, length - SHARP_CREASE_PRICE * trade) / trade

    def costs_less(self, price: float) -> bool:
        """Whether it cuts the surface open for less than this price."""
        if self._least_price >= price:
            return False
        return (len(self.seam) > 1 or self.nets.piece.graph.n_holes > 0) and self.price < price

    @cached_property
    def is_exact(self) -> bool:
        """Whether it leaves nothing to be stretched."""
        return self.nets.expected(self.seam) <= 1 + EXACT_NET

    @cached_property
    def grown(self) -> Seam:
        """The net with branches where they help."""
        return self.seam if self.is_exact else self.nets.with_branches(self.seam)

    @cached_property
    def cost(self) -> float:
        """Of the grown net, with the distortion of its map."""
        return sketched_distortion(self.nets.parts(self.grown)) + self.nets.price(self.grown)


def _cheapest(nets: Sequence[_Net], least: float) -> _Net | None:
    """The net that costs least, if that is less than `least`; no map is made of what is too dear without."""
    best = None
    for net in nets:
        if net.costs_less(least - 1) and net.cost < least:
            best, least = net, net.cost
    return best
