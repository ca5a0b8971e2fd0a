"""The kernels as compiled loops and in NumPy."""

import os
import subprocess
import sys
from contextlib import nullcontext
from itertools import pairwise

import numpy as np
import pytest
from carried import MESHES
from conftest import DISKS, HOLES, STRESS, best_fit_distance, bumps, load
from scipy import sparse

import igl_linabf as il
from igl_linabf import kernels
from igl_linabf.angles import constraints_of
from igl_linabf.charts.outlines import NONE_KNOWN, Outline, Row, masks_of
from igl_linabf.kernels import choice
from igl_linabf.kernels.choice import compiled
from igl_linabf.surface import planar

pytest.importorskip("numba")

IN_ANY_ORDER = {"overlapping"}
FAN = np.stack((np.cos(np.pi / 4 * np.arange(8)), np.sin(np.pi / 4 * np.arange(8))))


def topology_and_angles():
    mesh = planar(*MESHES["crown"]())
    alpha = np.arctan2(mesh.double_area, mesh.dot)
    alpha[:, ::7] *= np.random.default_rng(0).uniform(0.1, 1, (3, 1))
    return mesh, mesh.topology, alpha


def masks_in_turn(scale=1):
    """Rings of several sizes, and stars that fit into some; on pages that hold a few."""
    turns, made = np.exp(2j * np.pi * np.arange(40) / 40), []
    for size in (1.5, 1.1, 0.8, 1.3, 0.5, 0.4):
        star = size * turns * (1 + 0.3 * np.cos(2 * np.pi * np.arange(40) / 8))
        rims = (star, 0.6 * star[::-1])[: 1 + (size > 1)]
        start, end = np.concatenate(rims), np.concatenate([np.roll(rim, -1) for rim in rims])
        made.append(Outline(start, end, np.ones(len(start), dtype=np.int64), 3.0))
    masks = masks_of(
        made, [np.exp(2j * np.pi * np.arange(k) / k) for k in (8, 3, 4, 1, 2, 5)], 9.0 * scale, 0.5
    )
    row = Row.of(masks)
    return 48 * scale, 3, row.spans, row.shapes, row.blocks, row.start, NONE_KNOWN


def stars_in_places():
    """What `masks_in_turn` is placed as."""
    side, most, spans, shapes, blocks, start, none = masks_in_turn()
    places, _ = kernels.placed(side, most, spans, shapes, blocks, start, none)
    return side, places, blocks, start


def boxes_beside(taken):
    """Low ones, the highest ones first, of which most find room; and cells that are taken."""
    sizes = np.random.default_rng(3).uniform((0.3, 0.5), (6, 5), (60, 2))
    return sizes[np.argsort(-sizes[:, 1])], taken


def groups_of_points():
    """A turned box of a grid, all four sides of which are as good; a pentagon; a cloud; a line."""
    x, y = np.divmod(np.arange(12), 4)
    five, cloud = 2 * np.exp(2j * np.pi * np.arange(5) / 5), np.random.default_rng(2).normal(size=(60, 2))
    groups = (0.3j + np.exp(0.4j) * (x + 1j * y), five, cloud @ [1, 1j], (2 + 1j) * np.arange(4))
    return np.concatenate(groups), np.cumsum([0, *map(len, groups)])


def turned_outlines():
    """Two closed outlines, one with level sides, one that counts twice; masks small, large and opposite."""
    star = 12 + 10j + np.exp(2j * np.pi * np.arange(30) / 30) * (7 + 2 * np.cos(np.arange(30) * np.pi / 3))
    box = np.array([2, 9.3, 9.3 + 4j, 2 + 4j]) + 1.7j
    start, end = np.concatenate((star, box)), np.concatenate((np.roll(star, -1), np.roll(box, -1)))
    turns = np.array([1, np.exp(0.7j), -np.exp(0.7j), 5.1 * np.exp(1.9j), 1, -1, 1, 1j, 3 * np.exp(-1j)])
    weight = np.repeat([2, 1], [30, 4])
    return start, end, weight, np.array([0, 30, 34]), turns, np.array([0, 0, 0, 0, 1, 1, 1, 1, 1]), 0.8


