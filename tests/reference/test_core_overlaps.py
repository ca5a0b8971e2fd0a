"""Overlaps, sheets and assembled regions of the core agree with comparing all pairs of triangles."""

from itertools import pairwise

import numpy as np
import pytest
from reference import overlaps as reference

from igl_linabf import _core

KINDS = ("any", "ties", "sizes", "rounding", "apart")


def corners(rng, n, kind):
    """Return random points: plain, on a lattice, of all magnitudes, far away, or in two clusters (`kind`)."""
    z = rng.normal(size=(n, 2)) @ [1, 1j]
    if kind == "ties":
        return (np.round(z.real * 2) + 1j * np.round(z.imag * 2)) / 2
    if kind == "sizes":
        return z * np.exp(5 * rng.normal(size=n))
    if kind == "rounding":
        return 1e-8 * z + 1e6 * (1 + 1j)
    return z + 9 * (np.arange(n) % 2) if kind == "apart" else z


@pytest.mark.parametrize("kind", KINDS)
def test_overlapping_pairs_are_all_pairs_without_a_separating_axis(kind) -> None:
    rng, number = np.random.default_rng(5), 0
    for n in [3] * 3 + [40] * 5:
        z = corners(rng, n, kind)
        F = rng.integers(n, size=(3 * n, 3))
        F[0], F[-1] = 0, [0, 1, 1]  # degenerate faces: a point and a segment
        for chart in (np.zeros(3 * n, dtype=np.int64), rng.integers(-1, 3, size=3 * n)):
            found = _core.find_overlaps(z, F, chart, 10**6)
            np.testing.assert_array_equal(found, reference.find_overlaps(z, F, chart))
            number += len(found)
    assert number > 100


@pytest.mark.parametrize("kind", ["any", "ties", "apart"])
def test_common_areas_are_those_of_the_intersections(kind) -> None:
    rng = np.random.default_rng(8)
    z, pairs = corners(rng, 60, kind), rng.integers(40, size=(2000, 2))
    F = np.array([rng.permutation(60)[:3] for _ in range(40)])
    F = F[np.abs(((z[F[:, 1]] - z[F[:, 0]]).conj() * (z[F[:, 2]] - z[F[:, 0]])).imag) > 1e-6]
    pairs %= len(F)
    expected = reference.common_areas(z, F, pairs)
    np.testing.assert_allclose(_core.common_areas(z, F, pairs), expected, atol=1e-12)
    assert np.count_nonzero(expected) > 200


def test_degenerate_triangles_do_not_overlap() -> None:
    none = np.zeros((0, 3), dtype=np.int64)
    assert _core.find_overlaps(np.zeros(0, dtype=complex), none, none[:, 0], 9).shape == (0, 2)
    for z in (np.zeros(3, dtype=complex), np.arange(3) + 0j, np.full(3, complex(np.nan, 1))):
        assert _core.find_overlaps(z, np.array([[0, 1, 2]] * 20), np.zeros(20, dtype=np.int64), 9).shape == (
            0,
            2,
        )


