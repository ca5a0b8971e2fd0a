"""A surface with texture coordinates, as the caller gives it: one check for all that write it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError, some
from ..surface import Polygons, face_array, vertex_array


def textured(
    V: ArrayLike, F: ArrayLike, TC: ArrayLike, FTC: ArrayLike | None = None
) -> tuple[FloatArray, IntArray, FloatArray, IntArray]:
    """V, F, TC and FTC in the house's types, fitting together; FTC is F where it is not given."""
    positions, faces, map_ = vertex_array(V), face_array(F), vertex_array(TC, 2, "TC")
    corners = faces if FTC is None else face_array(FTC)
    if corners.shape != faces.shape:
        raise MeshError(f"FTC has {len(corners)} rows for {len(faces)} faces: pass one row a face")
    check_corners(positions, Polygons.of_triangles(faces), "F", "V")
    check_corners(map_, Polygons.of_triangles(corners), "F, taken for FTC," if FTC is None else "FTC", "TC")
    return positions, faces, map_, corners


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
