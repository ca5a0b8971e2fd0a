"""The graph functions of the core agree with NumPy and SciPy."""

from itertools import pairwise

import numpy as np
import pytest
from carried import MESHES
from reference import graphs as reference
from scipy import sparse

from igl_linabf import _core
from igl_linabf.surface import planar_mesh

NONE = np.empty(0, dtype=np.int64)
NO_PAIRS = np.empty((0, 2), dtype=np.int64)


def mesh_and_graph():
    """Return a disk with holes, and the CSR graph of its edges with random lengths."""
    mesh = planar_mesh(*MESHES["crown"]())
    t, rng = mesh.topology, np.random.default_rng(1)
    length = rng.uniform(1, 2, len(t.edges))
    graph = sparse.csr_array((np.tile(length, 2), (t.edges.T.ravel(), t.edges[:, ::-1].T.ravel())))
    return mesh, t, length, (graph.indptr, graph.indices, graph.data)


def cases():
    """Return arguments for each function, for a mesh and for graphs with multiple edges."""
    mesh, t, length, ways = mesh_and_graph()
    rng, m = np.random.default_rng(1), t.corner.shape[1]
    few, count = np.minimum(t.edges, 20), rng.integers(5, size=(2, 40))
    tree = t.edges[reference.spanning_forest(t.edges, np.arange(len(t.edges))[::3], t.n)]
    before = reference.nearest_sources(*ways, np.arange(3), np.ones(t.n, dtype=bool), 20.0)[1]
    wide = tuple(x.astype(np.int64) for x in ways[:2])
    order = rng.permutation(t.n)
    half = np.append(np.arange(len(t.edges) // 2), 3)
    faces = t.sides.T % m
    return {
        "find_edges": [(t.corner, t.n)],
        "group_sides": [
            (*t.edges[rng.integers(len(t.edges), size=900)].T, t.n),
            (*count, 5),
            (NONE, NONE, 0),
        ],
        "used_vertices": [(t.corner.T - 3, t.n), (t.corner.T, t.n), (t.corner.T % 9, 7)],
        "symmetric_pattern": [(t.edges.T, t.n), (few.T, 21), (few.T - 1, 20), (count, 5), (NO_PAIRS.T, 3)],
        "boundary_loops": [(*t.edges[t.sides[1] < 0].T, t.n), (np.array([1, 1]), np.array([0, 2]), 3)],
        "cycles": [(order,), (np.arange(3),), (NONE,)],
        "connected_labels": [(t.edges[::3], t.n), (count.T, 7), (NO_PAIRS, 3)],
        "spanning_forest": [(few, rng.permutation(len(few))[::2], t.n), (count.T, np.arange(40), 5)],
        "is_connected": [(t.sides, m), (t.sides[:, ::2], m), (t.sides[:, :0], 1)],
        "count_fans": [(np.where(t.corner == 9, 3, t.corner), t.sides, t.n)],
        "shortest_edges": [
            (t.edges, length, t.n),
            (few + 3, rng.permutation(len(few)) * 1.0, 24),
            (count.T, rng.integers(2, size=40) * 1.0, 5),  # multigraph with equally long edges and self-loops
        ],
        "choose_distant_nodes": [
            (*graph, order, hops, np.arange(t.n) % 9 == 4) for graph in (ways[:2], wide) for hops in (0, 1, 2)
        ],
        "forest_parents": [(tree, t.n), (NO_PAIRS, 3)],
        "nearest_sources": [
            (*graph, ways[2], np.array(sources, dtype=np.int64), np.arange(t.n) % 7 > 0, limit)
            for graph in (ways[:2], wide)
            for sources, limit in (([3, 9, 9], 20.0), ([3, 9, 9], np.inf), ([7], 20.0), ([], 20.0))
        ],
        "goal_directed_search": [
            (*ways, 3, np.arange(t.n) % 7 > 0, mesh.V, mesh.V[:0], 0.0, limit) for limit in (20.0, np.inf)
        ],
        "steiner_paths": [
            (*ways, (np.array([3, 9, 9]), t.edges[40], np.array([t.n - 9])), np.arange(t.n) % 7 > 0, limit)
            for limit in (30.0, 1.0)
        ],
        "path_nodes": [(before, t.edges[9]), (before, np.arange(t.n)), (before, NONE)],
        "breadth_first_path": [
            (*wide, np.arange(t.n) % 50 == 3, np.arange(t.n) == t.n - 9),
            (*wide, np.arange(t.n) == 3, np.zeros(t.n, dtype=bool)),
        ],
        "prune_leaves": [
            (t.edges[rng.random(len(t.edges)) < 0.4], np.arange(t.n) % 5 == 0),
            (tree, np.zeros(t.n, dtype=bool)),
        ],
        "split_arcs": [
            (some, np.bincount(some.ravel(), minlength=t.n) != 2)
            for some in (
                t.edges[::2],
                t.edges[t.sides[1] < 0],
                NO_PAIRS,
            )  # the second set of edges consists of closed arcs
        ],
        "cut_topology": [
            (t.edges, faces, half, 5, t.n, m),
            (t.edges, faces, half[:20], 0, t.n, m),
            (t.edges, faces, np.arange(len(t.edges)), 0, t.n, m),
            (t.edges, faces, reference.spanning_forest(t.edges, half, t.n)[::2], 3, t.n, m),  # no cycle
            (t.edges, faces, NONE, 3, t.n, m),
            (*make_loop_around_torus(), 0, 36, 72),  # a cycle that does not divide the surface
        ],
        "minimum_cut_side": [
            (t.edges, (1000 * length).astype(np.int64), t.n, 3, t.n - 9),
            (t.edges[:5], np.ones(5, dtype=np.int64), t.n, 3, t.n - 9),
        ],
    }


def make_loop_around_torus():
    """Return the edges of a torus, the faces beside each edge, and the edges of a loop around the torus."""
    i, j = np.divmod(np.arange(36), 6)
    a, b, c, d = 6 * i + j, (i + 1) % 6 * 6 + j, (i + 1) % 6 * 6 + (j + 1) % 6, 6 * i + (j + 1) % 6
    corner = np.concatenate((np.stack((a, b, c)), np.stack((a, c, d))), axis=1)
    edges, sides, _ = _core.find_edges(corner, 36)
    return edges, sides.T % 72, np.flatnonzero((edges < 6).all(axis=1))


CASES = [(name, k) for name, all_of in cases().items() for k in range(len(all_of))]


@pytest.mark.parametrize(("name", "k"), CASES)
def test_the_core_agrees_with_the_reference(name, k):
    args = cases()[name][k]
    made, expected = getattr(_core, name)(*args), getattr(reference, name)(*args)
    if name == "cycles":
        assert made == expected
        return
    made, expected = (x if isinstance(x, tuple) else (x,) for x in (made, expected))
    for a, b in zip(made, expected, strict=True):
        a, b = np.asarray(a), np.asarray(b)
        assert a.dtype == b.dtype and a.shape == b.shape
        np.testing.assert_allclose(a, b, rtol=1e-11)  # only distances are not integers


def test_edges_with_three_sides_or_two_sides_of_the_same_direction_are_not_sound():
    book = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]).T
    turned = np.array([[0, 1, 2], [0, 1, 3]]).T
    for corner, sound in ((book[:, :2], True), (book, False), (turned, False), (book[:, :0], True)):
        edges, sides, found = _core.find_edges(corner, 5)
        every = np.sort(corner[[[1, 2], [2, 0], [0, 1]]].transpose(0, 2, 1).reshape(-1, 2), axis=1)
        assert found == sound and sides.shape == (2, len(edges))
        np.testing.assert_array_equal(np.sort(edges, axis=1), np.unique(every, axis=0))


