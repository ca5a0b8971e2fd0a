"""Where on a surface a pixel is."""

from __future__ import annotations

from typing import Any

import igl
import numpy as np

from .._types import FloatArray, IntArray


def hit_at(renderer: Any, points: FloatArray, F: IntArray, x: int, y: int) -> tuple[int, FloatArray] | None:
    """The face under a pixel and barycentric coordinates in it; None beside the surface."""
    start, end = (_world(renderer, x, y, depth) for depth in (0.0, 1.0))
    hits = igl.ray_mesh_intersect(start, end - start, points, F, first=True)
    if not hits:
        return None
    face, _, second, third = hits[0]
    return face, np.array([1 - second - third, second, third])


def _world(renderer: Any, x: int, y: int, depth: float) -> FloatArray:
    renderer.SetDisplayPoint(x, y, depth)
    renderer.DisplayToWorld()
    point = np.array(renderer.GetWorldPoint())
    return np.asarray(point[:3] / point[3])
