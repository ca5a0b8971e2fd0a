"""Compute the greedy layout: one triangle after another, over a breadth-first tree (section 5)."""

import numpy as np
from scipy import sparse

from .._types import ComplexArray, FloatArray
from ..surface import Topology


def lay_out_greedily(topology: Topology, alpha: FloatArray) -> ComplexArray:
    """Place one triangle after another over a breadth-first tree (section 5); errors accumulate.

    The seed is the triangle with the largest smallest angle. Among paths with the same number of triangles,
    the tree prefers the path across smaller opposite angles. Therefore the result does not depend on the
    numbering.
    """
    m = alpha.shape[1]
    angle = alpha.ravel()
    inside = topology.sides[:, topology.sides[1] >= 0]
    here, there = np.concatenate((inside, inside[::-1]), axis=1)  # half-edges k m + t, and twins
    weight = 1 + 1e-3 / m * (angle[here] + angle[there])
    graph = sparse.csr_array((weight, (here % m, there % m)), shape=(m, m))
    seed = int(np.argmax(alpha.min(axis=0)))
    depth, parent = sparse.csgraph.dijkstra(graph, indices=seed, return_predecessors=True)
    # each triangle in its own frame: corner 0 at 0, corner 1 on the real axis
    sine = np.sin(alpha)
    local = np.stack((np.zeros(m), sine[2], sine[1] * np.exp(1j * alpha[0])))
    # z -> ratio z + shift maps the frame of a triangle to that of its parent; twin half-edges are reversed
    tree = parent[there % m] == here % m
    k, t, c, child = here[tree] // m, here[tree] % m, there[tree] // m, there[tree] % m
    tail, head = local[(k + 1) % 3, t], local[(k + 2) % 3, t]
    child_tail, child_head = local[(c + 2) % 3, child], local[(c + 1) % 3, child]
    ratio, shift = np.ones(m, dtype=np.complex128), np.zeros(m, dtype=np.complex128)
    ratio[child] = (head - tail) / (child_head - child_tail)
    shift[child] = tail - ratio[child] * child_tail
    above = np.where(parent < 0, seed, parent)
    while (above != seed).any():  # pointer doubling: the distance to `above` doubles in each round
        shift = ratio[above] * shift + shift[above]
        ratio = ratio[above] * ratio
        above = above[above]
    placed = (ratio * local + shift).ravel()
    nearest = np.argsort(np.tile(depth, 3), kind="stable")
    first = np.unique(topology.corner.ravel()[nearest], return_index=True)[1]
    return np.asarray(placed[nearest[first]])
