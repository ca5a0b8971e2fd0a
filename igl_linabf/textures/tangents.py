"""Compute tangent frames of texture maps (mikktspace), the coordinate systems of normal maps."""

from typing import NamedTuple

import numpy as np

from .._types import FloatArray, IntArray
from ..surface import merge_coincident, normalize_vectors


class TangentFrames(NamedTuple):
    """Tangent, bitangent and normal at the corners of triangles, each (#T, 3, 3)."""

    tangent: FloatArray
    bitangent: FloatArray
    normal: FloatArray


def compute_tangent_frames(points: FloatArray, normals: FloatArray, uv: FloatArray) -> TangentFrames:
    """Compute the tangent frames of a map at the corners of triangles.

    Corners with the same position, normal and texture coordinates share the mean of the tangents of their
    triangles, weighted by angle. Mirrored triangles are averaged separately.

    Parameters
    ----------
    points, normals : (#T, 3, 3) float64
    uv : (#T, 3, 2) float64
        Texture coordinates, with v pointing up.
    """
    e, d = points[:, 1:] - points[:, :1], uv[:, 1:] - uv[:, :1]
    double_area = d[:, 0, 0] * d[:, 1, 1] - d[:, 0, 1] * d[:, 1, 0]
    sign = np.where(double_area < 0, -1.0, 1.0)
    along = sign[:, None] * (e[:, 0] * d[:, 1, 1:] - e[:, 1] * d[:, 0, 1:])
    own = (
        normalize_vectors(_project_to_tangent(np.repeat(along[:, None], 3, axis=1), normals))
        * _compute_angles(points, normals)[..., None]
    )
    flat = np.column_stack((points.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), sign.repeat(3)))
    same: IntArray = merge_coincident(flat, np.arange(len(flat)))
    total = np.zeros((len(flat), 3))
    np.add.at(total, same, own.reshape(-1, 3))
    tangent = normalize_vectors(total[same]).reshape(-1, 3, 3)
    return TangentFrames(tangent, sign[:, None, None] * np.cross(normals, tangent), normals)


def change_frames(directions: FloatArray, old: TangentFrames, new: TangentFrames) -> FloatArray:
    """Convert directions (n, 3) from old to new tangent frames, except where a frame is degenerate."""
    tangent, bitangent, normal = new
    there = np.einsum("nk,knd->nd", directions, np.stack(old))
    volume = _dot(np.cross(tangent, bitangent), normal)
    rows = np.cross(bitangent, normal), np.cross(normal, tangent), np.cross(tangent, bitangent)
    with np.errstate(divide="ignore", invalid="ignore"):
        made = np.column_stack([_dot(row, there) / volume for row in rows])
    old_volume = _dot(np.cross(old.tangent, old.bitangent), old.normal)
    known = np.isfinite(made).all(axis=1) & (volume != 0) & (old_volume != 0)
    return np.where(known[:, None], made, directions)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the dot product of each row of `a` with the same row of `b`."""
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _project_to_tangent(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """Project vectors to the planes perpendicular to unit normals."""
    return np.asarray(vectors - (vectors * normals).sum(axis=-1, keepdims=True) * normals)


def _compute_angles(points: FloatArray, normals: FloatArray) -> FloatArray:
    """Return the corner angles of triangles, (#T, 3), after projection along the normals."""
    ahead, back = (
        normalize_vectors(_project_to_tangent(np.roll(points, k, axis=1) - points, normals)) for k in (-1, 1)
    )
    return np.asarray(np.arccos(np.clip((ahead * back).sum(axis=-1), -1, 1)))
