"""Reference for the graph functions of the core, with NumPy and SciPy."""

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

NEXT, PREV = [1, 2, 0], [2, 0, 1]


def group_sides(tail, head, n):
    key = np.minimum(tail, head) * n + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    _, begin, count = np.unique(key[order], return_index=True, return_counts=True)
    return order, begin, count


def find_edges(corner, n):
    tail, head = corner[NEXT].ravel(), corner[PREV].ravel()
    order, begin, count = group_sides(tail, head, n)
    first, second = order[begin], order[np.minimum(begin + 1, len(order) - 1)]
    same_way = tail[first] == tail[second]
    sides = np.stack((first, np.where((count > 1) & ~same_way, second, -1)))
    sound = not (count > 2).any() and not (same_way & (count == 2)).any()
    return np.column_stack((tail[first], head[first])), sides, sound


def used_vertices(F, n):
    sound = ((F >= 0) & (n > F)).all(axis=1) & (F[:, NEXT] != F).all(axis=1)
    used = np.zeros(n, dtype=bool)
    used[F[sound]] = True
    return used, bool(sound.all())


def symmetric_pattern(ends, n):
    low, high = ends.min(axis=0), ends.max(axis=0)
    pairs = np.flatnonzero((low >= 0) & (low != high))
    rows, slot = np.arange(n), np.full(ends.shape[1], -1)
    key = np.concatenate((rows * n + rows, low[pairs] * n + high[pairs]))
    key, place = np.unique(key, return_inverse=True)
    slot[pairs] = place[n:]
    return np.searchsorted(key, n * np.arange(n + 1)), key % n, slot


def boundary_loops(tail, head, n):
    order = np.argsort(tail, kind="stable")
    start = tail[order]
    twice = start[1:][start[1:] == start[:-1]]
    if len(twice):
        return start[:0], start[:0], twice
    loops = cycles(np.searchsorted(start, head[order]))
    sizes = np.array([len(loop) for loop in loops], dtype=np.int64)
    return start[[v for loop in loops for v in loop]], sizes, twice


def cycles(following):
    after, seen, found = following.tolist(), bytearray(len(following)), []
    for i in range(len(after)):
        cycle = []
        while not seen[i]:
            seen[i] = 1
            cycle.append(i)
            i = after[i]
        if cycle:
            found.append(cycle)
    return found


def connected_labels(edges, n):
    graph = sparse.csr_array((np.ones(len(edges), dtype=np.int8), edges.T), shape=(n, n))
    return np.asarray(csgraph.connected_components(graph, directed=False)[1], dtype=np.int64)


def spanning_forest(pairs, order, n):
    chosen, label = [], np.arange(n)
    for e in order.tolist():
        i, j = label[pairs[e]]
        if i != j:
            chosen.append(e)
            label[label == j] = i
    return np.array(chosen, dtype=np.int64)


def is_connected(sides, n_faces):
    return connected_labels(sides[:, sides[1] >= 0].T % n_faces, n_faces).max() == 0


def count_fans(corner, sides, n):
    m = corner.shape[1]
    a, b = sides[:, sides[1] >= 0]
    # half-edge (k, t) leads from corner k + 1 to k + 2; the opposite half-edge has the reverse direction
    ka, ta, kb, tb = a // m, a % m, b // m, b % m
    start, end = (np.column_stack(((ka + i) % 3 * m + ta, (kb + 3 - i) % 3 * m + tb)) for i in (1, 2))
    label = connected_labels(np.concatenate((start, end)), 3 * m)
    vertex = np.empty(int(label.max()) + 1, dtype=np.int64)
    vertex[label] = corner.ravel()
    return np.bincount(vertex, minlength=n)


def shortest_edges(ends, length, n):
    proper = np.flatnonzero(ends[:, 0] != ends[:, 1])
    (i, j), edge = ends[proper].T, np.tile(proper, 2)
    key = np.append(i * n + j, j * n + i)
    order = np.lexsort((edge, length[edge], key))  # choose the first of equally short edges
    key, first = np.unique(key[order], return_index=True)
    return np.searchsorted(key, n * np.arange(n + 1)), key % n, edge[order][first]


def choose_distant_nodes(indptr, indices, order, hops, closed):
    n, start = len(indptr) - 1, indptr[:-1]
    rank = np.zeros(n, dtype=np.int32)
    rank[order] = np.arange(len(order), 0, -1)
    rank[closed] = 0

    def spread(values):
        for _ in range(hops):
            values = np.maximum(values, np.maximum.reduceat(values[indices], start))
            values[closed] = 0
        return values

    chosen, waiting = np.zeros(n, dtype=bool), rank > 0
    while waiting.any():  # in each round, choose all nodes that come first within their reach
        left = np.where(waiting, rank, 0)
        new = waiting & (spread(left) == left)
        chosen |= new
        waiting &= spread(new.astype(np.int32)) == 0
    return chosen


def forest_parents(pairs, n):
    root = np.unique(connected_labels(pairs, n), return_index=True)[1]
    # breadth-first search from an extra node that is connected to each root
    ends = np.concatenate((pairs, np.column_stack((root, np.full(len(root), n)))))
    graph = sparse.csr_array((np.ones(len(ends), dtype=np.int8), ends.T), shape=(n + 1, n + 1))
    before = csgraph.breadth_first_order(graph, n, directed=False)[1][:n].astype(np.int64)
    before[root] = root
    return before


