"""The texture coordinates that images are baked for: an atlas, a map, or coordinates of any program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..charts import UDIM_ROW, Atlas
from ..errors import MeshError, first_few
from ..surface import Polygons, Triangles, vertex_array

Coordinates = Atlas | ArrayLike | tuple[ArrayLike, Any]

TILE_TOLERANCE = 1e-6  # distance by which texture coordinates may leave their tile, in tile widths


@dataclass(frozen=True, eq=False)
class MappedTriangles:
    """The triangles of a surface, with texture coordinates at their corners.

    Attributes
    ----------
    V : (#V, 3) float64
    F : (#T, 3) int64
        Vertices at the corners.
    TC : (#TC, 2) float64
    rows : (#T, 3) int64
        Rows of `TC` at the corners.
    page : (#T,) int64
        UDIM tile of each triangle, minus 1001; -1 without texture coordinates.
    split : Triangles or None
        The triangulation of the polygons; None if the faces are triangles.
    aspect : float or None
        Height of a page over its width, if known.
    """

    V: FloatArray
    F: IntArray
    TC: FloatArray
    rows: IntArray
    page: IntArray
    split: Triangles | None
    aspect: float | None = None

    @property
    def pages(self) -> int:
        """Number of pages, at least 1."""
        return int(self.page.max(initial=0)) + 1

    @classmethod
    def from_mesh(cls, V: ArrayLike, F: Any, coordinates: Coordinates) -> MappedTriangles:
        """Check the caller's mesh and its texture coordinates.

        Raises
        ------
        MeshError
            The arrays do not match, or a triangle leaves its UDIM tile.
        """
        positions = vertex_array(V)
        if isinstance(coordinates, Atlas):
            return cls._from_atlas(positions, coordinates)
        TC, FTC = (
            coordinates if isinstance(coordinates, tuple) and len(coordinates) == 2 else (coordinates, F)
        )
        polygons, points = Polygons.from_faces(F), vertex_array(TC, 2, "uv" if FTC is F else "TC")
        polygons.check_vertices(len(positions))
        texture = polygons.parse_texture_indices(FTC)
        bad = np.unique(texture.polygon_of_corner[texture.corners >= len(points)])
        if len(bad):
            raise MeshError(
                f"faces {first_few(bad)} refer to texture coordinates outside 0..{len(points) - 1}: give a "
                "row for each vertex, or TC and FTC as a pair"
            )
        split = polygons.triangulate(positions)
        rows = texture.corners[split.place]
        page = _find_tiles(points, rows, split.face)
        only_triangles = bool((polygons.sizes == 3).all())
        return cls(positions, split.F, points, rows, page, None if only_triangles else split)

    @classmethod
    def _from_atlas(cls, V: FloatArray, atlas: Atlas) -> MappedTriangles:
        if len(atlas.origin) and int(atlas.origin.max()) >= len(V):
            raise MeshError(f"the atlas has more vertices than the {len(V)} of V: pass the unwrapped V")
        rows, split = atlas.triangles, atlas.report.split
        chart = atlas.chart if split is None else atlas.chart[split.face]
        page, used = np.zeros(len(rows), dtype=np.int64), chart >= 0
        page[used] = atlas.page[chart[used]]
        return cls(V, atlas.origin[rows], atlas.TC, rows, page, split, atlas.report.aspect)


def _find_tiles(TC: FloatArray, rows: IntArray, face: IntArray) -> IntArray:
    """Return the UDIM tile of each triangle, minus 1001; -1 for triangles without texture coordinates."""
    page = np.full(len(rows), -1)
    mapped = np.flatnonzero((rows >= 0).all(axis=1))
    corners = TC[rows[mapped]]
    finite = np.isfinite(corners).all(axis=(1, 2))
    if not finite.all():
        raise MeshError(
            f"texture coordinates of faces {first_few(face[mapped[~finite]])} are NaN or infinite"
        )
    tile = np.floor(corners.mean(axis=1))
    beyond = np.abs(corners - tile[:, None] - 0.5).max(axis=(1, 2)) > 0.5 + TILE_TOLERANCE
    outside = beyond | (tile < 0).any(axis=1) | (tile[:, 0] >= UDIM_ROW)
    if outside.any():
        raise MeshError(
            f"texture coordinates of faces {first_few(face[mapped[outside]])} are outside the unit square, "
            "or cross the border of their UDIM tile: scale a map by igl_linabf.io.unit_square, or pack "
            "charts by igl_linabf.uv.pack"
        )
    page[mapped] = tile.astype(np.int64) @ [1, UDIM_ROW]
    return page
