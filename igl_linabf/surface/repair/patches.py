"""Find the largest piece of a surface that remains when only some of its vertices are kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core import connected_labels, count_fans, find_edges
from ..._types import BoolArray, IntArray
from ...errors import MeshError, first_few
from ..arrays import drop_unused_vertices
from ..topology import build_topology


@dataclass(frozen=True, eq=False)
class PatchFaces:
    """The largest piece of a patch, and the kept vertices outside of it.

    Attributes
    ----------
    rows : (#,) int64
        The rows of the surface's faces that form the piece.
    vertices : (#,) int64
        The vertices of the piece.
    pinched : (#,) int64
        Vertices where the border touched itself. They are removed to make the border a set of loops.
    pieces : tuple of int64 arrays
        The vertices of the other pieces, largest first.
    bare : (#,) int64
        Kept vertices without a face whose three vertices are kept.
    """

    rows: IntArray
    vertices: IntArray
    pinched: IntArray
    pieces: tuple[IntArray, ...]
    bare: IntArray

    @property
    def left_out_descriptions(self) -> list[str]:
        """Descriptions of the parts that are left out, each with its first few vertices."""
        said = list[str]()
        if self.pieces:
            sizes = first_few([len(piece) for piece in self.pieces])
            several = f"{len(self.pieces)} other pieces" if len(self.pieces) > 1 else "another piece"
            said.append(f"{several} of {sizes} vertices (vertices {first_few(np.concatenate(self.pieces))})")
        if len(self.pinched):
            said.append(f"vertices {first_few(self.pinched)}, at which the border touches itself")
        if len(self.bare):
            said.append(f"vertices {first_few(self.bare)}, which have no face whose three vertices stay")
        return said


def find_patch_faces(F: IntArray, stays: BoolArray) -> PatchFaces:
    """Return the largest piece of the faces whose three vertices are kept.

    Parameters
    ----------
    F : (#F, 3) int64
        An oriented manifold surface.
    stays : (#V,) bool
        Mask of the vertices to keep.

    Raises
    ------
    MeshError
        The three vertices of no face are kept, or the surface is not an oriented manifold.
    """
    kept = stays.copy()
    pinched = list[IntArray]()
    rows = np.flatnonzero(kept[F].all(axis=1))
    while True:
        if not len(rows):
            raise MeshError("no face has three vertices that stay: leave in more")
        vertices, faces = drop_unused_vertices(F[rows], len(kept))
        corner = np.ascontiguousarray(faces.T)
        _, sides, sound = find_edges(corner, len(vertices))
        if not sound:
            build_topology(faces, vertices)  # raises a `MeshError` for invalid faces
        label = connected_labels((sides[:, sides[1] >= 0] % len(faces)).T, len(faces))
        largest = label == np.bincount(label).argmax()
        if largest.all():
            narrow = vertices[count_fans(corner, sides, len(vertices)) > 1]
            if not len(narrow):
                break
            pinched.append(narrow)
            kept[narrow] = False
            largest = kept[F[rows]].all(axis=1)
        rows = rows[largest]
    all_pinched = np.concatenate([np.zeros(0, dtype=np.int64), *pinched])
    return PatchFaces(rows, vertices, all_pinched, *_find_left_out(F, stays, vertices, all_pinched))


def _find_left_out(
    F: IntArray, stays: BoolArray, vertices: IntArray, pinched: IntArray
) -> tuple[tuple[IntArray, ...], IntArray]:
    """Return the vertices of the other pieces, largest first, and the kept vertices without a face."""
    taken = np.zeros(len(stays), dtype=bool)
    taken[vertices] = taken[pinched] = True
    whole = F[stays[F].all(axis=1)]
    has_face = np.zeros(len(stays), dtype=bool)
    has_face[whole] = True
    bare = np.flatnonzero(stays & ~has_face)
    left = np.flatnonzero(stays & has_face & ~taken)
    if not len(left):
        return (), bare
    edges = whole[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    of = connected_labels(edges[~taken[edges].any(axis=1)], len(stays))[left]
    order = np.argsort(of, kind="stable")
    pieces = np.split(left[order], np.flatnonzero(np.diff(of[order])) + 1)
    return tuple(sorted(pieces, key=len, reverse=True)), bare
