"""Find the seams of texture coordinates, and the prices of the seams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, overload

import numpy as np
from numpy.typing import ArrayLike

from ..._types import BoolArray, FloatArray, IntArray
from ...errors import MeshError, first_few
from ...surface import NEXT, PREV, Polygons, Ragged, Submesh, Topology, merge_coincident, vertex_array
from ..features import CreasedSurface

# Minimum double area of a face with an orientation, relative to its squared coordinates; absorbs rounding.
MIN_TURNING_AREA = 1e-6

Given = ArrayLike | None


@overload
def texture_seams(
    F: ArrayLike, FTC: ArrayLike, V: Given = None, TC: Given = None, *, sides: Literal[False] = False
) -> IntArray: ...


@overload
def texture_seams(
    F: ArrayLike, FTC: ArrayLike, V: Given = None, TC: Given = None, *, sides: Literal[True]
) -> BoolArray | tuple[BoolArray, ...]: ...


def texture_seams(
    F: ArrayLike, FTC: ArrayLike, V: Given = None, TC: Given = None, *, sides: bool = False
) -> IntArray | BoolArray | tuple[BoolArray, ...]:
    """Return the seams of existing texture coordinates.

    An edge is a seam of a face if other faces share the edge, and none of these faces has the same texture
    coordinates at the edge. If `TC` is given, an edge where the map folds over is also a seam: both
    faces are on the same side of the edge in the map, for example where mirrored halves share a texture.

    Parameters
    ----------
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Any triangles or polygons, as in `unwrap`.
    FTC : in the shape of `F`
        Indices of the texture coordinates at the corners, as returned by `igl.readOBJ`.
    V : (#V, 3) float, optional
        Positions. If given, vertices at the same position count as one vertex, as in a triangle soup. By
        default, vertices are identified by their indices.
    TC : (#TC, 2) float, optional
        Texture coordinates. If given, equal coordinates count as one. By default, they are identified by
        their indices.
    sides : bool
        Return a mask instead of pairs of vertices. If more than two faces share an edge, a mask can cut
        some of the faces, whereas a pair of vertices cuts all of them.

    Returns
    -------
    seams : (#E, 2) int64, or bool in the shape of `F`
        The vertices of the edges that are a seam of any face. With `sides`, `[f, k]` is True if the side from
        corner k to k + 1 of face f is a seam.

    Raises
    ------
    MeshError
        The arrays are malformed or do not fit together, or a corner has no texture coordinate.

    Examples
    --------
    >>> texture_seams([[0, 1, 2], [2, 1, 3]], [[0, 1, 2], [4, 1, 3]])
    array([[1, 2]])
    >>> texture_seams([[0, 1, 2], [2, 1, 3]], [[0, 1, 2], [4, 1, 3]], sides=True)
    array([[False,  True, False],
           [ True, False, False]])
    """
    polygons = Polygons.from_faces(F)
    texture = polygons.parse_texture_indices(FTC)
    bad = np.unique(polygons.polygon_of_corner[texture.corners < 0])
    if len(bad):
        raise MeshError(f"faces {first_few(bad)} have corners without texture in FTC: give them coordinates")
    positions = None if V is None else vertex_array(V)
    polygons.check_vertices(int(polygons.corners.max()) + 1 if positions is None else len(positions))
    points = None if TC is None else vertex_array(TC, 2, "TC")
    if points is not None and len(bad := texture.find_out_of_range(len(points))):
        raise MeshError(
            f"faces {first_few(bad)} refer to texture coordinates outside 0..{len(points) - 1}: "
            "correct FTC or complete TC"
        )
    turns = np.zeros(len(polygons), dtype=np.int64) if points is None else _find_orientations(texture, points)
    mask = _find_seam_sides(
        polygons, _number_corners(polygons, positions), _number_corners(texture, points), turns
    )
    if sides:
        return polygons.reshape_like_faces(mask)
    pairs = np.column_stack((polygons.corners, polygons.corners[polygons.next_corner]))[mask]
    return np.unique(np.sort(pairs, axis=1), axis=0)


def _number_corners(faces: Polygons, points: FloatArray | None) -> IntArray:
    """Return a number for each corner: its index or, if points are given, the number of its position."""
    if points is None:
        return faces.corners
    return np.asarray(merge_coincident(points, np.unique(faces.corners))[faces.corners])


def _find_orientations(texture: Polygons, points: FloatArray) -> IntArray:
    """Return the orientation of each face in the map: 1, -1, or 0 if its area is within rounding error."""
    uv = points[texture.corners]
    uv = uv - uv[texture.starts][texture.polygon_of_corner]
    beside = uv[texture.next_corner]
    rows = Ragged.from_sizes(texture.sizes)
    area = rows.sum(uv[:, 0] * beside[:, 1] - uv[:, 1] * beside[:, 0])
    size = rows.max(np.abs(uv).max(axis=1))
    turns = np.abs(area) > MIN_TURNING_AREA * size * np.abs(points).max(initial=0)
    return np.where(turns, np.sign(area), 0).astype(np.int64)


def _find_seam_sides(polygons: Polygons, a: IntArray, s: IntArray, turns: IntArray) -> BoolArray:
    """Return a mask of the sides of faces that are seams.

    A side is a seam unless an adjacent face has the same texture coordinates at the edge and is on the other
    side of the edge in the map. `a` and `s` number the vertices and the texture coordinates at the corners.
    `turns` is the orientation of each face in the map: 1, -1, or 0 without area.
    """
    b, t = a[polygons.next_corner], s[polygons.next_corner]
    forth = a < b
    side = np.column_stack([np.where(forth, *pair) for pair in ((a, b), (b, a), (s, t), (t, s))])
    beyond = np.where(forth, 1, -1) * turns[polygons.polygon_of_corner]
    # faces with fewer than three distinct sides are degenerate
    proper = np.bincount(polygons.polygon_of_corner[a != b], minlength=len(polygons)) > 2
    rows = np.flatnonzero((a != b) & proper[polygons.polygon_of_corner])

    def number_equal_rows(columns: int) -> IntArray:
        return np.unique(side[rows, :columns], axis=0, return_inverse=True)[1].ravel()

    edge, own = number_equal_rows(2), number_equal_rows(4)
    of_edge, of_own = (np.bincount(which)[which] for which in (edge, own))
    on_my_side = np.bincount(3 * own + beyond[rows] + 1, minlength=3 * len(rows))[3 * own + beyond[rows] + 1]
    joined = of_own > np.where(beyond[rows] == 0, 1, on_my_side)
    mask = np.zeros(len(a), dtype=bool)
    mask[rows] = (of_edge > 1) & ~joined
    return mask


def find_seams_and_mismatch(topology: Topology, TC: FloatArray, FTC: IntArray) -> tuple[IntArray, float]:
    """Return the `texture_seams` of a checked surface as pairs of vertices, and the seam mismatch.

    The mismatch is the largest |log(a / b)|, where a and b are the lengths of a seam edge's sides in the map.
    """
    between = find_texture_seam_rows(topology, FTC)
    start, end = FTC.T[NEXT].ravel(), FTC.T[PREV].ravel()
    halves = topology.sides[:, between]
    length = np.linalg.norm(TC[end[halves]] - TC[start[halves]], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):  # sides can have length 0
        ratio = np.abs(np.log(length[0] / length[1]))
    return topology.edges[between], float(np.nan_to_num(ratio, nan=0.0).max(initial=0.0))


def find_texture_seam_rows(topology: Topology, texture: IntArray) -> IntArray:
    """Return the seams of texture coordinates as row indices into `topology.edges`.

    `texture` has the index of the texture coordinates at each corner, (#F, 3).
    """
    first, second = topology.interior_edge_sides
    corner = np.ascontiguousarray(texture.T)
    start, end = corner[NEXT].ravel(), corner[PREV].ravel()  # indices at both ends of each half-edge
    return np.asarray(topology.interior_edges[(start[first] != end[second]) | (end[first] != start[second])])


def find_seam_prices(creased: CreasedSurface, texture: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the inner edges that are seams of texture coordinates, and the price of each.

    `texture` has the index of the texture coordinates at each corner, (#F, 3).
    """
    topology = creased.surface.topology
    rows = np.searchsorted(topology.interior_edges, find_texture_seam_rows(topology, texture))
    return rows, creased.edge_price[rows]


def compute_division_price(creased: CreasedSurface, parts: Sequence[Submesh]) -> float:
    """Return the price of the seams that divide a surface into parts, in units of length."""
    piece = creased.surface
    F, first = np.empty_like(piece.F), 0  # renumber vertices, because parts may share them
    for part in parts:
        F[np.searchsorted(piece.faces, part.faces)] = part.F + first
        first += len(part.V)
    return float(find_seam_prices(creased, F)[1].sum())
