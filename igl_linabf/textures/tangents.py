"""Tangent frames of maps, by which normal maps say directions: those of mikktspace, as most programs take."""

from typing import NamedTuple

import numpy as np

from .._types import FloatArray, IntArray
from ..surface import merge_coincident, unit_vectors


class Frames(NamedTuple):
    """Tangent, bitangent and normal at the corners of triangles, (#T, 3, 3) each."""

    tangent: FloatArray
    bitangent: FloatArray
    normal: FloatArray


def tangent_frames(points: FloatArray, normals: FloatArray, uv: FloatArray) -> Frames:
    """The frames of a map at corners.

    At corners with the same position, normal and texture coordinates it is the mean of the triangles'
    tangents by angle, of those that the map does not mirror and of the others apart.

    Parameters
    ----------
    points, normals : (#T, 3, 3) float64
    uv : (#T, 3, 2) float64
        v upwards.
    """
    e, d = points[:, 1:] - points[:, :1], uv[:, 1:] - uv[:, :1]
    double_area = d[:, 0, 0] * d[:, 1, 1] - d[:, 0, 1] * d[:, 1, 0]
    sign = np.where(double_area < 0, -1.0, 1.0)
    along = sign[:, None] * (e[:, 0] * d[:, 1, 1:] - e[:, 1] * d[:, 0, 1:])
    own = (
        unit_vectors(_tangential(np.repeat(along[:, None], 3, axis=1), normals))
        * _angles(points, normals)[..., None]
    )
    flat = np.column_stack((points.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), sign.repeat(3)))
    same: IntArray = merge_coincident(flat, np.arange(len(flat)))
    total = np.zeros((len(flat), 3))
    np.add.at(total, same, own.reshape(-1, 3))
    tangent = unit_vectors(total[same]).reshape(-1, 3, 3)
    return Frames(tangent, sign[:, None, None] * np.cross(normals, tangent), normals)


def reexpressed(directions: FloatArray, old: Frames, new: Frames) -> FloatArray:
    """Directions (n, 3) in old frames (n, 3 each), in new ones; as they are where a frame is none."""
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
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _tangential(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """The part of vectors that is at right angles to normals of length one."""
    return np.asarray(vectors - (vectors * normals).sum(axis=-1, keepdims=True) * normals)


def _angles(points: FloatArray, normals: FloatArray) -> FloatArray:
    """The angles of triangles at their corners (#T, 3), as seen along the normals there."""
    ahead, back = (unit_vectors(_tangential(np.roll(points, k, axis=1) - points, normals)) for k in (-1, 1))
    return np.asarray(np.arccos(np.clip((ahead * back).sum(axis=-1), -1, 1)))
