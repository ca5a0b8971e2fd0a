"""Overlaps agree with clipping all pairs of triangles, and cuts along seams remove overlaps."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import shapely
from conftest import DISKS, load, tree_cut

from igl_linabf import MeshError, MeshWarning, cut, flatten, quality
from igl_linabf.charts import find_separating_seams, make_bijective
from igl_linabf.measures import overlapping, overlaps
from igl_linabf.surface import label_face_components


def strip(turns: float = 2.4, n: int = 60) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a straight strip of four rows, and a map that winds the strip around a centre onto itself."""
    t, h = np.meshgrid(np.linspace(0, 2 * np.pi * turns, n), np.linspace(0, 0.4, 5), indexing="ij")
    t, h = t.ravel(), h.ravel()
    i = (5 * np.arange(n - 1)[:, None] + np.arange(4)).ravel()
    F = np.concatenate((np.column_stack((i, i + 1, i + 5)), np.column_stack((i + 1, i + 6, i + 5))))
    uv = (1 - h + 0.03 * t)[:, None] * np.column_stack((np.cos(t), np.sin(t)))
    backwards = igl.doublearea(uv, F) < 0
    F[backwards] = F[backwards][:, [0, 2, 1]]
    return np.column_stack((t, h, 0 * t)), F, uv


