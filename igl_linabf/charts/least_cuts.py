"""Find the cheapest seam that separates two sets of polygons, as a minimum cut of the dual graph."""

import numpy as np

from .._core import minimum_cut_side
from .._types import BoolArray, FloatArray, IntArray
from ..surface import Submesh
from .features import CreasedSurface

ON_ONE_SIDE, ON_THE_OTHER, ON_EITHER = 0, 1, -1  # sides of a minimum cut on which a polygon must be


def find_edges_between_polygons(piece: Submesh) -> tuple[IntArray, FloatArray]:
    """Return the polygons on both sides of each edge that may be cut, (2, #E), and the price of each edge."""
    inside = piece.cuttable_edges
    polygon = piece.polygon_labels
    sides = polygon[piece.topology.sides[:, inside] % len(piece.F)]
    price = CreasedSurface(piece).edge_price[np.searchsorted(piece.topology.interior_edges, inside)]
    return np.asarray(sides), price


def divide_at_least_cut(sides: IntArray, price: FloatArray, terminal: IntArray) -> BoolArray:
    """Return a mask of the polygons on side `ON_THE_OTHER` of the cheapest seam, (#P,).

    Parameters
    ----------
    sides : (2, #E) int64
        The polygons on both sides of each edge.
    price : (#E,) float64
    terminal : (#P,) int64
        `ON_ONE_SIDE` and `ON_THE_OTHER` for the polygons that the seam must separate, `ON_EITHER` otherwise.
        If no polygon is required on one of the sides, no seam is needed, and the mask is False everywhere.
    """
    is_free = terminal == ON_EITHER
    n_free = int(np.count_nonzero(is_free))
    node = n_free + terminal  # one node for all polygons of a required side
    node[is_free] = np.arange(n_free)
    ends = node[sides]
    apart = ends[0] != ends[1]
    if not ((terminal == ON_ONE_SIDE).any() and (terminal == ON_THE_OTHER).any() and apart.any()):
        return np.zeros(len(terminal), dtype=bool)
    # SciPy needs integer capacities: use units of about a millionth of the highest price
    dearest = max(float(price.max()), np.finfo(float).tiny)
    capacity = np.maximum(np.rint(price[apart] / dearest * (1 << 20)).astype(np.int64), 1)
    behind = minimum_cut_side(ends[:, apart].T, capacity, n_free + 2, n_free, n_free + 1)
    return np.asarray(behind[node])


def find_terminals_beside_line(along: FloatArray, band: float) -> IntArray:
    """Return the terminals of a minimum cut near a line.

    `along` has the signed distances of the polygons from the line. Polygons outside a band around the line
    are terminals. `band` is the width of the band on each side of the line, as a share of the extent. The
    farthest polygon on each side is a terminal for any `band`.
    """
    within = np.abs(along) < min(band * np.ptp(along), along.max(), -along.min())
    return np.where(within, ON_EITHER, np.where(along > 0, ON_THE_OTHER, ON_ONE_SIDE))
