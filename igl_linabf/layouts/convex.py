"""Compute convex-combination maps, without flips if the boundary is convex (Tutte 1963, Floater 2003)."""

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from .._types import BoolArray, ComplexArray, IntArray
from ..angles import Pattern
from ..linalg import NotPositiveDefiniteError, Solvers
from ..surface import Topology, build_planar_topology, signed_double_areas

DECAYS = (0.5, 1.0, 0.25, 0.0)  # decay rates of the weights, per edge towards the interior, tried in turn
MAX_EXPONENT = 600.0  # maximum x in a weight exp(-x); double precision underflows beyond 700
PATCH_WIDTHS = (1, 2, 4, 8, 16, 32)  # numbers of rings of triangles around flipped triangles, tried in turn


def embed_in_circle(topology: Topology, solvers: Solvers) -> Iterator[ComplexArray]:
    """Embed the surface with its outer loop on a circle and its holes filled, one map for each decay rate.

    No triangle of the maps is flipped in exact arithmetic.
    """
    n = topology.n
    filled = topology
    if len(topology.loops) > 1:
        fans = [  # the mesh is to the left of the loop, the fan to its right
            np.column_stack((np.roll(loop, -1), loop, np.full(len(loop), n + i)))
            for i, loop in enumerate(topology.loops[1:])
        ]
        filled = build_planar_topology(
            np.concatenate((topology.corner.T, *fans)), np.arange(n + len(topology.loops) - 1)
        )
    rim = topology.loops[0]
    z = np.zeros(filled.n, dtype=np.complex128)
    z[rim] = np.exp(2j * np.pi * np.arange(len(rim)) / len(rim))
    free = np.ones(filled.n, dtype=bool)
    free[rim] = False
    for decay in DECAYS:
        made = _embed_by_convex_combinations(filled, z, free, decay, solvers)
        if made is not None:
            yield made[:n]


def embed_patches(topology: Topology, z: ComplexArray, solvers: Solvers) -> Iterator[ComplexArray]:
    """Embed patches of increasing width around the flipped triangles again.

    The boundary of a patch does not change. Because it may not be convex, the caller has to check the result
    for flips.
    """
    bad = ~(signed_double_areas(z, topology.corner) > 0)
    inside = topology.is_interior
    near = np.zeros(topology.n, dtype=bool)
    near[topology.corner[:, bad]] = True
    rings = 0
    for wanted in PATCH_WIDTHS:
        while rings < wanted - 1:
            near[topology.corner[:, near[topology.corner].any(axis=0)]] = True
            rings += 1
        free = near & inside
        if not free.any():
            continue
        for decay in DECAYS:
            made = _embed_by_convex_combinations(topology, z, free, decay, solvers)
            if made is not None:
                yield made
        if (free == inside).all():
            return


def _embed_by_convex_combinations(
    topology: Topology, z: ComplexArray, free: BoolArray, decay: float, solvers: Solvers
) -> ComplexArray | None:
    """Place each free vertex at a convex combination of its neighbours; all other vertices are fixed.

    The weights are w_ij = exp(-decay (d_i + d_j)), where d is the number of edges to the nearest fixed
    vertex. The weights pull vertices outwards, because long protrusions would shrink exponentially with equal
    weights. The wide range of the weights does no harm, because scaling rows does not change the rounding
    errors of the elimination. Return None if the system is singular in double precision.
    """
    a, b = topology.edges.T
    depth = _count_edges(topology, np.flatnonzero(~free))
    rate = min(decay, MAX_EXPONENT / max(2 * float(depth.max()), 1.0))
    weight = np.exp(-rate * (depth[a] + depth[b]))
    row = np.full(topology.n, -1)
    n_free = int(np.count_nonzero(free))
    row[free] = np.arange(n_free)
    pattern = Pattern(topology, row, n_free)
    held = np.where(free, 0, z)
    lower = pattern.build_laplacian(weight)
    try:
        factored = solvers.factor(lower)
    except NotPositiveDefiniteError:
        return None
    x = factored.solve(pattern.sum_fixed_vertex_terms(weight, held))
    return np.where(free, np.append(x @ [1, 1j], 0)[row], z)


def _count_edges(topology: Topology, sources: IntArray) -> np.ndarray:
    """Return the number of edges from each vertex to the nearest of `sources`."""
    a, b = topology.edges.T
    ones = np.ones(len(a))
    graph = sparse.csr_array((ones, (a, b)), shape=(topology.n, topology.n))
    return np.asarray(
        sparse.csgraph.dijkstra(graph, directed=False, indices=sources, unweighted=True, min_only=True)
    )
