"""A chart in two, for where seams do not help."""

import numpy as np
from scipy import sparse

from ...surface import Submesh, centres


def bisect(piece: Submesh) -> list[Submesh]:
    """The faces of a piece nearer to one or to the other of two far from each other; nothing of one face."""
    cell, inside = piece.polygon_labels, piece.cuttable_edges
    if not cell.any():
        return []
    m, sides = int(cell.max()) + 1, piece.topology.sides[:, inside]
    a, b = cell[sides % len(piece.F)]
    centre = centres(cell, piece.V[piece.F].mean(axis=1))
    step = np.linalg.norm(centre[a] - centre[b], axis=1)
    # two faces may share two edges: the graph then has the sum of equal steps, which does not matter
    graph = sparse.csr_array((np.maximum(step, np.finfo(float).tiny), (a, b)), shape=(m, m))

    def distance(face: int) -> np.ndarray:
        return np.asarray(sparse.csgraph.dijkstra(graph, directed=False, indices=face))

    first = int(np.argmax(distance(0)))
    from_first = distance(first)
    second = int(np.argmax(from_first))
    label = from_first <= distance(second)
    label[second] = False
    return piece.divided(label[cell])