def nearest_sources(indptr, indices, length, sources, open_, limit):
    n = len(indptr) - 1
    rows = np.repeat(np.arange(n), np.diff(indptr))
    passed = np.where(open_[rows] & open_[indices], length, np.inf)
    graph = sparse.csr_array((passed, indices, indptr), shape=(n, n))
    sources = sources[open_[sources]]
    if not len(sources):
        return np.full(n, np.inf), np.full(n, -1), np.full(n, -1)
    distance, before, source = csgraph.dijkstra(
        graph, indices=sources, min_only=True, return_predecessors=True, limit=max(limit, 0.0)
    )
    far = np.isinf(distance)  # SciPy 1.15 returns a predecessor for some nodes that are out of reach
    before, source = (np.where(far, -1, np.maximum(nodes, -1)).astype(np.int64) for nodes in (before, source))
    return distance, before, source


def goal_directed_search(indptr, indices, length, source, open_, position, targets, share, limit):
    return nearest_sources(indptr, indices, length, np.array([source]), open_, limit)[:2]


def path_nodes(before, ends):
    found = {}
    for node in ends.tolist():
        while before[node] >= 0 and node not in found:
            found[node] = None
            node = int(before[node])
    return np.array([*found], dtype=np.int64)


def breadth_first_path(indptr, indices, sources, ends):
    n, source = len(indptr) - 1, np.flatnonzero(sources)
    pattern = np.append(indices, source), np.append(indptr, len(indices) + len(source))
    graph = sparse.csr_array((np.ones(len(pattern[0])), *pattern), shape=(n + 1, n + 1))
    # search from an extra node that is connected to all sources
    reached, before = csgraph.breadth_first_order(graph, n)
    at = np.flatnonzero(np.append(ends, False)[reached])[:1]
    way = reached[at].tolist()
    while way and before[way[-1]] != n:
        way.append(int(before[way[-1]]))
    return np.array(way, dtype=np.int64)


def prune_leaves(ends, kept):
    left = np.ones(len(ends), dtype=bool)
    while True:
        loose = (np.bincount(ends[left].ravel(), minlength=len(kept)) == 1) & ~kept
        drop = left & loose[ends].any(axis=1)
        if not drop.any():
            return left
        left &= ~drop


def shortest_odd_walk(indptr, indices, length, flip, start, copies):
    n = len(indptr) - 1
    rows, copy = np.repeat(np.arange(n), np.diff(indptr)), np.arange(copies)[:, None]
    ends = (copy * n + rows).ravel(), ((copy ^ flip) * n + indices).ravel()
    graph = sparse.csr_array((np.tile(length, copies), ends), shape=(copies * n, copies * n))
    walk = [(copies - 1) * n + start]
    _, before = csgraph.dijkstra(graph, indices=start, return_predecessors=True)
    while before[walk[-1]] >= 0:
        walk.append(int(before[walk[-1]]))
    return np.array(walk, dtype=np.int64)


def steiner_paths(indptr, indices, length, sources, open_, limit):
    searches = []
    for own in sources:
        passed = open_.copy()
        passed[own] = True
        searches.append(nearest_sources(indptr, indices, length, own, passed, limit))
    total = searches[0][0] + searches[1][0] + searches[2][0]
    centre = int(np.argmin(total))
    nodes, start = [], [0]
    for _, before, _ in searches:
        node = centre if total[centre] <= limit else -1
        while node >= 0:
            nodes.append(node)
            node = int(before[node])
        start.append(len(nodes))
    return np.array(nodes, dtype=np.int64), np.array(start)


def split_arcs(ends, joint):
    steps = {}
    for edge, (i, j) in enumerate(ends.tolist()):
        steps.setdefault(i, []).append((edge, j))
        steps.setdefault(j, []).append((edge, i))
    edges, nodes, start, taken = [], [], [0], set()
    for first in [*(node for node in steps if joint[node]), *steps]:
        for edge, node in steps[first]:
            if edge in taken:
                continue
            edges.append(edge)
            nodes += [first, node]
            while not joint[node] and node != first:
                one, other = steps[node]
                edge, node = one if one[0] != edge else other
                edges.append(edge)
                nodes.append(node)
            taken.update(edges[start[-1] :])
            start.append(len(edges))
    return np.array(edges, np.int64), np.array(nodes, np.int64), np.array(start)


def cut_topology(ends, faces, seam, holes, n, n_faces):
    on = np.zeros(n, dtype=bool)
    on[:holes], on[ends[seam]] = True, True
    nodes = int(np.count_nonzero(on))
    number = int(connected_labels(ends[seam], n).max()) + 1 - (n - nodes)
    cycles = number + len(np.unique(seam)) - nodes  # by Euler's formula for the graph of the seam
    if not cycles:
        return number, cycles, np.array([n_faces])
    sides = faces.copy()
    sides[seam] = 0  # a self-loop, so that the edge connects no faces
    return number, cycles, np.sort(np.bincount(connected_labels(sides, n_faces)))


def minimum_cut_side(ends, capacity, n, source, sink):
    values, (tail, head) = np.tile(capacity, 2), np.concatenate((ends, ends[:, ::-1])).T
    graph = sparse.csr_array((values, (tail, head)), shape=(n, n))
    graph.data = np.minimum(graph.data, np.iinfo(np.int32).max)
    graph = graph.astype(np.int32)
    left = sparse.csr_array(graph - csgraph.maximum_flow(graph, source, sink).flow)
    left.data[left.data <= 0] = 0
    left.eliminate_zeros()
    behind = np.ones(n, dtype=bool)
    behind[csgraph.breadth_first_order(left, source, return_predecessors=False)] = False
    return behind