def triangles():
    """Counter-clockwise triangles of two charts, many of which overlap."""
    triangle = np.random.default_rng(2).normal(size=(60, 3, 2)) @ [1, 1j]
    a, b = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    turned = (a.conj() * b).imag < 0
    triangle[turned] = triangle[turned][:, [0, 2, 1]]
    end = np.repeat([20, 60], [20, 40])
    return triangle, end, np.full(60, 1e-6), np.full(60, 1e-15)


def test_triangles_lie_over_others_in_the_loops_as_in_numpy():
    rng, found = np.random.default_rng(4), []
    for _ in range(60):
        some, others = (rng.normal(size=(n, 3, 2)) @ [1, 1j] for n in (1, 4))
        some[0, 1] = some[0, 0] if rng.random() < 0.2 else some[0, 1]  # it has collapsed
        others[0] = some[0, [1, 0, 0]] + [0, 0, 1j]  # it touches along a side
        found.append(kernels.lie_over(some, others + 1.5))
        with kernels.numpy_only():
            assert kernels.lie_over(some, others + 1.5) == found[-1]
    assert {True, False} == set(found)


def squares_with_hinges():
    """Unit squares that are joined at sides, in turn; many would come over others."""
    rng, n = np.random.default_rng(3), 30
    square = np.array([[0, 1, 1 + 1j], [0, 1 + 1j, 1j]])
    turn = 1j ** rng.integers(4, size=200)
    shift = 0.5 + 0.5j + 1j ** rng.integers(4, size=200) - turn * (0.5 + 0.5j)
    pairs = rng.integers(n, size=(200, 2))
    depth = np.where(np.arange(2 * n) % 7 == 3, -1.0, 1e-6)
    worth = np.where(rng.random(200) < 0.8, 9.0, 0.1)
    hinges = kernels.Hinges(pairs, turn, shift, worth, np.full(200, 20.0))
    return np.tile(square, (n, 1)), depth, 2 * np.arange(n + 1), hinges


