"""Distortion of each triangle by a flat map: angles, singular values and areas."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .._core import triangle_changes
from .._types import BoolArray, FloatArray
from ..errors import takes_vertices_and_faces
from ..surface import Ragged, Submesh, scale_to_unit_size

Measure = Literal["angle", "conformal", "stretch", "area"]
MEASURES: tuple[Measure, ...] = ("angle", "conformal", "stretch", "area")


@takes_vertices_and_faces
def distortion(V: ArrayLike, F: ArrayLike, uv: ArrayLike, measure: Measure = "angle") -> FloatArray:
    """Measure the distortion of each triangle by a flat map; `quality` measures the whole map.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Triangles of any number of components, loops and handles.
    uv : (#V, 2) float
        The map, at any scale; NaN is allowed at vertices that no face uses.
    measure : {"angle", "conformal", "stretch", "area"}
        "angle": mean over the corners of ((angle in uv - angle in 3-D) / angle in 3-D)^2, whose mean over the
        triangles is F/3nt of the paper. "conformal": sigma1 / sigma2; 1 is best. "stretch": the L2 stretch of
        Sander et al. 2001. "area": log(area in uv / area in 3-D); 0 is best, negative means shrunk. For
        "stretch" and "area", the map is scaled to the area of the surface.

    Returns
    -------
    (#F,) float64
        For a collapsed triangle, "conformal" and "stretch" are inf, and "area" is -inf. A flipped triangle
        has the value of its mirror image.

    Raises
    ------
    MeshError
        The arrays do not fit together, `V` or `uv` is not finite, or a face has no area in 3-D.

    Examples
    --------
    >>> V, F = [[0, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2]]
    >>> distortion(V, F, [[0, 0], [1, 0], [0, 1]], "conformal")
    array([2.])
    """
    if measure not in MEASURES:
        raise ValueError(f"measure is {measure!r}: use one of {', '.join(map(repr, MEASURES))}")
    surface = Submesh.from_input(V, F)
    changed = measure_change(surface, surface.check_map(uv))
    if measure == "angle":
        return np.asarray(changed.angle_distortion.mean(axis=0))
    if measure == "conformal":
        return changed.conformal
    if measure == "stretch":
        return np.sqrt(changed.squared_stretch)
    return changed.log_area_ratio


@dataclass(frozen=True, eq=False)
class Change:
    """The change of each triangle by a flat map.

    Attributes
    ----------
    angle, angle_error : (3, #F) float64
        Corner angles in 3-D, and angle in uv - angle in 3-D, in radians.
    double_area, signed : (#F,) float64
        Twice the area in 3-D, and twice the signed area in uv, scaled by `scale_to_unit_size`.
    major, minor : (#F,) float64
        The singular values sigma1 >= sigma2 of the map.
    sides : (3, #F) float64
        Ratio of the length in uv to the length in 3-D of the side opposite to each corner.
    scale : float, or (#F,) float64
        Ratio of the area in uv to the area in 3-D of the whole map. If the faces belong to several maps, it
        is the ratio of the map of each face.
    """

    angle: FloatArray
    angle_error: FloatArray
    double_area: FloatArray
    signed: FloatArray
    major: FloatArray
    minor: FloatArray
    sides: FloatArray
    scale: float | FloatArray

    @property
    def angle_distortion(self) -> FloatArray:
        """Squared relative errors of angles, (3, #F) float64, whose mean is F/3nt of the paper."""
        return np.asarray((self.angle_error / self.angle) ** 2)

    def area_weighted_mean(self, values: FloatArray) -> float:
        """Return the mean of values of the faces, (#F,), weighted by area in 3-D."""
        return float(self.double_area @ values) / float(self.double_area.sum())

    @property
    def is_flipped(self) -> BoolArray:
        """Mask of the flipped or collapsed triangles, (#F,) bool."""
        return ~(self.signed > 0)

    @property
    def conformal(self) -> FloatArray:
        """Conformal distortion sigma1 / sigma2; infinite for collapsed triangles."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.minor > 0, self.major / self.minor, np.inf)

    @cached_property
    def squared_stretch(self) -> FloatArray:
        """Square of the L2 stretch, with the map scaled to the area of the surface."""
        with np.errstate(divide="ignore", invalid="ignore"):
            squared = self.scale * (self.minor**-2.0 + self.major**-2.0) / 2
            return np.where(self.minor > 0, squared, np.inf)

    @property
    def largest_stretch(self) -> FloatArray:
        """Linf stretch, with the map scaled to the area of the surface."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.minor > 0, np.sqrt(self.scale) / self.minor, np.inf)

    @property
    def symmetric_dirichlet(self) -> FloatArray:
        """(s1^2 + s2^2 + s1^-2 + s2^-2) / 4, with the map scaled to the area of the surface."""
        with np.errstate(divide="ignore", invalid="ignore"):
            squared = (self.major**2 + self.minor**2) / self.scale / 2  # NaN in a map without area
            return np.where(self.minor > 0, (squared + self.squared_stretch) / 2, np.inf)

    @cached_property
    def edge_change(self) -> FloatArray:
        """Relative change of side lengths, (3, #F), with the map scaled to the area of the surface."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.scale > 0, np.abs(self.sides / np.sqrt(self.scale) - 1), np.inf)

    @cached_property
    def log_area_ratio(self) -> FloatArray:
        """log(area in uv / area in 3-D), with the map scaled to the area of the surface."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(np.abs(self.signed) / self.double_area / self.scale)
            return np.where(self.signed != 0, ratio, -np.inf)


def measure_change(surface: Submesh, map_: FloatArray, parts: Ragged | None = None) -> Change:
    """Measure the change of each triangle by a checked map (#V, 2) of a checked surface.

    If `parts` divides the faces into several maps, each map has its own scale.
    """
    map_ = scale_to_unit_size(map_)
    corner = np.ascontiguousarray(surface.F.T)
    double_area, dot = surface.areas_and_products
    angle, error, signed, major, minor, sides = triangle_changes(surface.V, map_, corner, double_area, dot)
    scale: float | FloatArray
    if parts is None:
        scale = float(np.abs(signed).sum() / double_area.sum())
    else:
        scale = parts.repeat(parts.sum(np.abs(signed)) / parts.sum(double_area))
    return Change(angle, error, double_area, signed, major, minor, sides, scale)
