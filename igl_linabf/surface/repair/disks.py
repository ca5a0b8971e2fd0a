"""Repair a disk such that each given vertex becomes at most one vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..._types import FloatArray, IntArray
from ...errors import MeshError, first_few, format_count
from ..arrays import convert_vertex_indices
from .cleaning import Cleaned, clean


@dataclass(frozen=True, eq=False)
class RepairedDisk:
    """A repaired disk.

    Attributes
    ----------
    cleaned : Cleaned
    row : (#given V,) int64
        The vertex of the repaired disk that each given vertex has become; -1 if there is none.
    """

    cleaned: Cleaned
    row: IntArray

    def convert_vertices(self, name: str, given: ArrayLike) -> IntArray:
        """Convert given vertices, passed as the option `name`, to vertices of the repaired disk."""
        used = np.flatnonzero(self.row >= 0)
        return np.asarray(self.row[used[convert_vertex_indices(given, used, len(self.row), name)]])

    def gather_at_vertices(self, values: ArrayLike) -> FloatArray:
        """Return values of the given vertices at the vertices of the repaired disk."""
        array = np.asarray(values, dtype=float)
        if array.shape != self.row.shape:
            raise MeshError(
                f"the array has shape {array.shape}: give a value for each of "
                f"{format_count(len(self.row), 'vertex')}"
            )
        return np.asarray(array[self.cleaned.origin])


def repair_disk(V: ArrayLike, F: ArrayLike) -> RepairedDisk:
    """Repair a surface by `clean`.

    Raises
    ------
    MeshError
        The repair cuts the surface apart at a vertex.
    """
    cleaned = clean(V, F)
    several = np.flatnonzero(np.bincount(cleaned.origin, minlength=len(cleaned.merged)) > 1)
    if len(several):
        raise MeshError(
            f"the repair cuts the surface apart at vertices {first_few(several)}, which would have several "
            "positions in the map: call igl_linabf.clean, and flatten its result, or use igl_linabf.unwrap"
        )
    row = np.full(len(cleaned.merged), -1)
    row[cleaned.origin] = np.arange(len(cleaned.origin))
    return RepairedDisk(cleaned, row[cleaned.merged])
