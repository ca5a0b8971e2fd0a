"""FreeSurfer's distance error of flat maps, from geodesic distances by igl."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from .._types import FloatArray, IntArray
from ..errors import MeshError, first_few, is_number
from ..surface import Submesh

RINGS = 7  # rings of neighbours within which distances are compared, as in FreeSurfer
MAX_SOURCES = 1000  # maximum number of source vertices; larger meshes are sampled at random
SOURCES_A_CALL = 8  # number of source vertices per call of igl, which is slow for many sources

NO_INDICES: IntArray = np.zeros(0, dtype=np.int64)


def distance_error(V: ArrayLike, F: ArrayLike, uv: ArrayLike, rings: int = RINGS) -> float:
    """Compute the mean error of distances in a flat map, relative to the mean distance on the surface.

    The error is mean `|d_uv - d|` / mean `d` over the pairs of each vertex and its neighbours in `rings`
    rings. The map is not rescaled; it must have the units of `V`. FreeSurfer and autoflatten use this measure
    for flat cortices.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Triangles of an oriented manifold.
    uv : (#V, 2) float
        The map; NaN is allowed at vertices that no face uses.
    rings : int
        Largest number of edges between a vertex and its neighbours; at least 1.

    Returns
    -------
    float
        0 for an isometry; 0.14 is 14 %.

    Raises
    ------
    MeshError
        The arrays do not fit together, are not finite, or the surface is not an oriented manifold whose
        faces have areas.
    ValueError
        `rings` is not a positive integer.

    Notes
    -----
    A distance on the surface is the length of the shortest path through triangles (`igl.exact_geodesic`)
    within the rings. If the mesh has more than 1,000 vertices, distances are measured from a random sample of
    1,000 vertices, in a few seconds. igl's heat method is not suitable, because its distances are least
    accurate near the source.

    Examples
    --------
    >>> V, F = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    >>> larger = [[0, 0], [1.1, 0], [1.1, 1.1], [0, 1.1]]
    >>> round(distance_error(V, F, larger), 6)
    0.1
    """
    check_rings(rings)
    surface = Submesh.manifold_from_input(V, F)
    return Distances.measure_within_rings(surface, rings).compute_mean_error(surface.check_map(uv))


def check_rings(rings: object) -> None:
    """Raise a `ValueError` if `rings` is not a positive integer."""
    if not is_number(rings, 1, whole=True):
        raise ValueError(f"rings is {rings!r}: use an integer from 1 on")


@dataclass(frozen=True, eq=False)
class Distances:
    """Geodesic distances between pairs of vertices of a surface.

    Attributes
    ----------
    ends : (2, #P) int64
        The two vertices of each pair.
    length : (#P,) float64
        The distance of each pair.
    """

    ends: IntArray
    length: FloatArray

    @classmethod
    def measure_within_rings(cls, surface: Submesh, rings: int = RINGS, most: int | None = None) -> Distances:
        """Measure distances from the vertices of a manifold to their neighbours within `rings` rings.

        If the mesh has more than `most` vertices, measure from a random sample of `most` vertices. The
        default is `MAX_SOURCES`.
        """
        n = len(surface.V)
        sources = np.arange(n)
        number = MAX_SOURCES if most is None else most
        if n > number:
            # a random sample, because every n-th vertex could be on a single line of a grid
            sources = np.sort(np.random.default_rng(0).choice(n, number, replace=False))
        near = _find_neighbours(surface, sources, rings)
        face = np.repeat(np.arange(len(surface.F)), 3)
        corners = sparse.csr_array(
            (np.ones(len(face), dtype=np.int32), (surface.F.ravel(), face)), shape=(n, len(surface.F))
        )
        ends, length = [], []
        for first in range(0, len(sources), SOURCES_A_CALL):
            own = slice(first, first + SOURCES_A_CALL)
            i, j, distance = _measure_distances(surface, sources[own], near[own], corners)
            ends.append(np.stack((sources[own][i], j)))
            length.append(distance)
        made = cls(np.concatenate(ends, axis=1), np.concatenate(length))
        lost = made.ends[0, ~np.isfinite(made.length)]
        if len(lost):
            raise MeshError(
                f"igl finds no distances around vertices {first_few(np.unique(lost))}: look for slivers "
                "there, or let igl_linabf.clean remove them"
            )
        return made

    def measure_in_map(self, map_: FloatArray) -> FloatArray:
        """Return the distances between the vertices of each pair in a flat map, (#P,)."""
        start, end = map_[self.ends]
        return np.asarray(np.hypot(*(end - start).T))

    def compute_mean_error(self, map_: FloatArray) -> float:
        """Return the mean error of distances in a map, relative to the mean distance."""
        return float(np.abs(self.measure_in_map(map_) - self.length).sum() / self.length.sum())

    def find_best_scale(self, map_: FloatArray) -> float:
        """Return the scale factor that minimizes the mean error of distances in a map: a weighted median."""
        flat = self.measure_in_map(map_)
        apart = flat > 0
        ratio, weight = self.length[apart] / flat[apart], flat[apart]
        order = np.argsort(ratio)
        below = np.cumsum(weight[order])
        return float(ratio[order][np.searchsorted(below, below[-1] / 2)])


def _find_neighbours(surface: Submesh, sources: IntArray, rings: int) -> sparse.csr_array:
    """Return a matrix whose row i marks source i and all vertices at most `rings` edges away from it."""
    F, n = surface.F, len(surface.V)
    tail, head = np.concatenate((F, F[:, [1, 2, 0]])).ravel(), np.concatenate((F[:, [1, 2, 0]], F)).ravel()
    step = sparse.csr_array((np.ones(len(tail), dtype=bool), (tail, head)), shape=(n, n))
    step = step + sparse.eye_array(n, dtype=bool, format="csr")
    near = sparse.csr_array(
        (np.ones(len(sources), dtype=bool), (np.arange(len(sources)), sources)), shape=(len(sources), n)
    )
    for _ in range(int(rings)):
        near = near @ step
    return near


def _measure_distances(
    surface: Submesh, sources: IntArray, near: sparse.csr_array, corners: sparse.csr_array
) -> tuple[IntArray, IntArray, FloatArray]:
    """Measure distances from each source to the vertices near it, in a single call of igl.

    igl measures the distance to the nearest of all sources. Therefore, each source gets its own copy of the
    triangles around it. Returns indices into `sources`, vertices, and distances.
    """
    n = len(surface.V)
    inside = (near.astype(np.int32) @ corners).tocoo()
    whole = inside.data == 3
    copy, face = inside.coords[0][whole], inside.coords[1][whole]
    vertices, F = np.unique(copy[:, None] * n + surface.F[face], return_inverse=True)
    i, j = near.nonzero()
    others = j != sources[i]
    i, j = i[others].astype(np.int64), j[others].astype(np.int64)
    start = np.searchsorted(vertices, np.arange(len(sources)) * n + sources)
    end = np.searchsorted(vertices, i * n + j)
    length = igl.exact_geodesic(
        surface.V[vertices % n], F.reshape(-1, 3).astype(np.int64), start, NO_INDICES, end, NO_INDICES
    )
    return i, j, np.asarray(length)
