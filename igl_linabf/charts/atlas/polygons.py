"""Split polygons into triangles for `unwrap`, and convert the results back to polygons."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..._types import BoolArray
from ...errors import MeshError, first_few
from ...surface import Cleaned, Polygons, Repair, Submesh, Triangles, make_seam_mask, vertex_array
from .atlas import Atlas


def split_polygons(V: ArrayLike, F: ArrayLike) -> Triangles | None:
    """Return the triangulation of polygons; None if the faces are triangles.

    Raises
    ------
    MeshError
        Faces have fewer than three corners, or refer to vertices that do not exist.
    """
    try:
        array = np.asarray(F)
    except ValueError:
        array = np.empty(0, dtype=object)  # the faces have different numbers of corners
    if (
        array.shape[1:] == (3,)
        or array.dtype.kind not in "iufO"
        or (array.ndim != 2 and array.dtype != object)
    ):
        return None  # a later check reports invalid arrays
    polygons = Polygons.from_faces(F)
    positions = vertex_array(V)
    polygons.check_vertices(len(positions))
    return polygons.triangulate(positions)


def convert_seams_to_triangles(seams: ArrayLike, split: Triangles, n: int) -> BoolArray:
    """Convert seams of polygons to a mask of the sides of their triangles.

    Parameters
    ----------
    seams : (#E, 2) int, or bool in the shape of F
        Pairs of vertices, or a mask.
    split : Triangles
    n : int
        Number of vertices.

    Raises
    ------
    MeshError
        `seams` has neither form, or a pair is not an edge of a polygon.
    """
    polygons = split.polygons
    try:
        array = np.asarray(seams)
    except ValueError:
        array = np.concatenate([np.asarray(row).ravel() for row in seams])  # type: ignore[union-attr]
    if array.dtype.kind == "b":
        if array.size != len(polygons.corners):
            raise MeshError(
                f"seams is a mask of {array.size} sides for {len(polygons.corners)}: pass F's shape"
            )
        # sides between repeated corners are not sides of any triangle: their marks are dropped
        return np.asarray(array.ravel()[split.place] & ~split.inner)
    mask = make_seam_mask(array, split.F, n)
    pairs = np.sort(array.reshape(-1, 2).astype(np.int64), axis=1)
    ends = np.sort(np.column_stack((polygons.corners, polygons.corners[polygons.next_corner])), axis=1)
    bad = np.flatnonzero(~np.isin(pairs @ [n, 1], ends @ [n, 1]))
    if len(bad):
        raise MeshError(
            f"seam edges {first_few(bad)} are diagonals of polygons (edge {bad[0]} is "
            f"{pairs[bad[0]].tolist()}): give edges of the polygons"
        )
    return np.asarray(mask & ~split.inner)


def mark_diagonals(surface: Submesh, cleaned: Cleaned, split: Triangles) -> Submesh:
    """Mark the diagonals of polygons as sides that no seam may follow, and return the surface."""
    inner = split.inner[cleaned.faces]
    return replace(surface, inner=np.where(cleaned.turned[:, None], inner[:, ::-1], inner))


def convert_repairs_to_polygons(repairs: tuple[Repair, ...], split: Triangles) -> tuple[Repair, ...]:
    """Convert repairs of triangles to repairs of the polygons that contain the triangles."""
    return tuple(
        replace(repair, first=np.unique(split.face[repair.first])) if repair.of == "faces" else repair
        for repair in repairs
    )


def convert_to_polygons(atlas: Atlas, split: Triangles) -> Atlas:
    """Convert the atlas of the triangles to the atlas of the polygons."""
    first = np.searchsorted(split.face, np.arange(len(split.polygons)))
    return replace(
        atlas,
        FTC=split.polygons.reshape_like_faces(split.convert_to_polygon_corners(atlas.FTC)),
        chart=atlas.chart[first],
        charts=tuple(replace(chart, faces=split.face[chart.faces]) for chart in atlas.charts),
        report=replace(atlas.report, split=split),
    )
