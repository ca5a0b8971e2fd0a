"""Loops that open the handles of a closed surface."""

import numpy as np

from ..._core import spanning_forest
from ..._types import IntArray
from . import constants
from .closed_surface import ClosedSurface
from .graph import SurfaceGraph, without_stubs

Loops = tuple[IntArray, IntArray]  # a cut graph, and the edges in the middle of its loops


def open_handles(closed: ClosedSurface, rounds: int = constants.BASE_POINT_ROUNDS) -> IntArray:
    """The shortest cut graph made of loops through one point, over several base points."""
    graph, tried = closed.graph, set[int]()
    bases = [int(np.argmax(np.abs(closed.curvature)))]
    while len(bases) < constants.FIRST_BASE_POINTS:
        bases.append(int(np.argmax(graph.shortest_paths(np.array(bases))[0])))
    best = shortest_loops(graph, bases)
    for _ in range(rounds - 1):
        tried.update(bases)
        # a loop is short as seen from a point on it
        bases = sorted(set(graph.ends[best[1]].ravel().tolist()) - tried)
        bases = bases[:: -(-len(bases) // constants.MAX_BASE_POINTS) or 1]
        best = shortest_loops(graph, bases, best)
    return best[0]


def shortest_loops(graph: SurfaceGraph, bases: list[int], best: Loops | None = None) -> Loops:
    """The shortest of the cut graphs of loops through each base point, and of one that is known."""
    for base in bases:
        loops = _loops_through(graph, base)
        if best is None or graph.length_of(loops[0]) < graph.length_of(best[0]) * constants.STRICTLY_SHORTER:
            best = loops
    assert best is not None
    return best


def _loops_through(graph: SurfaceGraph, base: int) -> Loops:
    """The cut graph of the shortest loops through `base`, and the edges in their middle."""
    distance, before, _ = graph.shortest_paths(np.array([base]))
    shortest = graph.neighbours[1]
    a, b = graph.ends[shortest].T
    in_tree = np.zeros(len(graph.ends), dtype=bool)
    in_tree[shortest] = (before[a] == b) | (before[b] == a)
    loop = distance[graph.ends[:, 0]] + distance[graph.ends[:, 1]] + graph.length
    outside = np.flatnonzero(~in_tree)
    in_cotree = np.zeros(len(graph.ends), dtype=bool)
    longest_first = outside[np.argsort(-loop[outside], kind="stable")]
    in_cotree[spanning_forest(graph.faces, longest_first, graph.n_faces)] = True
    across = np.flatnonzero(~in_tree & ~in_cotree)
    seam = graph.union(across, graph.path_edges(before, graph.ends[across].ravel()))
    return without_stubs(graph, seam, seam[:0]), across  # what all loops share on their way to the base
