"""The seam of one body: it grows leaf by leaf, gets shorter, and is made the same on both sides."""

from __future__ import annotations

import numpy as np

from ..._runtime import advance
from ..._types import IntArray
from ...surface import Submesh
from ..cut_graphs import ClosedSurface, Cost, expected, join, log_scale, open_handles, pruned, shortened
from .symmetry import Mirror, mirrored

MAX_LEAVES = 100  # on a component
MAX_LEAVES_IN_VAIN = 3  # in a row that do not pay, before no more are tried
SYMMETRIC = 0.05  # of cost that the same seam on both sides of a body may be worth
DRAWN_SHORTER = 1.6  # times the trade: a seam of clusters gets shorter when it is drawn tight

Grown = tuple[IntArray, IntArray]  # a seam, and its leaves


def seam_of_clusters(coarse: ClosedSurface, trade: float, holes: bool, gain: float | None) -> Grown:
    """The seam of clusters of nodes; no edge if the cost falls by less than `gain`."""
    trade *= DRAWN_SHORTER
    seam, leaves = grown_seam(coarse, trade, holes)
    seam = if_it_pays(coarse, shorter_seam(coarse, seam, trade)[0], trade, gain)
    return seam, np.intersect1d(leaves, coarse.ends[seam])


def grown_seam(piece: ClosedSurface, trade: float, holes: bool) -> Grown:
    """Edges to cut `piece` along."""
    none = np.zeros(0, dtype=np.int64)
    seam, leaves = open_handles(piece) if piece.genus else none, none
    seam = shortened(piece, seam, piece.total)
    if not holes:
        seam = join(piece, seam)
    if not piece.holes and not len(seam):
        seam, leaves = _slit(piece)
    if trade > 0:
        seam, grown = with_branches(piece, seam, trade)
        leaves = np.append(leaves, grown)
    return seam, leaves


def shorter_seam(piece: ClosedSurface, seam: IntArray, trade: float) -> tuple[IntArray, Cost]:
    """The seam with its branch points moved, and what seams cost; to hide it, without idle branches."""
    known: dict[bytes, float] = {}  # each seam is compared with several shorter ones

    def cost(seam: IntArray) -> float:
        key = seam.tobytes()
        if key not in known:
            known[key] = seam_cost(piece, seam, trade)
        return known[key]

    if piece.hides:
        seam = pruned(piece, seam, cost)
    return shortened(piece, seam, cost), cost


def alike_on_both_sides(
    component: Submesh, piece: ClosedSurface, seam: IntArray, trade: float, holes: bool
) -> IntArray:
    """A seam that is its own mirror image, if there is a mirror and it costs little more; else the seam."""
    known = mirrored(component, piece)
    if known is None:
        return seam
    surface, mirror = known
    other = join(surface, seam[:0]) if not holes else seam[:0]
    if not piece.holes:
        other = _slit(surface, mirror)[0]
    other = with_branches(surface, other, trade, mirror)[0]
    if surface.hides:
        other = pruned(surface, other, lambda seam: seam_cost(surface, seam, trade), mirror.image)
    return other if seam_cost(piece, other, trade) < seam_cost(piece, seam, trade) + SYMMETRIC else seam


def _slit(piece: ClosedSurface, mirror: Mirror | None = None) -> Grown:
    """A path to open a sphere, between the two points that would shrink most.

    With a mirror, between one of them and its image, or in the plane.
    """
    extra = piece.curvature - 4 * np.pi * piece.area / piece.area.sum()
    start = int(np.argmin(log_scale(piece, np.array([0]), extra) / piece.seen))
    end = int(np.argmin(log_scale(piece, np.array([start]), piece.curvature) / piece.seen))
    if mirror is not None:
        start, end = mirror.pair(start, end)
    distance, before, _ = piece.search(np.array([start]))
    path = piece.paths(before, [end])
    if len(path) == 1:  # a single edge opens nothing
        distance[[start, end]] = np.inf
        path = np.append(path, piece.paths(before, [int(np.argmin(distance))]))
    return path, np.array([start, end])


def with_branches(piece: ClosedSurface, seam: IntArray, trade: float, mirror: Mirror | None = None) -> Grown:
    """Add branches one by one, or with mirror images; return the seam of least cost, and its leaves."""
    leaves: list[int] = []
    best, least, in_vain, in_best = seam, np.inf, 0, 0
    for _ in range(MAX_LEAVES):
        if 1 + piece.total(seam) / piece.size / trade >= least:  # no stretch is less than 1
            break
        stretch, u = expected(piece, piece.on(seam))
        cost = stretch + piece.total(seam) / piece.size / trade
        advance("seams", 0.1)
        in_vain = 0 if cost < least else in_vain + 1
        if in_vain == 0:
            best, least, in_best = seam, cost, len(leaves)
        leaf = int(np.argmax(np.abs(u) / piece.seen))
        if in_vain == MAX_LEAVES_IN_VAIN or u[leaf] == 0:
            break
        _, before, _ = piece.search(piece.on(seam))
        way = piece.paths(before, [leaf])
        seam = np.append(seam, way) if mirror is None else mirror.with_both(piece, seam, leaf, way)
        leaves.append(leaf)
    return best, np.array(leaves[:in_best], dtype=np.int64)


def if_it_pays(piece: ClosedSurface, seam: IntArray, trade: float, gain: float | None) -> IntArray:
    """A seam, or no edge if the cost falls by less than `gain`."""
    if gain is not None and seam_cost(piece, seam[:0], trade) - seam_cost(piece, seam, trade) < gain:
        return seam[:0]
    return seam


def seam_cost(piece: ClosedSurface, seam: IntArray, trade: float) -> float:
    """The expected L2 stretch plus the length over `trade`."""
    length = piece.total(seam) / piece.size
    return length if trade == 0 else expected(piece, piece.on(seam))[0] + length / trade
