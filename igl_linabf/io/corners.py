"""Whether faces refer to rows that are there, and finite: one check for all that come from a caller."""

from __future__ import annotations

import numpy as np

from .._types import FloatArray
from ..errors import MeshError, some
from ..surface import Polygons


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
