"""Join all parts to one surface, and unwrap it by `igl_linabf.unwrap` with the settings of the operator."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from .objects import CannotUnwrapError
from .scene import Part
from .settings import NO_STRETCH_LIMIT

AXES = {"X": 0, "Y": 1, "Z": 2}


@dataclass(frozen=True)
class Surface:
    """The faces of all parts; `vertices`, `faces` and `corners` are the first index of each part."""

    parts: list[Part]
    vertices: np.ndarray
    faces: np.ndarray
    corners: np.ndarray

    @classmethod
    def of(cls, parts: list[Part]) -> Surface:
        counts = ([len(getattr(part, name)) for part in parts] for name in ("V", "polygons", "loops"))
        return cls(parts, *(np.cumsum([0, *each]) for each in counts))

    def join(self, name: str) -> np.ndarray:
        """Return an attribute, such as "sizes", concatenated over all parts."""
        return np.concatenate([getattr(part, name) for part in self.parts])

    def join_vertices(self, name: str) -> np.ndarray:
        """Return an attribute that contains vertices, concatenated and renumbered over all parts."""
        shifted = zip(self.parts, self.vertices.tolist(), strict=False)
        return np.concatenate([getattr(part, name) + first for part, first in shifted])

    @property
    def polygons(self) -> np.ndarray | list[np.ndarray]:
        """The vertices of each face: an array (#F, k) if all faces have k corners, otherwise a list."""
        corners, sizes = self.join_vertices("corners"), self.join("sizes")
        if (sizes == sizes[0]).all():
            return corners.reshape(len(sizes), -1)
        return np.split(corners, np.cumsum(sizes)[:-1])

    def split_corners(self, values: np.ndarray) -> list[tuple[Part, np.ndarray]]:
        """Return each part with its share of `values`, which has one row per corner."""
        return [(part, values[a:b]) for part, (a, b) in zip(self.parts, pairwise(self.corners), strict=True)]

    def split_faces(self, values: np.ndarray) -> list[tuple[Part, np.ndarray]]:
        """Return each part with its share of `values`, which has one row per face."""
        return [(part, values[a:b]) for part, (a, b) in zip(self.parts, pairwise(self.faces), strict=True)]


def make_atlas(surface: Surface, settings: Any, extend: bool, progress: object) -> Any:
    """Return the atlas of all parts.

    Parameters
    ----------
    surface : the parts
    settings : the operator
    extend : whether marked seams are extended
    progress : the callback of `unwrap`
    """
    # imported here, because the import of SciPy is slow
    from igl_linabf import ChartOptions, Packing, unwrap

    marked, coned = settings.seams == "MARKED", settings.seams == "FOUND" and settings.cones > 0
    if coned:
        _check_cones(settings)
    charts = ChartOptions(
        trade=settings.trade,
        hide=_convert_hide_setting(settings.hide),
        extend=extend,
        max_stretch=settings.max_stretch if settings.max_stretch < NO_STRETCH_LIMIT else None,
        labels=surface.join("materials") if settings.keep_materials else None,
    )
    try:
        packing = Packing(
            resolution=(settings.resolution, settings.height or settings.resolution),
            padding=settings.margin,
            texel_density=settings.texel_density or None,
        )
        return unwrap(
            surface.join("V"),
            surface.polygons,
            surface.join_vertices("seams") if marked else None,
            charts=None if coned else charts,
            method=settings.method,
            cones=settings.cones if coned else None,
            packing=packing,
            progress=progress,
        )
    except ValueError as error:  # a MeshError, or incompatible options
        helps = "; Extend Seams adds the missing seams" if marked and not extend else ""
        raise CannotUnwrapError(f"{error}{helps}") from None


def mirrored_axis(hide: str) -> int:
    """Return the axis along which mirrored objects are reflected; it differs from the axis of `hide`."""
    return 1 if hide.endswith("X") else 0


def _convert_hide_setting(hide: str) -> str | list[float] | None:
    """Return the value of `ChartOptions.hide` for a value of the setting Hide Seams."""
    if hide in ("NOWHERE", "BACK"):
        return "back" if hide == "BACK" else None
    direction = [0.0, 0.0, 0.0]
    direction[AXES[hide[1]]] = 1.0 if hide[0] == "+" else -1.0
    return direction


def _check_cones(settings: Any) -> None:
    """Raise `CannotUnwrapError` if a setting is incompatible with seams through cones."""
    if settings.method not in ("linabf", "abf"):
        raise CannotUnwrapError(
            "Matching Seams needs the method Linear ABF or ABF: choose one, or set it to 0"
        )
    used = {
        "Maximum Stretch": settings.max_stretch < NO_STRETCH_LIMIT,
        "Hide Seams": settings.hide != "NOWHERE",
        "Keep Materials": settings.keep_materials,
    }
    names = [name for name, is_used in used.items() if is_used]
    if names:
        raise CannotUnwrapError(
            f"Matching Seams chooses its own seams, and cannot respect {', '.join(names)}: switch one of "
            "them off"
        )
