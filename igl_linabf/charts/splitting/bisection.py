"""Halve a chart, as a last resort if no seam improves its map."""

import numpy as np
from scipy import sparse

from ...surface import Submesh, compute_group_centres
from ..constants import HALVING_BAND
from ..least_cuts import divide_at_least_cut, find_edges_between_polygons, find_terminals_beside_line


def bisect_piece(piece: Submesh) -> list[Submesh]:
    """Halve a piece along a short seam about halfway between two distant faces; return the parts.

    A piece that consists of a single polygon cannot be divided; the list of parts is then empty.
    """
    polygon = piece.polygon_labels
    if not polygon.any():
        return []
    sides, price = find_edges_between_polygons(piece)
    centre = compute_group_centres(polygon, piece.V[piece.F].mean(axis=1))
    step = np.maximum(np.linalg.norm(centre[sides[0]] - centre[sides[1]], axis=1), np.finfo(float).tiny)
    # if two faces share two edges, csr_array adds their equal lengths, which hardly changes distances
    graph = sparse.csr_array((step, tuple(sides)), shape=(len(centre), len(centre)))

    def measure_distances(face: int) -> np.ndarray:
        return np.asarray(sparse.csgraph.dijkstra(graph, directed=False, indices=face))

    first = int(np.argmax(measure_distances(0)))
    from_first = measure_distances(first)
    second = int(np.argmax(from_first))
    terminal = find_terminals_beside_line(from_first - measure_distances(second), HALVING_BAND)
    return piece.cut_between_labels(divide_at_least_cut(sides, price, terminal)[polygon])
