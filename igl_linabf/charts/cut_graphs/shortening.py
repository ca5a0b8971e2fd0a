"""Shorten seams: straighten each arc, and move each branch point."""

from itertools import pairwise

import numpy as np

from ..._core import goal_directed_search, lengths, steiner_paths
from ..._types import BoolArray, IntArray
from .branches import (
    ArcArrays,
    find_arcs,
    follow_arc,
    list_seam_steps,
    move_in_groups,
    replace_steps,
    select_longest,
    sum_arc_lengths_at_nodes,
)
from .closed_surface import ClosedSurface
from .constants import MAX_MOVED_ARCS, STRICTLY_SHORTER

MIN_KEPT_PART = 0.7  # every part keeps at least this share of its faces when seams are pulled tight


class _Corridor:
    """The nodes that a moved seam may pass, and the edges between them.

    `index` maps each node of the surface to its position in the corridor; -1 outside.
    """

    def __init__(self, closed: ClosedSurface, near: BoolArray, seam: IntArray) -> None:
        self.graph = graph = closed.graph
        _, cycles, sizes = self._pieces = graph.find_topology_and_sizes(seam)
        self.is_tree = not cycles  # if so, moving an arc always preserves the topology
        self.has_parts = len(sizes) > 1  # whether the seam divides the surface
        self._nodes = np.flatnonzero(near)
        self.index = np.full(graph.n, -1)
        self.index[self._nodes] = np.arange(len(self._nodes))
        adjacency, edge = graph.adjacency
        matrix = adjacency.copy()
        matrix.data = edge
        self._matrix = matrix[self._nodes][:, self._nodes]
        self.length = graph.length
        self._matrix.data = self.length[self._matrix.data]
        self._position = graph.position[self._nodes]
        in_space = near & (np.arange(graph.n) >= graph.n_holes)  # holes have no position
        inside = np.flatnonzero(in_space[graph.ends[:, 0]] & in_space[graph.ends[:, 1]])
        straight = lengths(graph.position, graph.ends[inside])
        self._share = float(np.min(self.length[inside] / straight, initial=1.0, where=straight > 0))

    def has_same_topology(self, moved: IntArray) -> bool:
        """Return True if `moved` has the topology of the original seam, and no part has become small."""
        number, cycles, sizes = self._pieces
        *new, parts = self.graph.find_topology_and_sizes(moved)
        same = new == [number, cycles] and len(parts) == len(sizes)
        return same and bool((parts >= MIN_KEPT_PART * sizes).all())

    def are_in_same_sector(self, node: int, old: int, new: int, on: BoolArray) -> bool:
        """Return True if no edge in `on` separates the edges `old` and `new` in the one-ring of a node.

        `on` is a mask of the other seam edges. If they do not separate `old` from `new`, cutting along the
        seam puts the node on the same boundary loop, no matter which of the two edges an arc starts with. An
        arc that stays in its sector at both ends, and does not cross other arcs, preserves the topology.
        """
        if self.is_tree or old == new:
            return True
        faces, (matrix, edge) = self.graph.faces, self.graph.adjacency
        around = np.append(edge[matrix.indptr[node] : matrix.indptr[node + 1]], (old, new))
        reached, waiting = set[int](faces[old].tolist()), True
        sides = faces[around[~on[around]]].tolist()
        while waiting:
            waiting = False
            for a, b in sides:
                if (a in reached) != (b in reached):
                    reached |= {a, b}
                    waiting = True
        return int(faces[new, 0]) in reached

    def measure_length(self, edges: IntArray) -> float:
        """Return the total length of edges."""
        return float(self.length[edges].sum())

    def mask_blocked_nodes(self, nodes: IntArray) -> BoolArray:
        """Return a mask over the nodes of the corridor that marks `nodes`, which paths may not pass."""
        blocked = np.zeros(len(self._nodes), dtype=bool)
        blocked[self.index[nodes]] = True
        return blocked

    def find_shortest_path(self, source: int, target: int, blocked: BoolArray, limit: float) -> IntArray:
        """Return the nodes of the shortest path from the target back to the source.

        Source and target are indices into the corridor. If the path is longer than `limit`, only the target
        is returned.
        """
        is_open, matrix = ~blocked, self._matrix
        is_open[source] = True
        aim = self._position[[target] if self._nodes[target] >= self.graph.n_holes else []]
        rest = self._position, aim, self._share, limit * (1 + 1e-9)
        _, before = goal_directed_search(matrix.indptr, matrix.indices, matrix.data, source, is_open, *rest)
        nodes, at = [target], int(before[target])
        while at >= 0:
            nodes.append(at)
            at = int(before[at])
        return np.asarray(self._nodes[nodes])

    def find_steiner_tree(self, tips: IntArray, blocked: BoolArray, limit: float) -> list[IntArray]:
        """Return the three paths of least total length from a common node to three nodes.

        The three nodes are indices into the corridor. The paths are empty if the total exceeds `limit`.
        """
        matrix, terminals = self._matrix, (tips[:1], tips[1:2], tips[2:])
        nodes, start = steiner_paths(matrix.indptr, matrix.indices, matrix.data, terminals, ~blocked, limit)
        return [self._nodes[nodes[i:j]] for i, j in pairwise(start.tolist())]