def pairs_of_faces(one, other, m):
    """Pairs of faces in some overlaps, both ways around, one of which winds on; and the faces beside each."""
    beside = np.column_stack((one, other))[other >= 0] % m
    begin, neighbour, _ = kernels.shortest_pairs(beside, np.zeros(len(beside)), m)
    k = np.arange(m)
    apart = np.where(k < m // 2, 6, np.where(k < 3 * m // 4, m // 4, 0))
    pairs = np.column_stack((k, k + apart))[(apart > 0) & (k + apart < m) & (k % 29 < 25)]
    code = np.unique(np.concatenate((pairs @ [m, 1], pairs @ [1, m])))
    return (*np.divmod(code, m), begin, neighbour)


def cases():
    """Each kernel with what it may get: sharp angles, holes, vertices without a row."""
    mesh, t, alpha = topology_and_angles()
    rng = np.random.default_rng(1)
    w, cot = alpha**2, 1 / np.tan(alpha)
    d, e = w.sum(axis=0), rng.normal(size=alpha.shape)
    constraints = constraints_of(t)
    pattern, row = constraints.pattern, constraints.row
    at = kernels.entries(pattern.ends, pattern.n)
    z, start = mesh.V[:, :2] @ [1, 1j], np.array([0, 7, len(mesh.double_area)])
    block = rng.normal(size=(len(at[1]), 4))
    merged = np.minimum(row, 20)  # many vertices share the last row, as around holes
    outer = np.where(t.interior, 0, z)
    collapsed = mesh.V[:, 1:].copy()  # and flipped in part
    collapsed[t.corner[:, 5]] = collapsed[t.corner[0, 5]]
    length = rng.uniform(1, 2, len(t.edges))
    graph = sparse.csr_array((np.tile(length, 2), (t.edges.T.ravel(), t.edges[:, ::-1].T.ravel())))
    ways = graph.indptr, graph.indices, graph.data
    one, other = t.sides
    some = np.flatnonzero(rng.random(pattern.n) < 0.2)
    number = np.full(pattern.n, -1)
    number[some] = np.arange(len(some))
    row_inside = number < 0
    rows = kernels.block_rows(*at[:2], number)
    of = np.repeat(some, np.diff(rows[0]))
    own = kernels.blocks_of_rows(block, *rows[1:], of)
    twin = np.full(cot.size, -1)
    twin[one], twin[other[other >= 0]] = other, one[other >= 0]
    return {
        "developed": (z, ~t.interior, one[other < 0], twin, t.corner, cot),
        "undirected": (t.corner, t.n),
        "used_vertices": (t.corner.T - 3, t.n),
        "entries": (merged[t.edges.T], 21),
        "products": (mesh.V, t.corner),
        "normals": (mesh.V, t.corner),
        "bends": (mesh.V, t.corner, t.sides[:, t.sides[1] >= 0], kernels.normals(mesh.V, t.corner)),
        "lengths": (mesh.V, t.edges),
        "cotangents": (
            np.concatenate((alpha, [[1e-12, 1.0, 3.0], [-1.0, 4.0, 6.0], [0.5, 2.0, 1.6]]), axis=1),
        ),
        "angle_sums": (t.corner, alpha, np.where(rng.random(cot.shape) < 0.1, 1e70, cot), t.n),
        "row_sums": (t.corner, cot, e, t.n),
        "errors": (t.corner, w, d, cot, *rng.normal(size=(2, t.n))),
        "projected": (w, d, cot),
        "conformal_errors": (t.corner, cot, *rng.normal(size=(2, t.n))),
        "rescaled": (t.corner, np.sin(alpha), np.exp(rng.normal(size=t.n) / 4)),
        "cut_short": (alpha, e, 0.7),
        "pair_weights": (w, d),
        "system_blocks": (
            kernels.entries(merged[t.edges.T], 21),
            *(merged[t.edges.T], t.sides, t.corner, merged, 18, w, d, cot),
        ),
        "at_edges": (cot, t.sides),
        "laplacian_entries": (at[0], at[2], pattern.ends, rng.normal(size=len(t.edges))),
        "product_inside": (*at[:2], block[:, 0], row_inside, block[: pattern.n, 1]),
        "pulled": (pattern.ends, t.edges, rng.normal(size=len(t.edges)), outer, pattern.n),
        "disparity": (w, d, cot),
        "conformal_weights": (w, d, cot),
        "signed_double_areas": (z, t.corner),
        "changes": (mesh.V, collapsed, t.corner, mesh.double_area, mesh.dot),
        "centred": (z, t.corner, mesh.double_area, np.array([1.0, 3.0]), np.array([0, 9, len(z)]), start),
        "boundary_loops": (*t.edges[t.sides[1] < 0].T, t.n),
        "in_one_piece": (t.sides, t.corner.shape[1]),
        "fans_around": (np.where(t.corner == 9, 3, t.corner), t.sides, t.n),
        "connected_labels": (t.edges[::3], t.n),
        "spanning_forest": (np.minimum(t.edges, t.n - 9), rng.permutation(len(t.edges))[::2], t.n),
        "above": (t.edges[kernels.spanning_forest(t.edges, np.arange(len(t.edges))[::3], t.n)], t.n),
        "nearest_sources": (*ways, np.array([3, 9, 9]), np.arange(t.n) % 7 > 0, 20.0),
        "ways_towards": (*ways, 3, np.arange(t.n) % 7 > 0, kernels.Rest(mesh.V, mesh.V[:0], 0.0, 20.0)),
        "meeting": (
            *ways,
            (np.array([3, 9, 9]), t.edges[40], np.array([t.n - 9])),
            np.arange(t.n) % 7 > 0,
            30.0,
        ),
        "shortest_pairs": (merged[t.edges] + 3, rng.permutation(len(t.edges)) * 1.0, 24),
        "far_apart": (*ways[:2], rng.permutation(t.n), 2, np.arange(t.n) % 9 == 4),
        "arcs_between": (t.edges[::2], np.bincount(t.edges[::2].ravel(), minlength=t.n) != 2),
        "opened": (
            *(t.edges, t.sides.T % t.corner.shape[1], np.append(np.arange(len(t.edges) // 2), 3)),
            *(5, t.n, t.corner.shape[1]),
        ),
        "nodes_on_paths": (
            kernels.nearest_sources(*ways, np.arange(3), np.arange(t.n) >= 0, 20.0)[1],
            t.edges[9],
        ),
        "without_leaves": (t.edges[rng.random(len(t.edges)) < 0.4], np.arange(t.n) % 5 == 0),
        "way_of_fewest": (*ways[:2], np.arange(t.n) % 50 == 3, np.arange(t.n) == t.n - 9),
        "shortest_odd_walk": (*ways, (graph.data > 1.9) + 2 * (graph.data < 1.1), 5, 4),
        "overlap_sheets": (*pairs_of_faces(one, other, t.corner.shape[1]), 4),
        "block_dots": (np.array([0, 3, 3, 40, 40]), *rng.normal(size=(2, 40))),
        "block_axpy": (np.array([0, 3, 3, 40, 40]), rng.normal(size=4), *rng.normal(size=(2, 40))),
        "overlapping": (*triangles(),),
        "lie_over": (triangles()[0][:3] - 6, triangles()[0]),
        "assembled": squares_with_hinges(),
        "dot": tuple(rng.normal(size=(2, 40))),
        "turn": (rng.normal(size=40), 0.7, rng.normal(size=40)),
        "go": (rng.normal(size=40), 0.7, *rng.normal(size=(2, 40))),
        "move": (*rng.normal(size=(2, 40)), 0.7, *rng.normal(size=(2, 40))),
        "drawn": (*turned_outlines(),),
        "drawn_loops": (some[:30], np.array([0, 3, 11, 30]), *rng.normal(size=(2, t.n)) / 3),
        "block_rows": (*at[:2], number),
        "blocks_of_rows": (block, *rows[1:], of),
        "without_rows": (*rows[:2], own, rng.normal(size=2 * len(some)), rng.normal(size=2 * pattern.n + 3)),
        "left_at_rows": (*rows[:2], own, some, *rng.normal(size=(2, 2 * pattern.n + 3))),
        "placed": (*masks_in_turn(),),
        "taken_cells": stars_in_places(),
        "on_shelves": boxes_beside(kernels.taken_cells(*stars_in_places())[0]),
        "narrowest_turns": groups_of_points(),
        "divisions": (
            mesh.V[:, :2],
            *(t.edges, length, ~t.interior, np.array([[1.0, 0.0], [0.6, 0.8]]), np.array([0.1, -0.2]), FAN),
        ),
        "behind_least_cut": (t.edges, (1000 * length).astype(np.int64), t.n, 3, t.n - 9),
        "block_product": (*at[:2], block, rng.normal(size=2 * pattern.n)),
        "products_of_entries": (*at[:2], block, rng.normal(size=(pattern.n, 3)), np.array([5, 40])),
        "product_with_pairs": (*at[:2], block[:, 0], rng.normal(size=(pattern.n, 2))),
    }


def steps(walk, n):
    """The edges of a walk over copies of n nodes, each by its ends."""
    return [sorted(step) for step in pairwise((walk % n).tolist())]


@pytest.mark.parametrize("name", cases())
def test_the_loops_are_the_same_as_numpy(name):
    kernel, args, others = getattr(kernels, name), cases()[name], cases()[name]
    assert kernels.is_fast()
    fast = kernel(*args)
    with kernels.numpy_only():
        assert not kernels.is_fast()
        plain = kernel(*others)
    made, expected = (x if isinstance(x, tuple) else () if x is None else (x,) for x in (fast, plain))
    if name in IN_ANY_ORDER:
        made, expected = ((np.unique(rows, axis=0),) for (rows,) in (made, expected))
    if name == "shortest_odd_walk":  # the way back is as short
        n = len(args[0]) - 1
        made, expected = ((np.array(sorted(steps(walk, n))),) for (walk,) in (made, expected))
    # some change what they are given
    for a, b in zip((*made, *args), (*expected, *others), strict=True):
        if isinstance(a, tuple):
            continue
        assert np.asarray(a).dtype == np.asarray(b).dtype and np.shape(a) == np.shape(b)
        largest = np.abs(b).max(initial=0, where=np.isfinite(b))
        np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-11 * largest)


@pytest.mark.parametrize("known", [0, 2, 5, 6])
def test_masks_go_to_the_same_places_where_those_of_the_first_ones_are_known(known):
    *given, none = masks_in_turn(3)  # on pages of several words
    with kernels.numpy_only():
        expected = kernels.placed(*given, none)
    for only in (nullcontext, kernels.numpy_only):
        with only():
            for a, b in zip(kernels.placed(*given, expected[0][:known]), expected, strict=True):
                np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("ways", [1, 3, 6])
@pytest.mark.parametrize("to_the_rim", [0.1, 1.0, 10.0])
def test_walks_that_cross_many_ways_are_as_short_as_those_of_numpy(ways, to_the_rim):
    """On a square whose rim is one node: excursions from there are put together as is shortest."""
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
    indptr, indices, edge = kernels.shortest_pairs(ends, length, k * k + 1)
    graph, n = (indptr, indices, length[edge], flip[edge]), k * k + 1
    made = kernels.shortest_odd_walk(*graph, k * k, 1 << ways)
    with kernels.numpy_only():
        expected = kernels.shortest_odd_walk(*graph, k * k, 1 << ways)
    known = {tuple(sorted(pair)): e for pair, e in zip(ends.tolist(), range(len(ends)), strict=True)}
    own, other = ([known[tuple(step)] for step in steps(walk, n)] for walk in (made, expected))
    assert length[own].sum() == pytest.approx(length[other].sum(), rel=1e-12)
    assert np.bitwise_xor.reduce(flip[own]) == (1 << ways) - 1
    assert made[0] == ((1 << ways) - 1) * n + k * k and made[-1] == k * k
    assert (made[:-1] // n ^ made[1:] // n == flip[own]).all()


def test_what_leads_away_from_all_targets_is_left_out_of_the_ways_to_them():
    *ways, source, open_, rest = cases()["ways_towards"]
    whole, _ = kernels.ways_towards(*ways, source, open_, rest)
    share = 0.5 * (ways[2].min() / np.ptp(rest.position, axis=0).max())  # any edge may be as short as that
    end = int(np.argmax(np.where(np.isfinite(whole), whole, 0)))
    towards = rest._replace(targets=rest.position[[end]], share=share)
    for most in (whole[end], whole[end] / 2):
        part, before = kernels.ways_towards(*ways, source, open_, towards._replace(limit=most))
        assert np.array_equal(part[np.isfinite(part)], whole[np.isfinite(part)])
        assert np.isinf(part).sum() > np.isinf(whole).sum()
        assert (part[end] == whole[end]) == (most == whole[end])
        assert (before[np.isfinite(part)] >= 0).sum() == np.isfinite(part).sum() - 1


@pytest.mark.parametrize("seed", range(20))
def test_ways_meet_where_they_are_shortest_in_total(seed):
    """And nowhere, if the total is over the limit; sets may share a node or be closed in."""
    indptr, indices, length = cases()["nearest_sources"][:3]
    rng, n = np.random.default_rng(seed), len(indptr) - 1
    length = np.maximum(rng.uniform(-0.1, 1, len(length)), 0.0) * length
    open_ = rng.random(n) > rng.choice([0.0, 0.3, 0.6])
    sets = tuple(rng.choice(n, rng.choice([1, 1, 2, 20]), replace=False) for _ in range(3))
    with kernels.numpy_only():
        expected, start = kernels.meeting(indptr, indices, length, sets, open_, 1e9)
        total = sum(
            kernels.nearest_sources(indptr, indices, length, own, open_ | np.isin(np.arange(n), own), 1e9)[0]
            for own in sets
        )
    assert len(expected) == 0 or total[expected[0]] == total.min()
    for share in (0.9, 1.0, 1.1, 3.0):
        limit = share * float(total.min()) if len(expected) else 1e9
        nodes, start = kernels.meeting(indptr, indices, length, sets, open_, limit)
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
def test_paths_of_no_length_reach_their_sources(limit):
    *ways, sources, open_, _ = cases()["nearest_sources"]
    fast = kernels.nearest_sources(*ways, sources, open_, limit)
    with kernels.numpy_only():
        plain = kernels.nearest_sources(*ways, sources, open_, limit)
    for distance, _, source in (fast, plain):
        assert np.array_equal(np.flatnonzero(distance == 0), np.unique(sources[open_[sources]]))
        assert np.isinf(distance).sum() == len(distance) - np.count_nonzero(distance == 0)
        assert np.array_equal(source[distance == 0], np.flatnonzero(distance == 0))


def test_every_kernel_with_loops_is_compared():
    with_loops = {name for name, kernel in vars(kernels).items() if hasattr(kernel, "__wrapped__")}
    assert with_loops - {"numpy_only"} == set(cases())


LONG = ("stress__flipfree_deer.obj", "stress__optcuts_golf.obj", "ball")


@pytest.mark.parametrize("name", ["bumps", "cortex", "ball", "pial_with_holes", *HOLES, *DISKS, *STRESS])
@pytest.mark.parametrize("method", ["linabf", "abf"])
def test_maps_are_the_same_to_nine_digits(name, method):
    V, F = load(name)
    fast = il.flatten(V, F, method)
    with kernels.numpy_only():
        plain = il.flatten(V, F, method)
    if method == "abf" and name in LONG:
        return  # hundreds of steps carry rounding along
    assert np.abs(fast.angles - plain.angles).max() < 1e-9
    # the axes of a symmetric map are known to fewer digits
    assert best_fit_distance(fast.uv, plain.uv) < 1e-9
    assert fast.outcome == plain.outcome
    assert [step.inner_steps for step in fast.steps] == [step.inner_steps for step in plain.steps]


def run(code, **environment):
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, **environment}
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


FLATTEN = """
import sys, igl, igl_linabf as il
from igl_linabf import kernels
V, F = igl.icosahedron()
print(kernels.is_fast(), len(il.linabf(V, F[1:])), bool(sys.modules.get('numba')))
"""


def test_it_can_be_switched_off_and_numba_is_then_not_imported():
    assert run(FLATTEN, IGL_LINABF_FAST="0") == ["False", "12", "False"]


def test_all_works_where_numba_is_missing():
    assert run("import sys; sys.modules['numba'] = None\n" + FLATTEN) == ["False", "12", "False"]


def test_where_no_folder_can_hold_the_code_it_is_compiled_all_the_same(monkeypatch):
    from numba.core.caching import CompileResultCacheImpl

    monkeypatch.setattr(CompileResultCacheImpl, "_locator_classes", [])
    made = compiled.__wrapped__(kernels.pair_weights.__closure__[1].cell_contents)
    w = np.random.default_rng(0).random((3, 5))
    np.testing.assert_allclose(made(w, w.sum(axis=0)), kernels.pair_weights(w, w.sum(axis=0)))


def test_code_that_is_kept_is_the_code_that_was_asked_for(tmp_path, monkeypatch):
    from igl_linabf.kernels.kept import Files

    def files(stamp):
        return Files(str(tmp_path), "loops-1.py3", stamp)

    files("old").save(("int64",), "of older loops")
    one, other = files("new"), files("new")
    write = other._save_data
    monkeypatch.setattr(one, "_load_index", dict)  # read before the other process wrote it

    def meanwhile(name, data):
        one.save(("int64",), "of integers")
        write(name, data)

    monkeypatch.setattr(other, "_save_data", meanwhile)
    other.save(("float64",), "of numbers")
    assert files("new").load(("float64",)) in (None, "of numbers")
    assert files("new").load(("int64",)) == "of integers"

    full = files("newest")
    monkeypatch.setattr(full, "_save_data", lambda *_: (_ for _ in ()).throw(OSError("no space left")))
    with pytest.raises(OSError, match="no space left"):
        full.save(("int64",), "of the newest loops")
    assert files("newest").load(("int64",)) is None


def test_loops_from_the_disk_give_the_same_bits_as_in_the_process_that_compiled_them(tmp_path):
    code = (
        f"import hashlib, sys; sys.path.insert(0, {os.path.dirname(__file__)!r})\n"
        "from conftest import load; from igl_linabf import flatten\n"
        "print(hashlib.md5(flatten(*load('cortex')).uv.tobytes()).hexdigest())"
    )
    first, second = (run(code, NUMBA_CACHE_DIR=str(tmp_path)) for _ in range(2))
    assert next(tmp_path.rglob("*.nbc"), None) is not None
    assert first == second


def test_code_is_found_on_the_disk_only_where_all_that_it_follows_from_is_the_same(monkeypatch):
    def digest(part="SCALE * x", scale=0.5):
        known = {"SCALE": scale}
        exec(f"def part(x): return {part}\ndef loops(x): return part(x) + 1.0", known)
        monkeypatch.setattr(choice, "_parts", {known["part"]})
        return choice._digest(known["loops"])

    own = digest()
    assert digest() == own
    assert own not in (digest("SCALE / x"), digest(scale=0.25))
    monkeypatch.setattr(choice, "FASTMATH", ())
    assert digest() != own


def test_a_small_disk_is_solved_the_same_by_loops_and_by_a_library():
    V, F = bumps(500)
    fast = il.flatten(V, F)
    with kernels.numpy_only():
        plain = il.flatten(V, F)
    assert fast.inner_steps == plain.inner_steps
    np.testing.assert_allclose(fast.uv, plain.uv, rtol=0, atol=1e-10 * np.ptp(plain.uv))
