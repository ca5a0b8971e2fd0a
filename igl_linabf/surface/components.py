"""Connected components: of graphs, and of a surface's vertices and faces."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import IntArray
from ..kernels import connected_labels, is_fast


def vertex_components(F: IntArray, n: int) -> IntArray:
    """The component of each of the vertices 0 .. n - 1; one of no face is a component of its own."""
    return connected_labels(np.concatenate((F[:, :2], F[:, ::2])), n)


def face_components(F: IntArray, n: int) -> IntArray:
    """The component of each face, numbered from 0; faces that share a vertex are in the same one."""
    label = vertex_components(F, n)[F[:, 0]]
    return np.asarray(np.unique(label, return_inverse=True)[1], dtype=np.int64)


def in_one_piece(sides: IntArray, n_faces: int) -> bool:
    """Whether every face can be reached from face 0 across edges; `sides` as in `Topology`.

    Checked for every disk before it is flattened.
    """
    if is_fast():
        inside = sides[:, sides[1] >= 0] % n_faces
        return not connected_labels(inside.T, n_faces).any()
    neighbour = np.arange(3 * n_faces) % n_faces  # a half-edge on the boundary leads back to its own face
    first, second = sides
    inside = second >= 0
    a, b = first[inside], second[inside]
    neighbour[a], neighbour[b] = b % n_faces, a % n_faces
    graph = sparse.csr_array(
        (
            np.ones(3 * n_faces, dtype=np.int8),
            np.ascontiguousarray(neighbour.reshape(3, n_faces).T, dtype=np.int32).ravel(),
            np.arange(0, 3 * n_faces + 1, 3, dtype=np.int32),
        ),
        shape=(n_faces, n_faces),
    )
    reached = csgraph.breadth_first_order(graph, 0, directed=True, return_predecessors=False)
    return len(reached) == n_faces