@pytest.mark.parametrize("height", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("share", [0.9, 1.1])
def test_the_least_depth_is_a_millionth_of_the_smaller_height(height, share) -> None:
    """A long triangle reaches into a unit triangle; the order of the two triangles does not matter."""
    unit, tip = np.array([0, 2, 1 + 1j]), 1 + 1j * share * 1e-6 * min(height, 1.0)
    other = tip + height * np.array([-1 - 1j, 1 - 1j, 0])
    for one in (unit, unit[[0, 2, 1]]):
        for pair in ((one, other), (other, one), (other[::-1], one)):
            found = _core.find_overlaps(
                np.concatenate(pair), np.arange(6).reshape(2, 3), np.zeros(2, dtype=np.int64), 9
            )
            assert len(found) == _core.has_overlap(pair[0][None], pair[1][None]) == (share > 1)
            assert _core.has_overlap(np.array(pair), one[None] + 5) == (share > 1)


@pytest.mark.parametrize("kind", KINDS)
def test_lie_over_agrees_with_overlapping_pairs(kind) -> None:
    rng, seen = np.random.default_rng(6), set()
    for k in range(300):
        n, m = rng.integers(1, 4), rng.integers(0, 6)
        triangle = corners(rng, 3 * (n + m), kind).reshape(-1, 3)
        if k % 3 == 0:
            triangle *= np.exp(-2 * np.arange(n + m))[:, None]  # triangles so small that no pair may overlap
            triangle += np.where(np.arange(n + m) < n, np.arange(n + m), 0)[:, None]
        pairs = reference.find_overlaps(
            triangle.ravel(), np.arange(3 * (n + m)).reshape(-1, 3), np.zeros(n + m)
        )
        over = bool((pairs[:, 0] < n).any())
        assert _core.has_overlap(triangle[:n], triangle[n:]) == over
        seen.add(over)
    assert True in seen
    nothing = np.zeros((0, 3), dtype=complex)
    assert not _core.has_overlap(nothing, triangle) and not _core.has_overlap(nothing, nothing)


def list_adjacent_faces(edges, m):
    """Return the adjacent faces of each face, in CSR format."""
    i, j = np.unique(np.concatenate((edges, edges[:, ::-1])), axis=0).T
    return np.searchsorted(i, np.arange(m + 1)), j


def test_sheets_are_grown_from_the_first_pair_until_they_meet() -> None:
    """The test uses strips that overlap themselves, and random overlaps in random graphs of faces."""
    rng, number = np.random.default_rng(7), 0
    for k in range(80):
        m = int(rng.integers(2, 60))
        edges = np.column_stack((np.arange(m - 1), np.arange(1, m)))
        if k % 2:
            edges = np.concatenate((edges, rng.integers(m, size=(m // 3, 2))))
            edges = edges[edges[:, 0] != edges[:, 1]]
        face = np.arange(m)
        if k % 5 == 4:  # each face overlaps two adjacent faces, in one turn of the strip or in several
            apart = m - m // 2 if k % 2 else m // 4 + 1
            upper = np.repeat(face[: m - apart], 2)
            pairs = np.column_stack((upper, np.minimum(upper + apart + np.tile([0, 1], m - apart), m - 1)))
        else:
            apart = np.where(face < m // 2, 6, m // 4) if k % 4 < 2 else rng.integers(m, size=m)
            pairs = np.column_stack((face, face + apart))[(apart > 0) & (face + apart < m) & (face % 29 < 25)]
        if not len(pairs):
            continue
        upper, lower = np.unique(np.concatenate((pairs, pairs[:, ::-1])), axis=0).T
        for most in (1, 2, 6):
            faces, start = _core.overlap_sheets(upper, lower, *list_adjacent_faces(edges, m), most)
            expected = reference.overlap_sheets(pairs, edges.tolist(), m, most)
            assert [faces[i:j].tolist() for i, j in pairwise(start.tolist())] == expected
            number += len(expected)
    assert number > 300
    faces, start = _core.overlap_sheets(upper[:0], lower[:0], *list_adjacent_faces(edges, m), 2)
    assert not len(faces) and start.tolist() == [0]


def make_region(rng, kind):
    """Return the counter-clockwise triangles of a square, a disk of slivers, a long strip, or random ones."""
    if kind == 0:
        return np.array([[0, 1, 1 + 1j], [0, 1 + 1j, 1j]])
    if kind == 1:
        z = np.exp(2j * np.pi * np.sort(rng.random(rng.integers(3, 40))))
        return np.array([[z[0], *step] for step in pairwise(z[1:])])
    if kind == 2:
        x = np.linspace(0, 10, rng.integers(14, 40))
        return np.array([[a, b, a + 0.02j * (1 + k % 3)] for k, (a, b) in enumerate(pairwise(x))])
    triangle = rng.normal(size=(rng.integers(1, 20), 3, 2)) @ [1, 1j]
    return reference.upright(triangle * np.exp(3 * rng.normal()))[0]


@pytest.mark.parametrize("kind", range(4))
def test_regions_are_joined_if_they_fit_and_are_worth_it(kind) -> None:
    rng, apart, joined = np.random.default_rng(8), 0, 0
    for _ in range(6):
        n, number = int(rng.integers(2, 8)), 30
        regions = [make_region(rng, kind) for _ in range(n)]
        start = np.cumsum([0, *map(len, regions)])
        depth = np.where(rng.random(start[-1]) < 0.1, -1.0, rng.choice([1e-6, 1e-3, 0.05], size=start[-1]))
        pairs = rng.integers(n, size=(number, 2))
        if kind == 0:
            turn = 1j ** rng.integers(4, size=number)
            shift = 0.5 + 0.5j + 1j ** rng.integers(4, size=number) - turn * (0.5 + 0.5j)
        else:
            turn = np.exp(2j * np.pi * rng.random(number))
            shift = 3 * rng.normal(size=(number, 2)) @ [1, 1j]
        worth, page = rng.choice([200.0, 7.1, 0.1], size=number), rng.choice([20.0, 2.0], size=number)
        hinges = pairs, turn, shift, worth, page
        made = _core.merge_regions(np.concatenate(regions), depth, start, *hinges)
        expected = reference.merge_regions(regions, np.split(depth, start[1:-1]), *hinges)
        np.testing.assert_array_equal(made[0], expected[0])
        np.testing.assert_allclose(made[1], expected[1], rtol=0, atol=1e-11)
        np.testing.assert_allclose(made[2], expected[2], rtol=1e-11, atol=1e-11)
        joined += n - len(np.unique(made[0]))
        apart += len(np.unique(made[0])) - 1
    assert apart and joined


def test_empty_and_infinite_regions_are_not_joined() -> None:
    none, one = np.zeros(0), np.ones(1)
    made = _core.merge_regions(
        np.zeros((0, 3), complex), none, np.zeros(1, int), np.zeros((0, 2), int), *[none] * 4
    )
    assert [len(part) for part in made] == [0, 0, 0]
    for value in (np.nan, np.inf, 1e300):
        triangle = np.full((40, 3), value * (1 + 1j))
        start, pairs = np.array([0, 20, 20, 40]), np.array([[0, 2]])
        chart = _core.merge_regions(triangle, np.zeros(40), start, pairs, one, value * one, one, one)[0]
        assert len(chart) == 3