def test_many_edges_are_the_same_for_any_number_of_threads(monkeypatch):
    n = 300_000
    corner = np.stack((np.arange(n - 2), np.arange(1, n - 1), np.arange(2, n)))
    corner[:, 1::2] = corner[[0, 2, 1], 1::2]  # a strip of triangles with consistent orientation
    found = []
    for cores in ("1", "3"):
        monkeypatch.setenv("OMP_NUM_THREADS", cores)
        found.append(_core.find_edges(corner, n))
    for one, other, expected in zip(*found, reference.find_edges(corner, n), strict=True):
        np.testing.assert_array_equal(one, other)
        assert np.shape(one) == np.shape(expected)
    assert found[0][2] and np.array_equal(found[0][1], reference.find_edges(corner, n)[1])


def steps(walk, n):
    """Return the edges of a walk, as pairs of nodes, in the original graph of n nodes."""
    return [sorted(step) for step in pairwise((walk % n).tolist())]


@pytest.mark.parametrize("ways", [1, 3, 6])
@pytest.mark.parametrize("to_the_rim", [0.1, 1.0, 10.0])
def test_walks_that_cross_many_curves_are_as_short_as_in_copies_of_the_graph(ways, to_the_rim):
    """The rim of a square is joined to a single node, and the walk consists of excursions from that node."""
    rng, k = np.random.default_rng(ways), 24
    square = np.arange(k * k).reshape(k, k)
    rim = np.unique(np.concatenate((square[0], square[-1], square[:, 0], square[:, -1])))
    ends = np.concatenate(
        [
            np.stack(pair, axis=-1).reshape(-1, 2)
            for pair in (
                (square[:, 1:], square[:, :-1]),
                (square[1:], square[:-1]),
                (rim, np.full(len(rim), k * k)),
            )
        ]
    )
    length = np.append(rng.uniform(0.1, 1.1, len(ends) - len(rim)), np.full(len(rim), to_the_rim))
    crossed = rng.random((ways, len(ends))) < rng.choice([0.005, 0.05, 0.2], (ways, 1))
    flip = (1 << np.arange(ways)) @ (crossed & (ends[:, 1] < k * k))
    indptr, indices, edge = _core.shortest_edges(ends, length, k * k + 1)
    graph, n = (indptr, indices, length[edge], flip[edge]), k * k + 1
    made = _core.shortest_odd_walk(*graph, k * k, 1 << ways)
    expected = reference.shortest_odd_walk(*graph, k * k, 1 << ways)
    known = {tuple(sorted(pair)): e for pair, e in zip(ends.tolist(), range(len(ends)), strict=True)}
    own, other = ([known[tuple(step)] for step in steps(walk, n)] for walk in (made, expected))
    assert length[own].sum() == pytest.approx(length[other].sum(), rel=1e-12)
    assert np.bitwise_xor.reduce(flip[own]) == (1 << ways) - 1
    assert made[0] == ((1 << ways) - 1) * n + k * k and made[-1] == k * k
    assert (made[:-1] // n ^ made[1:] // n == flip[own]).all()


def test_there_is_no_walk_if_a_curve_cannot_be_crossed_an_odd_number_of_times():
    """The graph is a triangle with a dangling edge."""
    ends = np.array([[0, 1], [1, 2], [2, 0], [2, 3]])
    indptr, indices, edge = _core.shortest_edges(ends, np.ones(4), 4)
    for flip, found in (([1, 1, 0, 0], 0), ([1, 0, 0, 0], 3), ([3, 3, 0, 1], 0), ([1, 2, 0, 0], 3)):
        copies = 1 << int(np.max(flip)).bit_length()
        graph = indptr, indices, np.ones(len(edge)), np.array(flip)[edge]
        walk = _core.shortest_odd_walk(*graph, 0, copies)
        assert len(walk) == len(reference.shortest_odd_walk(*graph, 0, copies)) == found + 1
        assert walk[0] == 4 * (copies - 1) and (walk[-1] == 0) == (found > 0)


def test_nodes_too_far_from_the_targets_are_omitted_from_paths_towards_them():
    mesh, t, _, ways = mesh_and_graph()
    open_, position = np.arange(t.n) % 7 > 0, mesh.V
    whole, _ = _core.goal_directed_search(*ways, 3, open_, position, position[:0], 0.0, 20.0)
    share = 0.5 * (
        ways[2].min() / np.ptp(position, axis=0).max()
    )  # a valid lower bound of lengths, even for the shortest edge
    end = int(np.argmax(np.where(np.isfinite(whole), whole, 0)))
    for most in (whole[end], whole[end] / 2):
        part, before = _core.goal_directed_search(*ways, 3, open_, position, position[[end]], share, most)
        assert np.array_equal(part[np.isfinite(part)], whole[np.isfinite(part)])
        assert np.isinf(part).sum() > np.isinf(whole).sum()
        assert (part[end] == whole[end]) == (most == whole[end])
        assert (before[np.isfinite(part)] >= 0).sum() == np.isfinite(part).sum() - 1


@pytest.mark.parametrize("seed", range(20))
def test_the_steiner_point_minimizes_the_total_length(seed):
    """No Steiner point is beyond the limit; sets may share a node or be enclosed by closed nodes."""
    *_, (indptr, indices, length) = mesh_and_graph()
    rng, n = np.random.default_rng(seed), len(indptr) - 1
    length = np.maximum(rng.uniform(-0.1, 1, len(length)), 0.0) * length
    open_ = rng.random(n) > rng.choice([0.0, 0.3, 0.6])
    sets = tuple(rng.choice(n, rng.choice([1, 1, 2, 20]), replace=False) for _ in range(3))
    expected, start = reference.steiner_paths(indptr, indices, length, sets, open_, 1e9)
    total = sum(
        reference.nearest_sources(indptr, indices, length, own, open_ | np.isin(np.arange(n), own), 1e9)[0]
        for own in sets
    )
    assert len(expected) == 0 or total[expected[0]] == total.min()
    for share in (0.9, 1.0, 1.1, 3.0):
        limit = share * float(total.min()) if len(expected) else 1e9
        nodes, start = _core.steiner_paths(indptr, indices, length, sets, open_, limit)
        if not len(expected) or share < 1:
            assert not len(nodes)
            continue
        assert total[nodes[0]] == total.min()
        for own, i, j in zip(sets, start[:-1], start[1:], strict=True):
            assert nodes[i] == nodes[0] and nodes[j - 1] in own
            for a, b in pairwise(nodes[i:j].tolist()):
                assert b in indices[indptr[a] : indptr[a + 1]]
                assert open_[b] or b in own


@pytest.mark.parametrize("limit", [-1.0, 0.0])
def test_paths_of_length_zero_reach_their_sources(limit):
    _, t, _, ways = mesh_and_graph()
    sources, open_ = np.array([3, 9, 9]), np.arange(t.n) % 7 > 0
    for search in (_core.nearest_sources, reference.nearest_sources):
        distance, _, source = search(*ways, sources, open_, limit)
        assert np.array_equal(np.flatnonzero(distance == 0), np.unique(sources[open_[sources]]))
        assert np.isinf(distance).sum() == len(distance) - np.count_nonzero(distance == 0)
        assert np.array_equal(source[distance == 0], np.flatnonzero(distance == 0))
