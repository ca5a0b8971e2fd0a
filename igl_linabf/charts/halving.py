"""A chart in two, for where seams do not help."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import IntArray
from ..surface import Submesh


def halves(piece: Submesh) -> list[Submesh]:
    """The faces of a piece nearer to one or to the other of two that are far from each other."""
    m = len(piece.F)
    inside = piece.topology.sides[:, piece.topology.sides[1] >= 0]
    a, b = inside % m
    centre = piece.V[piece.F].mean(axis=1)
    step = np.linalg.norm(centre[a] - centre[b], axis=1)
    # two faces may share two edges: the graph then has the sum of equal steps, which does not matter
    graph = sparse.csr_array((np.maximum(step, np.finfo(float).tiny), (a, b)), shape=(m, m))

    def distance(face: int) -> np.ndarray:
        return np.asarray(csgraph.dijkstra(graph, directed=False, indices=face))

    first = int(np.argmax(distance(0)))
    from_first = distance(first)
    second = int(np.argmax(from_first))
    label = from_first <= distance(second)
    label[second] = False
    between = np.flatnonzero(label[a] != label[b])
    mask = np.zeros((m, 3), dtype=bool)
    half_edge: IntArray = inside[:, between].ravel()  # opposite to corner k: from corner k + 1 on
    mask[half_edge % m, (half_edge // m + 1) % 3] = True
    return piece.cut(mask)
