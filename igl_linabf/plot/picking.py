"""Find the point of a surface under a pixel."""

from typing import Any

import numpy as np
import pyvista as pv

from .._types import FloatArray, IntArray


def pick_face(
    renderer: Any, points: FloatArray, F: IntArray, x: int, y: int
) -> tuple[int, FloatArray] | None:
    """Return the face under a pixel, and barycentric coordinates in this face; None beside the surface."""
    ends = [_to_world(renderer, x, y, depth) for depth in (0.0, 1.0)]
    hits, faces = pv.PolyData.from_regular_faces(points, F).ray_trace(*ends, first_point=False)
    if not len(faces):
        return None
    i = int(np.argmin(np.linalg.norm(hits - ends[0], axis=1)))
    return int(faces[i]), _compute_barycentric(hits[i], points[F[faces[i]]])


def _to_world(renderer: Any, x: int, y: int, depth: float) -> FloatArray:
    """Convert a pixel and a depth from 0 to 1 to a point in space."""
    renderer.SetDisplayPoint(x, y, depth)
    renderer.DisplayToWorld()
    point = np.array(renderer.GetWorldPoint())
    return np.asarray(point[:3] / point[3])


def _compute_barycentric(point: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the barycentric coordinates of a point, clipped to the triangle."""
    sides = np.column_stack((corners[1] - corners[0], corners[2] - corners[0]))
    second, third = np.linalg.lstsq(sides, point - corners[0], rcond=None)[0]
    weights = np.clip([1 - second - third, second, third], 0, 1)
    return np.asarray(weights / weights.sum())
