"""Find loops that cut the handles of a closed surface."""

import numpy as np

from ..._core import spanning_forest
from ..._types import IntArray
from .closed_surface import ClosedSurface
from .constants import STRICTLY_SHORTER
from .graph import SurfaceGraph, prune_stubs

FIRST_BASE_POINTS = 4  # number of base points in the first round, far from each other
MAX_BASE_POINTS = 6  # number of base points in each further round, chosen in the middle of the best loops
BASE_POINT_ROUNDS = 3  # number of rounds in which base points are tried, including the first

Loops = tuple[IntArray, IntArray]  # the edges of a cut graph, and the middle edge of each of its loops


def open_handles(closed: ClosedSurface, rounds: int = BASE_POINT_ROUNDS) -> IntArray:
    """Return a short cut graph of loops through a base point: the shortest over several base points."""
    graph, tried = closed.graph, set[int]()
    bases = [int(np.argmax(np.abs(closed.curvature)))]
    while len(bases) < FIRST_BASE_POINTS:
        bases.append(int(np.argmax(graph.find_shortest_paths(np.array(bases))[0])))
    best = find_shortest_loops(graph, bases)
    for _ in range(rounds - 1):
        tried.update(bases)
        # use the middle of short loops as base points, because these loops stay short
        bases = sorted(set(graph.ends[best[1]].ravel().tolist()) - tried)
        bases = bases[:: -(-len(bases) // MAX_BASE_POINTS) or 1]
        best = find_shortest_loops(graph, bases, best)
    return best[0]


def find_shortest_loops(graph: SurfaceGraph, bases: list[int], best: Loops | None = None) -> Loops:
    """Return the shortest cut graph: `best`, or one of the cut graphs of loops through each base point."""
    for base in bases:
        loops = _find_loops(graph, base)
        if best is None or graph.measure_length(loops[0]) < graph.measure_length(best[0]) * STRICTLY_SHORTER:
            best = loops
    assert best is not None
    return best


def _find_loops(graph: SurfaceGraph, base: int) -> Loops:
    """Return the cut graph of the shortest loops through `base`, and the edge in the middle of each."""
    distance, before, _ = graph.find_shortest_paths(np.array([base]))
    shortest = graph.adjacent_pairs[1]
    a, b = graph.ends[shortest].T
    in_tree = np.zeros(len(graph.ends), dtype=bool)
    in_tree[shortest] = (before[a] == b) | (before[b] == a)
    loop = distance[graph.ends[:, 0]] + distance[graph.ends[:, 1]] + graph.length
    outside = np.flatnonzero(~in_tree)
    in_cotree = np.zeros(len(graph.ends), dtype=bool)
    longest_first = outside[np.argsort(-loop[outside], kind="stable")]
    in_cotree[spanning_forest(graph.faces, longest_first, graph.n_faces)] = True
    across = np.flatnonzero(~in_tree & ~in_cotree)
    seam = graph.unite_seams(across, graph.find_edges_on_paths(before, graph.ends[across].ravel()))
    return prune_stubs(graph, seam, seam[:0]), across  # all loops may share a path to the base: remove it
