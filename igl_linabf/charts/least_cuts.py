"""A piece cut in two between its polygons, along the shortest seam that keeps two sets of them apart."""

import numpy as np

from .._core import behind_least_cut
from .._types import BoolArray, FloatArray, IntArray
from ..surface import Submesh
from .features import CreasedSurface

ON_ONE_SIDE, ON_THE_OTHER, ON_EITHER = 0, 1, -1  # terminals


def edges_between_polygons(piece: Submesh) -> tuple[IntArray, FloatArray]:
    """Return the polygons on both sides of each edge that a seam may take, (2, #E), and the edges' prices."""
    inside = piece.cuttable_edges
    polygon = piece.polygon_labels
    sides = polygon[piece.topology.sides[:, inside] % len(piece.F)]
    price = CreasedSurface(piece).price[np.searchsorted(piece.topology.inside, inside)]
    return np.asarray(sides), price


def sides_of_least_cut(sides: IntArray, length: FloatArray, terminal: IntArray) -> BoolArray:
    """Which polygons are on the other side of the shortest seam.

    Parameters
    ----------
    sides : (2, #E) int64
        The polygons on both sides of each edge.
    length : (#E,) float64
    terminal : (#P,) int64
        `ON_ONE_SIDE` and `ON_THE_OTHER` for the polygons that the seam keeps apart, else `ON_EITHER`.
        If there are none on one of the sides, no seam is needed: no polygon is on the other one.
    """
    is_free = terminal == ON_EITHER
    n_free = int(np.count_nonzero(is_free))
    node = n_free + terminal  # what is on a side is one node
    node[is_free] = np.arange(n_free)
    ends = node[sides]
    apart = ends[0] != ends[1]
    if not ((terminal == ON_ONE_SIDE).any() and (terminal == ON_THE_OTHER).any() and apart.any()):
        return np.zeros(len(terminal), dtype=bool)
    # flows are integers: a millionth of the longest edge is their unit
    longest = max(float(length.max()), np.finfo(float).tiny)
    capacity = np.maximum(np.rint(length[apart] / longest * (1 << 20)).astype(np.int64), 1)
    behind = behind_least_cut(ends[:, apart].T, capacity, n_free + 2, n_free, n_free + 1)
    return np.asarray(behind[node])


def terminals_beside_line(along: FloatArray, band: float) -> IntArray:
    """The terminals of a seam near a line, by the signed distances of polygons from it: those beyond a band.

    `band` is a share of the extent on either side. The polygons farthest from the line are terminals anyway.
    """
    within = np.abs(along) < min(band * np.ptp(along), along.max(), -along.min())
    return np.where(within, ON_EITHER, np.where(along > 0, ON_THE_OTHER, ON_ONE_SIDE))