def find_overlaps_by_clipping(uv: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Return all pairs of triangles whose intersection has an area, by clipping polygons."""
    polygons = shapely.polygons(uv[F])
    i, j = np.triu_indices(len(F), 1)
    area = shapely.area(shapely.intersection(polygons[i], polygons[j]))
    return np.column_stack((i, j))[area > 1e-11]


def split_into_charts(V: np.ndarray, F: np.ndarray, seams: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the charts into which seams divide a surface."""
    V, F, _ = cut(V, F, seams)
    chart = label_face_components(F, len(V))
    return [igl.remove_unreferenced(V, F[chart == i])[:2] for i in range(chart.max() + 1)]


def test_pairs_of_a_spiral_agree_with_clipping() -> None:
    _, F, uv = strip()
    pairs = overlaps(uv, F)
    assert len(pairs) > 500
    assert np.array_equal(pairs, find_overlaps_by_clipping(uv, F))


@pytest.mark.parametrize("turns", [0.98, 1.02, 1.1])
def test_pairs_where_the_ends_of_a_ring_meet_agree_with_clipping(turns: float) -> None:
    angle, radius = np.linspace(0, 2 * np.pi * turns, 40), np.linspace(1, 2.5, 12)
    z = (np.exp(1j * angle)[:, None] * radius).ravel()
    corner = np.arange(len(z)).reshape(40, 12)
    a, b, c, d = (x.ravel() for x in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    F, uv = (
        np.vstack((np.column_stack((a, b, c)), np.column_stack((a, c, d)))),
        np.column_stack((z.real, z.imag)),
    )
    assert (len(overlaps(uv, F)) > 0) == (turns > 1)
    expected = find_overlaps_by_clipping(uv, F)
    for scale, faces in ((1, F), (1e-9, F), (1e6, F[:, ::-1])):
        assert np.array_equal(overlaps(scale * uv, faces), expected)


@pytest.mark.parametrize("turns", [1.4, 2.3, 3.1])
def test_no_pair_is_missed_where_a_wide_chart_winds_over_itself(turns: float) -> None:
    """Many overlapping pairs are far from the boundary; the result equals a search over all faces."""
    angle, radius = np.linspace(0, 2 * np.pi * turns, int(60 * turns)), np.linspace(1, 4, 20)
    z = (np.exp(1j * angle)[:, None] * radius).ravel()
    corner = np.arange(len(z)).reshape(len(angle), 20)
    a, b, c, d = (x.ravel() for x in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    F = np.vstack((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    for faces in (F, F[:, ::-1]):
        pairs = overlaps(np.column_stack((z.real, z.imag)), faces)
        assert len(pairs) > 2000
        assert np.array_equal(pairs, overlaps(np.column_stack((z.real, z.imag)), faces, between=True))


def test_a_flipped_face_inside_a_sound_boundary_overlaps_its_neighbours() -> None:
    uv, F = igl.triangulated_grid(7, 7)
    uv[24] += [0.4, 0.1]  # moves the vertex beyond its neighbours
    pairs = overlaps(uv, F)
    assert len(pairs)
    assert np.array_equal(pairs, find_overlaps_by_clipping(uv, F))


def test_pairs_of_flipped_faces_agree_with_clipping() -> None:
    _, F, uv = strip(0.9, 20)
    uv = uv + np.random.default_rng(0).normal(scale=0.1, size=uv.shape)
    pairs = overlaps(uv, F)
    assert (igl.doublearea(uv, F) < 0).any()
    assert np.array_equal(pairs, find_overlaps_by_clipping(uv, F))


def test_pairs_do_not_depend_on_numbering_nor_on_a_similarity() -> None:
    _, F, uv = strip()
    pairs = overlaps(uv, F)
    assert np.array_equal(overlaps(uv @ [[3e3, -4e3], [4e3, 3e3]] + [1e3, 5e4], F), pairs)
    rng = np.random.default_rng(1)
    vertex, face = rng.permutation(len(uv)), rng.permutation(len(F))
    moved = np.empty_like(uv)
    moved[vertex] = uv
    renumbered = np.sort(face[overlaps(moved, vertex[F][face])], axis=1)
    assert np.array_equal(np.unique(renumbered, axis=0), pairs)


def test_touching_faces_do_not_overlap_and_charts_are_compared_on_request() -> None:
    _, F, uv = strip(0.3, 10)
    right = uv + np.array([1.1, 0])
    two, both = np.concatenate((uv, right)), np.concatenate((F, F + len(uv)))
    assert not len(overlaps(two, both))
    assert np.array_equal(overlaps(two, both, between=True), find_overlaps_by_clipping(two, both))
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]) / 3
    tiles = np.concatenate([square + np.array([x, y]) / 3 for x in range(5) for y in range(5)])
    pair = np.array([[0, 1, 2], [0, 2, 3]])
    assert not len(overlaps(tiles, np.concatenate([pair + 4 * i for i in range(25)]), between=True))


@pytest.mark.parametrize(("depth", "counts"), [(1e-2, 1), (1e-5, 1), (3e-6, 1), (3e-7, 0), (-1e-9, 0)])
@pytest.mark.parametrize("size", [1.0, 1e-9])
def test_overlaps_are_deeper_than_a_millionth_of_the_smaller_height(
    depth: float, counts: int, size: float
) -> None:
    # two triangles of height 1; the apex of the lower one is a distance of `depth` inside the upper one
    uv = size * np.array([[0, 0], [4, 0], [2, 1.0], [2, depth], [1, depth - 1], [3, depth - 1]])
    F = np.array([[0, 1, 2], [3, 4, 5]])
    assert len(overlaps(uv, F, between=True)) == counts


def two_sheets() -> tuple[np.ndarray, np.ndarray]:
    """Return two planar sheets that pass through each other along a slit.

    No face is flipped, and the boundary loops do not cross. At the two ends of the slit, the angles sum to
    4 pi. Both boundary loops run counter-clockwise.
    """
    sheets, faces, n = [], [], 0
    for half in (3, 2):
        side = np.arange(-half, half + 1)
        x, y = np.meshgrid(side, side, indexing="ij")
        xy = np.column_stack((x.ravel(), y.ravel())).astype(float)
        m = 2 * half + 1
        a = (m * np.arange(m - 1)[:, None] + np.arange(m - 1)).ravel()
        F = np.concatenate((np.column_stack((a, a + m, a + m + 1)), np.column_stack((a, a + m + 1, a + 1))))
        sheets.append(xy)
        faces.append(F + n)
        n += m * m
    uv = np.concatenate(sheets)
    at = {
        (sheet, *p): i
        for sheet, (k, xy) in enumerate(zip((0, 49), sheets, strict=True))
        for i, p in enumerate(xy.astype(int).tolist(), k)
    }
    # both sheets share the ends of the slit
    for old, new in ((at[1, -1, 0], at[0, -1, 0]), (at[1, 1, 0], at[0, 1, 0])):
        faces[1][faces[1] == old] = new
    middle = at[0, 0, 0], at[1, 0, 0]
    for F, mine, other in ((faces[0], *middle), (faces[1], *middle[::-1])):
        below = uv[F].mean(axis=1)[:, 1] < 0
        # below the slit, the faces of each sheet continue in the other sheet
        F[below[:, None] & (mine == F)] = other
    return uv, np.concatenate(faces)


def test_two_sheets_through_each_other_overlap_although_their_loops_do_not_cross() -> None:
    uv, F = two_sheets()
    assert (igl.doublearea(uv, F) > 0).all()
    assert label_face_components(F, len(uv)).max() == 0
    used = np.unique(F)
    assert len(used) == 49 + 25 - 2
    pairs = overlaps(uv, F)
    assert len(pairs) >= 32  # every face of the smaller sheet overlaps the larger one
    clipped = {tuple(pair) for pair in find_overlaps_by_clipping(uv, F).tolist()}
    assert {tuple(pair) for pair in pairs.tolist()} == clipped


def test_unreferenced_vertices_may_be_nan() -> None:
    _, F, uv = strip()
    padded = np.concatenate((np.full((2, 2), np.nan), uv))
    assert np.array_equal(overlaps(padded, F + 2), overlaps(uv, F))


@pytest.mark.parametrize("name", [d for d in DISKS if "camel_b" not in d] + ["bumps", "cortex"])
def test_natural_disks_do_not_overlap(name: str) -> None:
    V, F = load(name)
    uv = flatten(V, F).uv
    assert not len(overlaps(uv, F)) and not len(overlaps(uv, F, between=True))


def test_a_wound_strip_is_cut_across_once_a_turn() -> None:
    V, F, uv = strip()
    seams = find_separating_seams(V, F, overlaps(uv, F))
    assert len(split_into_charts(V, F, seams)) == 3
    assert np.allclose(np.linalg.norm(V[seams[:, 0]] - V[seams[:, 1]], axis=1).sum(), 2 * 0.4)


@pytest.mark.parametrize(
    "name, leaves", [("closed__igl_cow.off", 8), ("closed__optcuts_horse_f10000.obj", 8)]
)
def test_a_cut_model_is_taken_apart_into_at_most_three_charts(name: str, leaves: int) -> None:
    waiting, done = [tree_cut(*load(name), leaves)], 0
    assert len(overlaps(flatten(*waiting[0]).uv, waiting[0][1]))
    while waiting:
        V, F = waiting.pop()
        pairs = overlaps(flatten(V, F).uv, F)
        if len(pairs):
            waiting += split_into_charts(V, F, find_separating_seams(V, F, pairs))
        else:
            done += 1
    assert 2 <= done <= 3


def test_a_wound_strip_is_unwound_in_one_piece() -> None:
    _, F, uv = strip(1.2, 30)
    made = make_bijective(uv, F, iterations=20)
    assert not len(overlaps(made, F)) and (igl.doublearea(made, F) > 0).all()


@pytest.mark.parametrize("pairs", [[[0, 0]], [[0, 9999]], [[0, 1, 2]], [[0.5, 1.0]]])
def test_invalid_pairs_are_rejected(pairs: list) -> None:
    V, F, _ = strip()
    with pytest.raises(MeshError, match="pairs"):
        find_separating_seams(V, F, pairs)


def test_a_list_with_too_many_pairs_says_that_there_are_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """Triangles are stacked in two charts, and each chart has more pairs than the limit."""
    monkeypatch.setattr(overlapping, "MAX_PAIRS", 50)
    n = 20
    F = np.column_stack((np.zeros(n, dtype=np.int64), np.arange(1, 2 * n, 2), np.arange(2, 2 * n + 1, 2)))
    uv = np.concatenate(([[0.0, 0]], np.tile([[1.0, 0], [0, 1]], (n, 1))))
    with pytest.warns(MeshWarning, match="more than 50 pairs"):
        pairs = overlaps(uv, F)
    assert len(pairs) == 51
    found = overlapping.find_overlapping_pairs_of_charts([(uv, F), (uv, F), (uv[:7], F[:3])])
    assert list(map(len, found)) == [51, 51, 3]
    measured = quality(np.column_stack((uv, np.zeros(len(uv)))), F, uv)
    assert measured.overlaps == 51 and "more than 50" in str(measured)
    assert overlapping.format_pair_count(50) == "50"
