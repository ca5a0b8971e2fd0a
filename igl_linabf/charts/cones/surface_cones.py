"""The cones that a caller wants, on the repaired surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..._types import FloatArray, IntArray
from ...errors import MeshError, some
from ...surface import Cleaned, Submesh
from .options import Cones


@dataclass(frozen=True, eq=False)
class SurfaceCones:
    """The cones that are asked for, on a surface.

    Attributes
    ----------
    vertices : (#C,) int64, int or None
        Vertices of the surface. Or how many cones are to be found on each component; None: as many as pay.
    angles : (#C,) float64, "quarter" or None
        Their angle sums, radians. "quarter": multiples of 90 degrees, chosen for little stretch. None: those
        of the conformal map whose scale is one at all cones.
    """

    vertices: IntArray | int | None
    angles: FloatArray | Literal["quarter"] | None

    @classmethod
    def of(cls, cones: Cones, surface: Submesh, cleaned: Cleaned) -> SurfaceCones:
        """What the caller gives; its vertices become those of the repaired surface.

        Raises
        ------
        MeshError
            A cone is no vertex of the surface, or on its boundary, or there twice.
        """
        given, angles = np.asarray(cones.at), cones.angles
        if given.ndim == 0:
            return cls(None if cones.at == "auto" else int(given), None if angles is None else "quarter")
        given = given.astype(np.int64)
        outside = (given < 0) | (given >= len(cleaned.merged))
        if outside.any():
            raise MeshError(f"cones {some(given[outside])} are not within 0..{len(cleaned.merged) - 1}")
        cone, vertex = _repaired_cones(given, surface, cleaned)
        if angles is None or isinstance(angles, str):
            return cls(vertex, None if angles is None else "quarter")
        return cls(vertex, np.asarray(angles, dtype=np.float64)[cone])


def _repaired_cones(given: IntArray, surface: Submesh, cleaned: Cleaned) -> tuple[IntArray, IntArray]:
    """The cones on the repaired surface: for each the index in `given`, and its vertex.

    A given vertex where the surface was cut open is several vertices of the repaired one.
    """
    own = cleaned.merged[cleaned.origin]  # what a caller may call each vertex of the surface
    order = np.argsort(own, kind="stable")
    wanted = cleaned.merged[given]
    first, end = (np.searchsorted(own[order], wanted, side) for side in ("left", "right"))
    if (first == end).any():
        raise MeshError(f"cones {some(given[first == end])} belong to no face: give vertices of the surface")
    cone = np.repeat(np.arange(len(given)), end - first)
    at = np.concatenate(
        [order[a:b] for a, b in zip(first.tolist(), end.tolist(), strict=True)] or [order[:0]]
    )
    if len(np.unique(at)) < len(at):
        number = np.bincount(at)
        raise MeshError(f"cones {some(given[cone[number[at] > 1]])} are the same vertices: give each once")
    rim = ~surface.topology.interior[at]
    if rim.any():
        raise MeshError(
            f"cones {some(given[cone[rim]])} are on the boundary, whose angles are free: "
            "give interior vertices"
        )
    return cone, surface.vertices[at]
