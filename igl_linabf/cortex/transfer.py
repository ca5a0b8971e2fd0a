"""A template's medial wall and cuts, carried over to a subject by the registered spheres."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from scipy.spatial import cKDTree

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError
from .constants import LARGEST_DETOUR, POINTS_AN_EDGE, RIM_WEIGHT
from .templates import Template, distances_along, path_to_source


@dataclass(frozen=True, eq=False)
class Cuts:
    """What is left out of a hemisphere.

    Attributes
    ----------
    wall : (#V,) bool
        The vertices of the medial wall.
    paths : tuple of int64 arrays
        The vertices of each cut, which edges join.
    """

    wall: BoolArray
    paths: tuple[IntArray, ...]

    @property
    def stays(self) -> BoolArray:
        """The vertices that are in neither, (#V,)."""
        stays = ~self.wall
        for path in self.paths:
            stays[path] = False
        return stays


def carry_wall(template: Template, sphere: FloatArray) -> BoolArray:
    """The subject's vertices whose place on the sphere is in the template's medial wall, not on its rim."""
    _, face, nearest = igl.point_mesh_squared_distance(sphere, template.sphere, template.F)
    corners = template.F[face]
    weights = igl.barycentric_coordinates(nearest, *(template.sphere[corners[:, k]] for k in range(3)))
    return np.asarray((weights * template.wall[corners]).sum(axis=1) > RIM_WEIGHT)


def carry_cuts(template: Template, sphere: FloatArray, F: IntArray, wall: BoolArray) -> Cuts:
    """The template's cuts as paths of edges of a subject, from their tips to the wall or to one another.

    A path is the shortest one where an edge costs the more the farther it is from the template's line, so
    that there is one, it is in one piece, and it runs beside the line.
    """
    edges = igl.edges(F)
    length = np.linalg.norm(sphere[edges[:, 0]] - sphere[edges[:, 1]], axis=1)
    side = float(length.mean())
    nearest = cKDTree(sphere)
    ends, paths = wall.copy(), list[IntArray]()
    for line in template.cuts:
        points = _dense(line, side / POINTS_AN_EDGE)
        away = cKDTree(points).query(sphere, distance_upper_bound=LARGEST_DETOUR)[0][edges].max(axis=1)
        near = np.isfinite(away)
        price = length[near] * (1 + (away[near] / side) ** 2)
        _, before = distances_along(edges[near], price, np.flatnonzero(ends), len(sphere))
        tip = int(nearest.query(line[0])[1])
        paths.append(path_to_source(before, tip))
        if not ends[paths[-1][-1]]:
            raise MeshError(
                f"the cut from vertex {tip} ends more than {100 * LARGEST_DETOUR:g} mm from the medial wall: "
                "use medial_wall='template', or another template"
            )
        ends[paths[-1]] = True
    return Cuts(wall, tuple(paths))


def _dense(line: FloatArray, spacing: float) -> FloatArray:
    """Points along a line on the unit sphere, none farther from the next one than the spacing."""
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.concatenate(([0.0], np.cumsum(step)))
    at = np.linspace(0.0, along[-1], int(np.ceil(along[-1] / spacing)) + 1)
    points = np.column_stack([np.interp(at, along, x) for x in line.T])
    return np.asarray(points / np.linalg.norm(points, axis=1, keepdims=True))