def pull_tight(
    closed: ClosedSurface, seam: IntArray, kept: IntArray, near: BoolArray, reach: float
) -> IntArray:
    """Shorten a seam without changing its topology or the points that it has to pass.

    Parameters
    ----------
    closed : ClosedSurface
    seam : (#S,) int64
        The edges of the seam.
    kept : (#K,) int64
        Nodes that the seam must still pass.
    near : (n,) bool
        Mask of the nodes that the shortened seam may pass. It includes the nodes of `seam`.
    reach : float
        Distance from a branch point up to which its three arcs may move.

    Returns
    -------
    seam : (#S,) int64
        The shortened seam, which is never longer than the given one.
    """
    corridor, fixed = _Corridor(closed, near, seam), set(kept.tolist())
    straight = _straighten_arcs(corridor, seam, fixed, seam[:0])
    moved = _move_branch_points(corridor, straight, fixed, reach)
    moved = _straighten_arcs(corridor, moved, fixed, straight)
    return moved if corridor.is_tree or corridor.has_parts or corridor.has_same_topology(moved) else seam


def _straighten_arcs(corridor: _Corridor, seam: IntArray, fixed: set[int], known: IntArray) -> IntArray:
    """Replace each arc with the shortest path that the corridor and the other arcs allow.

    Arcs whose edges are all in `known` are skipped, because they have been straightened before.
    """
    graph = corridor.graph

    def move_arcs(arcs: list[ArcArrays], seam: IntArray) -> IntArray | None:
        blocked, on, old = corridor.mask_blocked_nodes(graph.ends[seam]), graph.mask_edges(seam), seam
        for edges, nodes in arcs:
            length, places = corridor.measure_length(edges), corridor.index[nodes]
            blocked[places[1:]] = False
            path = corridor.find_shortest_path(int(places[0]), int(places[-1]), blocked, length)
            if len(path) > 1:
                new = graph.find_edges_between(path[:-1], path[1:])
                one = len(new) == 1 and new[0] in seam  # the new arc is an existing seam edge
                on[edges] = False
                if (
                    not one
                    and corridor.measure_length(new) < length * STRICTLY_SHORTER
                    and corridor.are_in_same_sector(nodes[0], edges[0], new[-1], on)
                    and corridor.are_in_same_sector(nodes[-1], edges[-1], new[0], on)
                ):
                    seam = np.concatenate((graph.subtract_seam(seam, edges), new))
                    places, edges = corridor.index[path], new
                on[edges] = True
            blocked[places] = True
        return seam if seam is old or not corridor.has_parts or corridor.has_same_topology(seam) else None

    new = ~graph.mask_edges(known)
    arcs = find_arcs(graph, seam, fixed)
    arcs = [arc for arc in arcs if arc[1][0] != arc[1][-1] and len(arc[0]) > 1 and new[arc[0]].any()]
    return move_in_groups(
        select_longest(arcs, lambda k: corridor.measure_length(arcs[k][0])), seam, move_arcs
    )


def _move_branch_points(corridor: _Corridor, seam: IntArray, fixed: set[int], reach: float) -> IntArray:
    """Move each point where three arcs meet to the position that minimises their total length."""
    graph = corridor.graph

    def move_branches(branches: list[int], seam: IntArray) -> IntArray | None:
        on, old, changes = graph.mask_edges(seam), seam, list[tuple[IntArray, IntArray]]()
        for branch in branches:
            if len(steps.get(branch, ())) != 3:
                continue
            arms = [follow_arc(graph, steps, fixed, branch, step, reach) for step in steps[branch]]
            tips = [nodes[-1] for _, nodes in arms]
            if len({*tips, branch}) < 4:
                continue
            own = np.array([edge for edges, _ in arms for edge in edges])
            blocked = corridor.mask_blocked_nodes(np.fromiter(steps, dtype=np.int64, count=len(steps)))
            for _, nodes in arms:
                blocked[corridor.index[nodes[:-1]]] = False
            limit = corridor.measure_length(own) * STRICTLY_SHORTER
            paths = corridor.find_steiner_tree(corridor.index[tips], blocked, limit)
            if len(paths[0]):
                parts = [graph.find_edges_between(path[:-1], path[1:]) for path in paths]
                on[own] = False
                firsts = [part[0] for part in parts if len(part)]
                if all(
                    corridor.are_in_same_sector(tip, edges[-1], new, on)
                    for tip, (edges, _), part in zip(tips, arms, parts, strict=True)
                    for new in (part[-1:] if len(part) else firsts)  # no edges if the branch point is a tip
                ):
                    own, old_own = np.concatenate(parts), own
                    seam = np.concatenate((graph.subtract_seam(seam, old_own), own))
                    replace_steps(graph, steps, old_own, own)
                    changes.append((old_own, own))
                on[own] = True
        if seam is old or not corridor.has_parts or corridor.has_same_topology(seam):
            return seam
        for old_own, own in reversed(changes):
            replace_steps(graph, steps, own, old_own)
        return None

    steps = list_seam_steps(graph, seam)
    movable = [
        node for node in steps if node >= graph.n_holes and node not in fixed and len(steps[node]) == 3
    ]
    if len(movable) > MAX_MOVED_ARCS:
        at = sum_arc_lengths_at_nodes(graph, find_arcs(graph, seam, fixed), corridor.length, reach)
        movable = select_longest(movable, lambda k: float(at[movable[k]]))
    return move_in_groups(movable, seam, move_branches)
