"""Templates: a medial wall and cuts on the registered sphere, found in what a flat map leaves out."""

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
from ..surface import connected_labels, triangle_numbers
from .constants import RIM_PRICE, SHORTEST_CUT, WALL_DEPTH
from .subjects import HOW_TO_GET, HemisphereName, directions


@dataclass(frozen=True, eq=False)
class Template:
    """What is left out of a flat cortex.

    Attributes
    ----------
    sphere : (#V, 3) float64
        Unit vectors: the template's vertices on the sphere to which subjects are registered.
    F : (#F, 3) int64
    wall : (#V,) bool
        The vertices within the medial wall: none of their faces is kept.
    cuts : tuple of (#, 3) float64
        Points along each cut, from its tip to where it ends: at the wall, or at a cut before it.
    """

    sphere: FloatArray
    F: IntArray
    wall: BoolArray
    cuts: tuple[FloatArray, ...]


@cache
def fsaverage_template(name: HemisphereName) -> Template:
    """The medial wall and five cuts of fsaverage5's flat map, which comes with nilearn."""
    side = {"lh": "left", "rh": "right"}[name]
    (points, F), (_, flat) = (_shipped(f"{kind}_{side}.gii.gz") for kind in ("sphere", "flat"))
    sphere = directions(np.asarray(points, dtype=np.float64), "fsaverage5")
    return template_of(sphere, F.astype(np.int64), flat)


def _shipped(name: str) -> list[NDArray[Any]]:
    """The arrays of a surface of fsaverage5 in nilearn's wheel, whose import would take seconds."""
    nibabel = import_optional("nibabel", HOW_TO_GET)
    nilearn = find_spec("nilearn")
    if nilearn is None or nilearn.origin is None:
        raise ImportError(f"No module named 'nilearn', in which the template is: {HOW_TO_GET}")
    data = gzip.decompress((Path(nilearn.origin).parent / "datasets/data/fsaverage5" / name).read_bytes())
    return [array.data for array in nibabel.GiftiImage.from_bytes(data).darrays]


def template_of_patch(patch: Path, sphere: Path) -> Template:
    """The medial wall and the cuts of a patch of a subject whose sphere is registered."""
    on_sphere = read_file(sphere)
    kept = read_file(patch, surface=sphere)
    return template_of(directions(on_sphere.V, str(sphere)), on_sphere.triangles, kept.triangles, str(patch))


def template_of(sphere: FloatArray, F: IntArray, kept: IntArray, name: str = "the template") -> Template:
    """Tell the medial wall and the cuts apart in what is not among the faces that are kept.

    The wall is what is deep. The cuts are the branches of the rest: one after the other, the shortest path
    from what is farthest from the wall and from the cuts before, along the middle.
    """
    number, _ = triangle_numbers(np.concatenate((F, kept.astype(np.int64))))
    is_kept = np.isin(number[: len(F)], number[len(F) :])
    left_out = F[~is_kept]
    if not len(left_out) or not is_kept.any():
        raise MeshError(
            f"{name} leaves out {'nothing' if is_kept.any() else 'all'}: give one with a medial wall"
        )
    n = len(sphere)
    edges, faces = np.unique(
        np.sort(left_out[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    length = np.linalg.norm(sphere[edges[:, 0]] - sphere[edges[:, 1]], axis=1)
    inside, rim = np.zeros((2, n), dtype=bool)
    inside[left_out], rim[F[is_kept]] = True, True
    depth = distances_along(edges, length, np.flatnonzero(inside & rim), n)[0]
    deep = inside & (depth > WALL_DEPTH)
    if not deep.any():
        raise MeshError(f"{name} leaves out no medial wall, only cuts: give a template that does")
    deep = _largest_part(edges, deep)
    margin = WALL_DEPTH + 1.5 * float(length.mean())
    wall = inside & (distances_along(edges, length, np.flatnonzero(deep), n)[0] <= margin)
    cuts = _branches(edges, length * np.where(faces == 2, 1.0, RIM_PRICE), wall, inside)
    return Template(sphere, F, wall & ~rim, tuple(sphere[path] for path in cuts))


def _branches(edges: IntArray, price: FloatArray, wall: BoolArray, inside: BoolArray) -> list[IntArray]:
    """Paths from tips to the wall, or to paths before them, the longest first."""
    ends, paths = wall.copy(), list[IntArray]()
    while True:
        distance, before = distances_along(edges, price, np.flatnonzero(ends), len(wall))
        far = np.where(inside & np.isfinite(distance), distance, 0.0)
        tip = int(np.argmax(far))
        if far[tip] < SHORTEST_CUT:
            return paths
        paths.append(path_to_source(before, tip))
        ends[paths[-1]] = True


def path_to_source(before: IntArray, vertex: int) -> IntArray:
    """The way from a vertex to the source that is nearest to it."""
    path = [vertex]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path, dtype=np.int64)


def distances_along(
    edges: IntArray, length: FloatArray, sources: IntArray, n: int
) -> tuple[FloatArray, IntArray]:
    """The distance of each vertex from the nearest source along edges, and the vertex before it."""
    graph = sparse.csr_array((length, edges.T), shape=(n, n))
    distance, before, _ = csgraph.dijkstra(
        graph, directed=False, indices=sources, min_only=True, return_predecessors=True
    )
    return np.asarray(distance), np.asarray(before, dtype=np.int64)


def _largest_part(edges: IntArray, of: BoolArray) -> BoolArray:
    """The largest part of some vertices that edges between them hold together."""
    label = connected_labels(edges[of[edges].all(axis=1)], len(of))
    return np.asarray(of & (label == np.bincount(label[of]).argmax()))
