"""Derive a template, a medial wall and cuts on the registered sphere, from a flat map."""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError
from ..io import import_optional, read_file
from ..surface import connected_labels, number_triangles
from .subjects import INSTALL_HINT, HemisphereName, scale_to_unit_sphere

MIN_WALL_DEPTH = 0.09  # minimum depth of the medial wall, radians; the wall is 0.5 deep, cuts only 0.04
MIN_CUT_LENGTH = 0.12  # minimum length of a cut, radians; bumps of the wall's outline are up to 0.08 long
RIM_COST_FACTOR = 2.0  # cost of an edge on the rim of a cut, relative to an inner edge of equal length


@dataclass(frozen=True, eq=False)
class Template:
    """The medial wall and the cuts of a flat cortex, on the registered sphere.

    Attributes
    ----------
    sphere : (#V, 3) float64
        Unit vectors: the template's vertices on the sphere that subjects are registered to.
    F : (#F, 3) int64
    wall : (#V,) bool
        The inner vertices of the medial wall. None of their faces is in the flat map.
    cuts : tuple of (#, 3) float64
        Points along each cut, from its tip to its end at the wall or at an earlier cut.
    """

    sphere: FloatArray
    F: IntArray
    wall: BoolArray
    cuts: tuple[FloatArray, ...]


@cache
def load_fsaverage_template(name: HemisphereName) -> Template:
    """Return the medial wall and the five cuts of the flat map of fsaverage5 in the nilearn package."""
    side = {"lh": "left", "rh": "right"}[name]
    (points, F), (_, flat) = (_read_fsaverage_arrays(f"{kind}_{side}.gii.gz") for kind in ("sphere", "flat"))
    sphere = scale_to_unit_sphere(np.asarray(points, dtype=np.float64), "fsaverage5")
    return build_template(sphere, F.astype(np.int64), flat)


def _read_fsaverage_arrays(name: str) -> list[NDArray[Any]]:
    """Read a surface of fsaverage5 from nilearn's files; importing nilearn itself would take seconds."""
    nibabel = import_optional("nibabel", INSTALL_HINT)
    nilearn = find_spec("nilearn")
    if nilearn is None or nilearn.origin is None:
        raise ImportError(f"No module named 'nilearn', which contains the template: {INSTALL_HINT}")
    data = gzip.decompress((Path(nilearn.origin).parent / "datasets/data/fsaverage5" / name).read_bytes())
    return [array.data for array in nibabel.GiftiImage.from_bytes(data).darrays]


def read_template(patch: Path, sphere: Path) -> Template:
    """Return the medial wall and the cuts of a patch file, given the registered sphere of its subject."""
    on_sphere = read_file(sphere)
    kept = read_file(patch, surface=sphere)
    return build_template(
        scale_to_unit_sphere(on_sphere.V, str(sphere)), on_sphere.triangles, kept.triangles, str(patch)
    )


def build_template(sphere: FloatArray, F: IntArray, kept: IntArray, name: str = "the template") -> Template:
    """Separate the medial wall from the cuts among the faces that are not `kept`.

    The wall consists of the vertices that are deep in the region of these faces. The cuts are the branches
    of the remaining region: each cut is the shortest path, along the middle of its branch, from the vertex
    that is farthest from the wall and from the previous cuts.
    """
    number, _ = number_triangles(np.concatenate((F, kept.astype(np.int64))))
    is_kept = np.isin(number[: len(F)], number[len(F) :])
    left_out = F[~is_kept]
    if not len(left_out) or not is_kept.any():
        raise MeshError(
            f"{name} leaves out {'nothing' if is_kept.any() else 'all faces'}: "
            "give a template with a medial wall"
        )
    n = len(sphere)
    edges, faces = np.unique(
        np.sort(left_out[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    length = np.linalg.norm(sphere[edges[:, 0]] - sphere[edges[:, 1]], axis=1)
    inside, rim = np.zeros((2, n), dtype=bool)
    inside[left_out], rim[F[is_kept]] = True, True
    depth = compute_shortest_paths(edges, length, np.flatnonzero(inside & rim), n)[0]
    deep = inside & (depth > MIN_WALL_DEPTH)
    if not deep.any():
        raise MeshError(f"{name} leaves out only cuts, no medial wall: give a template with a medial wall")
    deep = _find_largest_component(edges, deep)
    margin = MIN_WALL_DEPTH + 1.5 * float(length.mean())
    wall = inside & (compute_shortest_paths(edges, length, np.flatnonzero(deep), n)[0] <= margin)
    cuts = _trace_cuts(edges, length * np.where(faces == 2, 1.0, RIM_COST_FACTOR), wall, inside)
    return Template(sphere, F, wall & ~rim, tuple(sphere[path] for path in cuts))


def _trace_cuts(edges: IntArray, price: FloatArray, wall: BoolArray, inside: BoolArray) -> list[IntArray]:
    """Return paths of cuts, longest first, from their tips to the medial wall or to an earlier path."""
    ends, paths = wall.copy(), list[IntArray]()
    while True:
        distance, before = compute_shortest_paths(edges, price, np.flatnonzero(ends), len(wall))
        far = np.where(inside & np.isfinite(distance), distance, 0.0)
        tip = int(np.argmax(far))
        if far[tip] < MIN_CUT_LENGTH:
            return paths
        paths.append(trace_path_to_source(before, tip))
        ends[paths[-1]] = True


def trace_path_to_source(before: IntArray, vertex: int) -> IntArray:
    """Return the path from a vertex to its nearest source, given the predecessors."""
    path = [vertex]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path, dtype=np.int64)


def compute_shortest_paths(
    edges: IntArray, length: FloatArray, sources: IntArray, n: int
) -> tuple[FloatArray, IntArray]:
    """Return each vertex's distance to the nearest source along edges, and its predecessor."""
    graph = sparse.csr_array((length, edges.T), shape=(n, n))
    distance, before, _ = csgraph.dijkstra(
        graph, directed=False, indices=sources, min_only=True, return_predecessors=True
    )
    return np.asarray(distance), np.asarray(before, dtype=np.int64)


def _find_largest_component(edges: IntArray, members: BoolArray) -> BoolArray:
    """Return the largest connected component of a set of vertices."""
    label = connected_labels(edges[members[edges].all(axis=1)], len(members))
    return np.asarray(members & (label == np.bincount(label[members]).argmax()))
