"""Define `MeshFile`, a mesh together with all contents of its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, first_few
from ..surface import Faces, Polygons, Triangles, vertex_array
from .parsing import NO_EXTRAS, Extras
from .references import Folder

Unit = Literal["um", "mm", "cm", "m", "in", "ft"]
UNIT_SYMBOLS: dict[str, Unit] = {
    "micron": "um",
    "millimeter": "mm",
    "centimeter": "cm",
    "meter": "m",
    "inch": "in",
    "foot": "ft",
}


@dataclass(frozen=True, eq=False)
class Images:
    """Images for the new texture coordinates, as PNG files.

    Attributes
    ----------
    maps : mapping of str to tuple of bytes
        For each kind of map, such as "baseColorTexture" for colours, one PNG file for each page.
    moved : bool
        Whether the images replace old images of the same kind in each material. Otherwise the colour image
        is the texture of all materials.
    """

    maps: Mapping[str, tuple[bytes, ...]]
    moved: bool = False

    @property
    def pages(self) -> int:
        """The number of pages of the atlas."""
        return max(map(len, self.maps.values()), default=1)


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh together with all other contents of its file.

    `unwrap(mesh.V, mesh.F)` computes texture coordinates, and `write_file` writes them with all contents.

    Attributes
    ----------
    V : (#V, 3) float64
    polygons : Polygons
        The faces as concatenated corners.
    TC : (#TC, 2) float64 or None
        Texture coordinates, v upwards.
    texture : (#C,) int64 or None
        Rows of `TC` at the corners; -1 for corners without texture coordinates.
    extras : Extras
        Normals, colours, names, and data that only the file's own format can store.
    path : Path or None
        The file that was read.
    images : Images or None
        Images to be written as textures.
    first : (#TC, 2) float64 and (#C,) int64, or None
        The first texture coordinates and their rows at the corners, if `TC` are second texture coordinates.
    allow_outside : bool
        Whether references of the file to files outside its folder are followed.
    """

    V: FloatArray
    polygons: Polygons
    TC: FloatArray | None = None
    texture: IntArray | None = None
    extras: Extras = NO_EXTRAS
    path: Path | None = None
    images: Images | None = None
    first: tuple[FloatArray, IntArray] | None = None
    allow_outside: bool = False

    @property
    def folder(self) -> Folder | None:
        """The base folder of relative references in the file; None if no file was read."""
        return None if self.path is None else Folder(self.path.parent, self.allow_outside)

    @property
    def F(self) -> Faces:  # noqa: N802
        """The faces: (#F, k) if all have k corners, otherwise a tuple with one array per face."""
        return self.polygons.as_faces

    @property
    def FTC(self) -> Faces | None:  # noqa: N802
        """Rows of `TC` at the corners, in the shape of `F`; None without texture coordinates."""
        return None if self.texture is None else self.polygons.reshape_like_faces(self.texture)

    @cached_property
    def triangulation(self) -> Triangles:
        """The faces split into triangles."""
        return self.polygons.triangulate(self.V)

    @property
    def triangles(self) -> IntArray:
        """The vertices of the faces' triangles, (#T, 3)."""
        return self.triangulation.F

    @property
    def colours(self) -> FloatArray | None:
        """Colours of the vertices, (#V, 3 or 4), from 0 to 1; None if the file has none."""
        return self.extras.colours

    @cached_property
    def lacks_texture(self) -> BoolArray:
        """Mask of the faces, (#F,), that lack texture coordinates at a corner."""
        bare = np.ones(len(self.polygons), dtype=bool)
        if self.texture is not None:
            bare[:] = False
            bare[self.polygons.polygon_of_corner[self.texture < 0]] = True
        return bare

    def list_parts_without_texture(self) -> list[str]:
        """Return the names of the parts with faces that lack texture coordinates, or the numbers of faces."""
        names, of_face = self.extras.parts or ((), np.full(len(self.polygons), -1))
        found = np.unique(of_face[self.lacks_texture]).tolist()
        if found and found[0] >= 0:
            return [names[i] for i in found]
        return [f"faces {first_few(np.flatnonzero(self.lacks_texture))}"] if found else []

    @property
    def units(self) -> Unit | None:
        """The unit of length, as an argument of `write_pattern`; None if the file does not specify it."""
        return None if self.extras.units is None else UNIT_SYMBOLS[self.extras.units]

    @property
    def parts(self) -> tuple[str, ...]:
        """The names of the objects or groups."""
        return () if self.extras.parts is None else self.extras.parts[0]

    @property
    def materials(self) -> tuple[str, ...]:
        """The names of the materials."""
        return () if self.extras.materials is None else self.extras.materials[0]

    def with_second_texture(self, TC: ArrayLike, FTC: ArrayLike | None = None) -> MeshFile:
        """Return the mesh with second texture coordinates in addition to its own, for example for lightmaps.

        Corners without first texture coordinates get the second coordinates in both sets, because formats
        need a first set. If the mesh was read with `texcoord=1`, its second texture coordinates are replaced.

        Raises
        ------
        MeshError
            The mesh has no texture coordinates, or the arrays do not match the faces.
        """
        if self.TC is None or self.texture is None:
            raise MeshError(
                "second texture coordinates need first texture coordinates: unwrap the mesh without "
                "texcoord=1"
            )
        new = self.with_texture(TC, FTC)
        assert new.TC is not None and new.texture is not None
        first, rows = self.first or (self.TC, self.texture)
        lacking = (rows < 0) & (new.texture >= 0)
        if lacking.any():
            rows = np.where(lacking, len(first) + new.texture, rows)
            first = np.concatenate((first, new.TC))
        return replace(new, first=(first, rows))

    def with_texture(self, TC: ArrayLike, FTC: ArrayLike | None = None) -> MeshFile:
        """Return the mesh with other texture coordinates.

        Parameters
        ----------
        TC : (#TC, 2) float
            Rows that are not finite are skipped; no corner may refer to one.
        FTC : same shape as `F`, optional
            Rows of `TC` at the corners; by default `F`. Faces in `lacks_texture` may keep the index -1.

        Returns
        -------
        MeshFile

        Raises
        ------
        MeshError
            The arrays do not match the faces.
        """
        map_ = vertex_array(TC, 2, "TC")
        texture = self.polygons if FTC is None else self.polygons.parse_texture_indices(FTC)
        is_free = (
            (texture.corners == -1)
            & self.lacks_texture[texture.polygon_of_corner]
            & (self.texture is not None)
        )
        given = np.where(is_free, texture.corners.max(initial=-1), texture.corners)
        name = "F, used as FTC," if FTC is None else "FTC"
        check_corners(map_, replace(texture, corners=given), name, "TC")
        used = np.isfinite(map_).all(axis=1)
        number = np.cumsum(used) - 1
        return replace(self, TC=map_[used], texture=np.where(is_free, -1, number[given]), first=None)

    def fill_missing_texture(self) -> MeshFile:
        """Return the mesh with texture coordinates at all corners.

        Corners without texture coordinates get (0, 0) with v downwards, the position that glTF viewers use
        for such corners.
        """

        def fill_rows(TC: FloatArray, rows: IntArray) -> tuple[FloatArray, IntArray]:
            return np.concatenate((TC, [[0.0, 1.0]])), np.where(rows < 0, len(TC), rows)

        if self.TC is None or self.texture is None:
            return self
        filled = self
        if (self.texture < 0).any():
            TC, texture = fill_rows(self.TC, self.texture)
            filled = replace(self, TC=TC, texture=texture)
        if self.first is not None and (self.first[1] < 0).any():
            filled = replace(filled, first=fill_rows(*self.first))
        return filled


def gather_at_triangles(mesh: MeshFile, values: IntArray) -> IntArray:
    """Convert values at the corners of the faces, (#C,), to values at the corners of triangles, (#T, 3)."""
    return values.reshape(-1, 3) if (mesh.polygons.sizes == 3).all() else values[mesh.triangulation.place]


def check_corners(rows: FloatArray, index: Polygons, index_name: str, name: str) -> None:
    """Raise a `MeshError` if faces refer to rows that are missing or not finite."""
    outside = index.find_out_of_range(len(rows))
    if len(outside):
        first = index.corners[index.polygon_of_corner == outside[0]].tolist()
        raise MeshError(
            f"faces {first_few(outside)} refer in {index_name} to rows outside 0..{len(rows) - 1} of {name} "
            f"(face {outside[0]} is {first}): correct the indices or complete {name}"
        )
    finite = np.asarray(np.isfinite(rows).all(axis=1))
    missing = np.unique(index.polygon_of_corner[~finite[index.corners]])
    if len(missing):
        raise MeshError(
            f"faces {first_few(missing)} have corners whose coordinates in {name} are NaN or infinite: "
            "give them coordinates, or leave the faces out"
        )
