"""Creases: the edges along which faces meet at an angle, and which of them are sharp."""

from __future__ import annotations

import numpy as np

from .._types import FloatArray, IntArray
from ..surface import NEXT, PREV, Submesh

NOISE = 2.0**-23  # of the extent: what coordinates in single precision are off by
UNSURE = 100.0  # times the noise: faces of less height have a normal that means nothing
NEIGHBOURS = 8  # slivers in a row that take over the normal of the next face
STRAIGHT, ROUNDING = 0.1, 1e-5  # radians
SOFT, SHARP = np.deg2rad([15.0, 40.0])  # bends from which an edge begins to be a crease, and is one


def extent(V: FloatArray) -> float:
    """The longest side of the bounding box."""
    return float(np.ptp(V, axis=0).max())


def lengths_of(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def edge_lengths(V: FloatArray, edges: IntArray) -> FloatArray:
    return lengths_of(V[edges[:, 0]] - V[edges[:, 1]])


def face_normals(component: Submesh) -> FloatArray:
    """Unit normals, (#F, 3); those of slivers are their neighbours', so that rounding bends no plane."""
    V, F, topology = component.V, component.F, component.topology
    double_area, dot = component.measured
    a, b, c = V[F.T]
    normal = np.cross(b - a, c - a)
    squared_side = dot[NEXT] + dot[PREV]  # opposite to each corner
    longest = squared_side.argmax(axis=0)
    normal /= np.maximum(double_area, np.finfo(float).tiny)[:, None]
    unsure = double_area < UNSURE * NOISE * extent(V) * np.sqrt(squared_side.max(axis=0))
    if unsure.any():
        m = len(F)
        twin = np.full(3 * m, -1)
        first, second = topology.sides[:, topology.sides[1] >= 0]
        twin[first], twin[second] = second, first
        other = twin[longest * m + np.arange(m)]
        other = np.where(other < 0, np.arange(m), other % m)
        for _ in range(NEIGHBOURS):
            rows = np.flatnonzero(unsure & ~unsure[other])
            if not len(rows):
                break
            normal[rows], unsure[rows] = normal[other[rows]], False
    return np.asarray(normal)


def bends(component: Submesh, normal: FloatArray) -> FloatArray:
    """Angle between the normals at each edge of two faces; negative where the surface is concave."""
    topology, m = component.topology, len(component.F)
    sides = topology.sides[:, topology.sides[1] >= 0]
    first, second = sides % m
    turned = normal[first] - normal[second]
    bend = 2 * np.arcsin(np.minimum(lengths_of(turned) / 2, 1))
    apex = topology.corner.ravel()[sides]  # opposite to the edge, on its two sides
    rise = np.einsum("ij,ij->i", component.V[apex[1]] - component.V[apex[0]], turned)
    return np.asarray(np.where(rise > 0, -bend, bend))


def flat_share(component: Submesh) -> float:
    """The share of the area in faces with a neighbour nearly in their plane.

    A normal may turn by `STRAIGHT` along a way as long as the surface is large. On smooth surfaces, fine or
    coarse, that is about a tenth of the area.
    """
    topology, m = component.topology, len(component.F)
    inside = topology.sides[1] >= 0
    sides, (a, b) = topology.sides[:, inside] % m, topology.edges[inside].T
    double_area = component.measured[0]
    length = lengths_of(component.V[a] - component.V[b])
    way = double_area[sides].sum(axis=0) / np.maximum(length, np.finfo(float).tiny)
    bend = np.abs(bends(component, face_normals(component)))
    straight = bend < STRAIGHT * way / np.sqrt(double_area.sum() / 2) + ROUNDING
    flat = np.zeros(m, dtype=bool)
    flat[sides[:, straight]] = True
    return float(double_area[flat].sum() / double_area.sum())


def sharpness(bend: FloatArray) -> FloatArray:
    """From 0 for an edge that is no crease to 1 for one that shading shows anyway."""
    return np.asarray(np.clip((np.abs(bend) - SOFT) / (SHARP - SOFT), 0.0, 1.0))


def angle_noise(component: Submesh, node: IntArray, n: int) -> FloatArray:
    """The curvature that rounding of coordinates makes at each node: long edges turn less than short ones."""
    V, edges = component.V, component.topology.edges
    turned = NOISE * extent(V) / np.maximum(edge_lengths(V, edges), np.finfo(float).tiny)
    return sum(np.bincount(node[end], turned, minlength=n) for end in edges.T)
