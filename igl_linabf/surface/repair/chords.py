"""Find and split chords, which are interior edges that join two boundary vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..._types import FloatArray, IntArray
from ..submesh import Submesh
from ..topology import NEXT, PREV, Topology


def find_chords(topology: Topology) -> IntArray:
    """Return the indices of the interior edges whose two ends are boundary vertices."""
    at_boundary = ~topology.is_interior[topology.edges]
    return np.flatnonzero(at_boundary.all(axis=1) & (topology.sides[1] >= 0))


def split_chords(V: ArrayLike, F: ArrayLike) -> tuple[FloatArray, IntArray]:
    """Split each chord, an interior edge that joins two boundary vertices, at its midpoint.

    A chord cuts off a part of the mesh, usually an ear, which is a boundary vertex with a single face. A map
    without flips cannot place the boundary of that part on a straight line, which `boundary="rectangle"`
    often requires. Splitting the chords makes such a map possible. The shape of the surface does not change.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of a manifold.

    Returns
    -------
    V : (#V + #chords, 3) float64
        The given vertices, followed by the midpoints.
    F : (#F + 2 #chords, 3) int64

    Raises
    ------
    MeshError
        The surface is not an oriented manifold.

    Examples
    --------
    >>> import numpy as np
    >>> V = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> V, F = split_chords(V, [[0, 1, 2], [0, 2, 3]])
    >>> V[4].tolist(), F.tolist()
    ([0.5, 0.5, 0.0], [[4, 0, 1], [4, 1, 2], [4, 2, 3], [4, 3, 0]])
    """
    surface = Submesh.manifold_from_input(V, F)
    positions, topology, number = np.asarray(V, dtype=np.float64), surface.topology, surface.n_given
    chords = find_chords(topology)
    middle = np.full(topology.corner.shape, -1)  # midpoint of the side opposite to each corner
    for side in topology.sides[:, chords]:
        middle.ravel()[side] = number + np.arange(len(chords))
    ends = surface.vertices[topology.edges[chords]]
    faces = surface.vertices[topology.corner].T
    parts = [faces[(middle < 0).all(axis=0)]]
    for split in range(1, 4):
        # rotate the corners so that the sides opposite to corners 0 .. split - 1 are split
        for turn in ([0, 1, 2], NEXT, PREV)[: 1 if split == 3 else 3]:
            here = middle[turn]
            chosen = ((here >= 0).sum(axis=0) == split) & (here[:split] >= 0).all(axis=0)
            parts += _split_triangles(*faces.T[turn][:, chosen], *here[:split, chosen])
    return np.concatenate((positions, positions[ends].mean(axis=1))), np.concatenate(parts)


def _split_triangles(a: IntArray, b: IntArray, c: IntArray, *middle: IntArray) -> list[IntArray]:
    """Split triangles a b c at the given midpoints of the sides opposite to a, then b, then c."""
    if len(middle) == 1:
        (p,) = middle
        parts = [(p, c, a), (p, a, b)]
    elif len(middle) == 2:
        p, q = middle
        parts = [(p, c, q), (p, q, a), (p, a, b)]
    else:
        p, q, r = middle
        parts = [(p, c, q), (q, a, r), (r, b, p), (p, q, r)]
    return [np.column_stack(part) for part in parts]
