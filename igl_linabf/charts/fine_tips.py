"""Tips that clusters do not show: a spike of a few faces is one node of many there.

The log scale of the clusters is nearly that of the surface, but for such tips. Conjugate gradients that begin
with it get there in few steps, as a tip's curvature does not reach far.
"""

import numpy as np

from .._types import FloatArray, IntArray
from ..surface import connected_labels
from .cut_graph import ClosedSurface
from .expected import MAX_LOG_SCALE, expected_stretch
from .tips import SHRUNK, TIPPED, WORTH, worth_a_seam

STILL, MOST_STEPS = 0.06, 40  # change of a log scale that is the last one, and steps at most


def seam_to_fine_tips(piece: ClosedSurface, seam: IntArray, u: FloatArray, trade: float) -> IntArray:
    """Edges from a seam to tips that a map would shrink, where that is worth their length.

    `u` is nearly the conformal log scale of the nodes, (n,).
    """
    none, on = np.zeros(0, dtype=np.int64), piece.on(seam)
    u = _log_scale(piece, on, u)
    stretch = expected_stretch(piece, u)
    if not stretch > TIPPED:
        return none
    area = piece.area / piece.area.sum()
    scale = float(area @ np.exp(2 * u))
    shrunk = np.exp(2 * u) < SHRUNK * scale
    tip = connected_labels(piece.ends[shrunk[piece.ends].all(axis=1)], piece.n)
    more = np.where(shrunk, area * (scale * np.exp(-2 * u) - 1), 0.0)
    saved: FloatArray = np.bincount(tip, more).astype(np.float64)
    deepest = np.flatnonzero(shrunk)[np.argsort(-u[shrunk], kind="stable")]
    leaf = np.full(len(saved), -1)
    leaf[tip[deepest]] = deepest  # the last one stays
    tips = np.flatnonzero(leaf >= 0)
    tips = tips[np.argsort(-saved[tips], kind="stable")]
    if not len(tips):
        return none
    leaf, unit = leaf[tips], piece.size * trade
    distance, before, _ = piece.search(on, limit=(stretch - 1) * unit)
    price, total = distance[leaf] / unit, stretch**2
    chosen = worth_a_seam(saved[tips], price, total)
    left = np.sqrt(max(total - saved[tips[chosen]].sum(), 1.0))
    if stretch - left - price[chosen].sum() < WORTH:
        return none
    return piece.paths(before, leaf[chosen])


def _log_scale(piece: ClosedSurface, on: IntArray, u: FloatArray) -> FloatArray:
    """`log_scale` with zero at the nodes `on`, by steps from `u` until none of them changes much."""
    lower, free = piece.laplacian, np.ones(piece.n, dtype=bool)
    free[on] = False
    diagonal = lower.data[lower.indptr[:-1]]

    def flow(x: FloatArray) -> FloatArray:
        return np.where(free, lower @ x + lower.T @ x - diagonal * x, 0.0)

    u = np.where(free, u, 0.0)
    left = np.where(free, -piece.curvature, 0.0) - flow(u)
    scaled = left / diagonal
    way, down = scaled.copy(), np.einsum("i,i->", left, scaled)
    for _ in range(MOST_STEPS):
        across = flow(way)
        against = np.einsum("i,i->", way, across)
        if not against > 0:
            break
        by = down / against
        u += by * way
        left -= by * across
        if by * max(way.max(), -way.min()) <= STILL:
            break
        scaled = left / diagonal
        last, down = down, np.einsum("i,i->", left, scaled)
        way = scaled + down / last * way
    return np.clip(u, -MAX_LOG_SCALE, MAX_LOG_SCALE)
