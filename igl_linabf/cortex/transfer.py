"""Transfer a template's medial wall and cuts to a subject by the registered spheres."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from scipy.spatial import cKDTree

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError
from .templates import Template, compute_shortest_paths, trace_path_to_source

MIN_WALL_WEIGHT = 1e-6  # barycentric weight of wall vertices above which a point is inside the medial wall
POINTS_PER_EDGE = 2  # points sampled along a template's cut per mean edge length of the subject
MAX_CUT_DEVIATION = 0.2  # maximum distance of a cut from the template's cut, radians


@dataclass(frozen=True, eq=False)
class Cuts:
    """The medial wall and the cuts of a hemisphere. Their vertices are left out of the flat map.

    Attributes
    ----------
    wall : (#V,) bool
        The vertices of the medial wall.
    paths : tuple of int64 arrays
        The vertices of each cut, which is a path of edges.
    """

    wall: BoolArray
    paths: tuple[IntArray, ...]

    @property
    def is_kept(self) -> BoolArray:
        """Mask of the vertices that are neither in the wall nor on a cut, (#V,)."""
        is_kept = ~self.wall
        for path in self.paths:
            is_kept[path] = False
        return is_kept


def transfer_wall(template: Template, sphere: FloatArray) -> BoolArray:
    """Return True for the subject's vertices strictly inside the template's medial wall on the sphere."""
    _, face, nearest = igl.point_mesh_squared_distance(sphere, template.sphere, template.F)
    corners = template.F[face]
    weights = igl.barycentric_coordinates(nearest, *(template.sphere[corners[:, k]] for k in range(3)))
    return np.asarray((weights * template.wall[corners]).sum(axis=1) > MIN_WALL_WEIGHT)


def transfer_cuts(template: Template, sphere: FloatArray, F: IntArray, wall: BoolArray) -> Cuts:
    """Return the template's cuts as edge paths of a subject, from their tips to the wall or an earlier cut.

    Each cut is a shortest path with edge costs that grow with the distance from the template's cut. The path
    is therefore connected and stays close to the template's cut.
    """
    edges = igl.edges(F)
    length = np.linalg.norm(sphere[edges[:, 0]] - sphere[edges[:, 1]], axis=1)
    side = float(length.mean())
    nearest = cKDTree(sphere)
    ends, paths = wall.copy(), list[IntArray]()
    for line in template.cuts:
        points = _resample_line(line, side / POINTS_PER_EDGE)
        vertex_deviation = cKDTree(points).query(sphere, distance_upper_bound=MAX_CUT_DEVIATION)[0]
        deviation = vertex_deviation[edges].max(axis=1)
        is_near = np.isfinite(deviation)
        price = length[is_near] * (1 + (deviation[is_near] / side) ** 2)
        _, before = compute_shortest_paths(edges[is_near], price, np.flatnonzero(ends), len(sphere))
        tip = int(nearest.query(line[0])[1])
        paths.append(trace_path_to_source(before, tip))
        if not ends[paths[-1][-1]]:
            raise MeshError(
                f"the cut from vertex {tip} ends more than {100 * MAX_CUT_DEVIATION:g} mm from the medial "
                "wall: use medial_wall='template', or another template"
            )
        ends[paths[-1]] = True
    return Cuts(wall, tuple(paths))


def _resample_line(line: FloatArray, spacing: float) -> FloatArray:
    """Resample a line on the unit sphere, so that consecutive points are at most `spacing` apart."""
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.concatenate(([0.0], np.cumsum(step)))
    positions = np.linspace(0.0, along[-1], int(np.ceil(along[-1] / spacing)) + 1)
    points = np.column_stack([np.interp(positions, along, x) for x in line.T])
    return np.asarray(points / np.linalg.norm(points, axis=1, keepdims=True))
