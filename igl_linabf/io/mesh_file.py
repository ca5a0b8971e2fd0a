"""What a mesh file holds, as a value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError, some
from ..surface import Faces, Polygons, Triangles, vertex_array
from .parsing import NO_EXTRAS, Extras

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
    """PNG files for the texture coordinates that are written.

    Attributes
    ----------
    maps : mapping of str to tuple of bytes
        By the kind of map, "baseColorTexture" for colours, the file of each page.
    moved : bool
        They take the places of old images, in the materials that had one of that kind. Else the colours are
        those of all materials.
    """

    maps: Mapping[str, tuple[bytes, ...]]
    moved: bool = False

    @property
    def pages(self) -> int:
        """Their number."""
        return max(map(len, self.maps.values()), default=1)


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh, and what else its file has.

    `unwrap(mesh.V, mesh.F)` makes texture coordinates for it, `write_file` writes all of it again with them.

    Attributes
    ----------
    V : (#V, 3) float64
    polygons : Polygons
        The faces, corner after corner.
    TC : (#TC, 2) float64 or None
        Texture coordinates, v upwards.
    texture : (#C,) int64 or None
        Their rows at the corners; -1 where there is none.
    extras : Extras
        Normals, colours, names, and what only the format itself can keep.
    path : Path or None
        Where it was read from.
    images : Images or None
        To be written as its textures.
    first : (#TC, 2) float64 and (#C,) int64, or None
        The first texture coordinates and their rows at the corners, where `TC` are to be the second ones.
    """

    V: FloatArray
    polygons: Polygons
    TC: FloatArray | None = None
    texture: IntArray | None = None
    extras: Extras = NO_EXTRAS
    path: Path | None = None
    images: Images | None = None
    first: tuple[FloatArray, IntArray] | None = None

    @property
    def F(self) -> Faces:  # noqa: N802  # as everywhere
        """The faces: (#F, k) if all have k corners, else a tuple of arrays, one a face."""
        return self.polygons.shaped

    @property
    def FTC(self) -> Faces | None:  # noqa: N802
        """Rows of `TC` at the corners, in the shape of `F`; None without texture coordinates."""
        return None if self.texture is None else self.polygons.shape(self.texture)

    @cached_property
    def split(self) -> Triangles:
        """The triangles of the faces."""
        return self.polygons.split(self.V)

    @property
    def triangles(self) -> IntArray:
        """The vertices of the triangles that the faces are split into, (#T, 3)."""
        return self.split.F

    @property
    def colours(self) -> FloatArray | None:
        """Colours of the vertices, (#V, 3 or 4), from 0 to 1; None if the file has none."""
        return self.extras.colours

    @property
    def units(self) -> Unit | None:
        """The unit of length, as `write_pattern` takes it; None if the file does not say."""
        return None if self.extras.units is None else UNIT_SYMBOLS[self.extras.units]

    @property
    def parts(self) -> tuple[str, ...]:
        """The names of the objects, or groups."""
        return () if self.extras.parts is None else self.extras.parts[0]

    @property
    def materials(self) -> tuple[str, ...]:
        """The names of the materials."""
        return () if self.extras.materials is None else self.extras.materials[0]

    def with_second(self, TC: ArrayLike, FTC: ArrayLike | None = None) -> MeshFile:
        """The same with other texture coordinates beside its own, as lightmaps need them.

        Raises
        ------
        MeshError
            It has none at all corners, or the arrays do not fit to the faces.
        """
        if self.TC is None or self.texture is None or (self.texture < 0).any():
            raise MeshError(
                "the mesh has no first texture coordinates at all corners, beside which second ones could "
                "stand: unwrap it without texcoord=1 (--texcoord 1)"
            )
        return replace(self.textured(TC, FTC), first=(self.TC, self.texture))

    def textured(self, TC: ArrayLike, FTC: ArrayLike | None = None) -> MeshFile:
        """The same with other texture coordinates.

        Parameters
        ----------
        TC : (#TC, 2) float
            Rows that are not finite are left out; no corner may use one.
        FTC : in the shape of `F`, optional
            Their rows at the corners; by default `F`.

        Returns
        -------
        MeshFile

        Raises
        ------
        MeshError
            The arrays do not fit to the faces.
        """
        map_ = vertex_array(TC, 2, "TC")
        texture = self.polygons if FTC is None else self.polygons.texture_of(FTC)
        check_corners(map_, texture, "F, taken for FTC," if FTC is None else "FTC", "TC")
        used = np.isfinite(map_).all(axis=1)
        number = np.cumsum(used) - 1
        return replace(self, TC=map_[used], texture=number[texture.corners])


def at_triangles(mesh: MeshFile, values: IntArray) -> IntArray:
    """Values at the corners of the faces as rows of the triangles that they are split into."""
    return values.reshape(-1, 3) if (mesh.polygons.sizes == 3).all() else values[mesh.split.place]


def check_corners(rows: FloatArray, index: Polygons, index_name: str, name: str) -> None:
    """Raise where faces refer to rows that are not there, or not finite."""
    outside = index.outside(len(rows))
    if len(outside):
        first = index.corners[index.owner == outside[0]].tolist()
        raise MeshError(
            f"faces {some(outside)} refer in {index_name} to rows outside 0..{len(rows) - 1} of {name} "
            f"(face {outside[0]} is {first}): correct the indices or complete {name}"
        )
    finite = np.asarray(np.isfinite(rows).all(axis=1))
    missing = np.unique(index.owner[~finite[index.corners]])
    if len(missing):
        raise MeshError(
            f"faces {some(missing)} have corners whose coordinates in {name} are NaN or infinite: "
            "give them coordinates, or leave the faces out"
        )
