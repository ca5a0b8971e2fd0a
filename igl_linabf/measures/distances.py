"""What a flat map makes of distances on the surface: FreeSurfer's distance error, by igl's geodesics."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from .._types import FloatArray, IntArray
from ..errors import MeshError, is_number, some
from ..surface import Submesh
from .constants import MAX_SOURCES, RINGS, SOURCES_A_CALL

NO_INDICES: IntArray = np.zeros(0, dtype=np.int64)


def distance_error(V: ArrayLike, F: ArrayLike, uv: ArrayLike, rings: int = RINGS) -> float:
    """The mean error of distances in a flat map, over the mean distance on the surface.

    The map is measured as it is, in the units of `V`: mean `|d_uv - d|` over mean `d`, for vertices and
    their neighbours in some rings around them. FreeSurfer and autoflatten judge flat cortices by it.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Triangles of an oriented manifold.
    uv : (#V, 2) float
        The map; NaN is allowed at vertices that no face uses.
    rings : int
        The neighbours of a vertex are those that so many edges lead to, or fewer; at least 1.

    Returns
    -------
    float
        0 for an isometry; 0.14 is 14 %.

    Raises
    ------
    MeshError
        The arrays do not fit together, are not finite, or the surface is no oriented manifold whose faces
        have areas.
    ValueError
        `rings` is no number of rings.

    Notes
    -----
    A distance on the surface is that of the shortest path through triangles (`igl.exact_geodesic`) within
    the rings. On meshes of more than 1,000 vertices, the distances from 1,000 of them are measured, in a
    few seconds. igl's heat method would be no help: its distances are worst near their source.

    Examples
    --------
    >>> V, F = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    >>> larger = [[0, 0], [1.1, 0], [1.1, 1.1], [0, 1.1]]
    >>> round(distance_error(V, F, larger), 6)
    0.1
    """
    check_rings(rings)
    surface = Submesh.checked_manifold(V, F)
    return Distances.within(surface, rings).error(surface.checked_map(uv))


def check_rings(rings: object) -> None:
    """Raise where `rings` is no number of rings."""
    if not is_number(rings, 1, whole=True):
        raise ValueError(f"rings is {rings!r}: use an integer from 1 on")


@dataclass(frozen=True, eq=False)
class Distances:
    """Geodesic distances on a surface.

    Attributes
    ----------
    ends : (2, #P) int64
        The two vertices of each.
    length : (#P,) float64
    """

    ends: IntArray
    length: FloatArray

    @classmethod
    def within(cls, surface: Submesh, rings: int = RINGS, most: int | None = None) -> Distances:
        """From vertices of a manifold to their neighbours within some rings; from `most`, if there are more.

        That is `MAX_SOURCES` where nothing else is said.
        """
        n = len(surface.V)
        sources = np.arange(n)
        number = MAX_SOURCES if most is None else most
        if n > number:
            # at random: every n-th vertex may lie on a line of a grid
            sources = np.sort(np.random.default_rng(0).choice(n, number, replace=False))
        near = _reached(surface, sources, rings)
        corners = sparse.csr_array(
            (np.ones(3 * len(surface.F), dtype=np.int32), (surface.F.ravel(), _thrice(len(surface.F)))),
            shape=(n, len(surface.F)),
        )
        ends, length = [], []
        for first in range(0, len(sources), SOURCES_A_CALL):
            own = slice(first, first + SOURCES_A_CALL)
            i, j, distance = _from_some(surface, sources[own], near[own], corners)
            ends.append(np.stack((sources[own][i], j)))
            length.append(distance)
        made = cls(np.concatenate(ends, axis=1), np.concatenate(length))
        lost = made.ends[0, ~np.isfinite(made.length)]
        if len(lost):
            raise MeshError(
                f"igl finds no distances around vertices {some(np.unique(lost))}: look for slivers there, or "
                "let igl_linabf.clean remove them"
            )
        return made

    def in_map(self, map_: FloatArray) -> FloatArray:
        """The distances of the same vertices in a flat map."""
        start, end = map_[self.ends]
        return np.asarray(np.hypot(*(end - start).T))

    def error(self, map_: FloatArray) -> float:
        """The mean error of a map's distances over the mean distance."""
        return float(np.abs(self.in_map(map_) - self.length).sum() / self.length.sum())

    def best_scale(self, map_: FloatArray) -> float:
        """The factor of a map by which its distances have the least mean error: a weighted median."""
        flat = self.in_map(map_)
        apart = flat > 0
        ratio, weight = self.length[apart] / flat[apart], flat[apart]
        order = np.argsort(ratio)
        below = np.cumsum(weight[order])
        return float(ratio[order][np.searchsorted(below, below[-1] / 2)])


def _thrice(n: int) -> IntArray:
    return np.repeat(np.arange(n), 3)


def _reached(surface: Submesh, sources: IntArray, rings: int) -> sparse.csr_array:
    """For each source a row of the vertices that `rings` edges lead to, itself among them."""
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


def _from_some(
    surface: Submesh, sources: IntArray, near: sparse.csr_array, corners: sparse.csr_array
) -> tuple[IntArray, IntArray, FloatArray]:
    """Distances from some sources to the vertices near each: places among the sources, vertices, lengths.

    Each source has a copy of the triangles around it, so that one call of igl, which measures from the
    nearest of all sources, measures from each.
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
