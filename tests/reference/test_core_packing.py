"""The packing functions of the core agree with their references."""

from itertools import pairwise

import numpy as np
import pytest
from reference import packing as reference

from igl_linabf import _core

FAN = np.stack((np.cos(np.pi / 16 * np.arange(32)), np.sin(np.pi / 16 * np.arange(32))))


def star(size, n=30, arms=5):
    """Return the corners of a star."""
    t = 2 * np.pi * np.arange(n) / n
    return size * np.exp(1j * t) * (1 + 0.3 * np.cos(arms * t))


def sides_of(*rims):
    """Return the starts and the ends of the sides of closed outlines."""
    return np.concatenate(rims), np.concatenate([np.roll(rim, -1) for rim in rims])


def outlines():
    """Return the sides of three outlines: a star, a box with a hole, and random sides that cross."""
    rng = np.random.default_rng(3)
    box = np.array([2, 9.3, 9.3 + 4j, 2 + 4j]) + 1.7j
    hole = (box - 5.6 - 3.7j)[::-1] / 2 + 5.6 + 3.7j
    cloud = rng.normal(size=(12, 2)) @ [3, 3j]
    each = [sides_of(star(7) + 12 + 10j), sides_of(box, hole), sides_of(cloud)]
    start, end = (np.concatenate(rims) for rims in zip(*each, strict=True))
    sides = np.cumsum([0, *(len(a) for a, _ in each)])
    weight = np.repeat([2, 1, 1], np.diff(sides))
    return start, end, weight, sides


def make_masks(scale):
    """Return masks of rings and of small stars in several directions, and the range of masks of each."""
    sizes = (1.5, 1.1, 0.8, 1.3, 0.5, 0.4)
    each = [sides_of(*(star(s, 40), 0.6 * star(s, 40)[::-1])[: 1 + (s > 1)]) for s in sizes]
    start, end = (np.concatenate(rims) for rims in zip(*each, strict=True))
    sides = np.cumsum([0, *(len(a) for a, _ in each)])
    number = np.array([4, 3, 4, 1, 2, 5])
    turns = scale * np.concatenate([np.exp(2j * np.pi * np.arange(k) / k) for k in number])
    of = np.repeat(np.arange(len(sizes)), number)
    weight = np.ones(len(start), dtype=np.int64)
    shapes, _, blocks, begin = _core.rasterize(start, end, weight, sides, turns, of, 0.25)
    after = np.cumsum(number)
    return np.column_stack((after - number, after)), shapes, blocks, begin


def cells_of(shapes, blocks, begin):
    """Return the cells of each mask as an array."""
    return [
        reference.cells_of(shape, blocks[i:j]) for shape, (i, j) in zip(shapes, pairwise(begin), strict=True)
    ]


@pytest.mark.parametrize("half", [0.0, 0.31, 0.8, 2.3])
def test_masks_contain_the_cells_that_rotated_outlines_touch(half):
    start, end, weight, sides = outlines()
    turns = np.array([1, np.exp(0.7j), 2.1 * np.exp(1.9j), 1, 1j, 0.01, 3 * np.exp(-1j), 1, np.exp(2j)])
    of = np.repeat([0, 1, 2], [3, 4, 2])
    shapes, low, blocks, begin = _core.rasterize(start, end, weight, sides, turns, of, half)
    for k, touched in enumerate(cells_of(shapes, blocks, begin)):
        own = slice(sides[of[k]], sides[of[k] + 1])
        corner, expected = reference.mask(turns[k] * start[own], turns[k] * end[own], weight[own], half)
        assert low[k] == pytest.approx(corner)
        # a side along the border of a cell does not touch the cell at half = 0
        if half or k not in (3, 4, 6):
            np.testing.assert_array_equal(touched, expected)
        size = blocks[begin[k] : begin[k + 1], 2:].prod(axis=1)
        assert (np.diff(size) <= 0).all()  # the largest block comes first


def test_opposite_rotations_give_the_mask_rotated_by_180_degrees():
    start, end, weight, sides = outlines()
    turns, of = np.exp(0.7j) * np.array([1, -1, 1, 1, -1]), np.array([0, 0, 0, 1, 1])
    shapes, low, blocks, begin = _core.rasterize(start, end, weight, sides, turns, of, 0.8)
    cells = cells_of(shapes, blocks, begin)
    for one, other in ((0, 1), (1, 2), (3, 4)):
        np.testing.assert_array_equal(cells[one], cells[other][::-1, ::-1])
        assert low[other] == pytest.approx(-low[one] - shapes[one] @ [1j, 1])


@pytest.mark.parametrize("corner", [np.nan, np.inf, 1e200])
def test_an_outline_too_large_for_a_grid_is_rejected(corner):
    start, end = sides_of(np.array([0, 1, corner + 1j]))
    one = np.ones(1, dtype=np.complex128)
    with pytest.raises((ValueError, MemoryError)):
        _core.rasterize(start, end, np.ones(3, np.int64), np.array([0, 3]), one, np.zeros(1, np.int64), 0.5)


@pytest.mark.parametrize(("scale", "side", "most"), [(4, 22, 3), (4, 22, 1), (5, 70, 9), (30, 40, 2)])
def test_masks_are_placed_where_the_bounding_square_grows_least(scale, side, most):
    spans, shapes, blocks, begin = make_masks(scale)
    made = _core.place_masks(side, most, spans, shapes, blocks, begin)
    expected = reference.place_masks(side, most, spans, cells_of(shapes, blocks, begin))
    for a, b in zip(made, expected, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("side", [48, 144])
def test_placed_charts_occupy_disjoint_cells(side):
    spans, shapes, blocks, begin = make_masks(side * 3 / 16)
    places, extents = _core.place_masks(side, 3, spans, shapes, blocks, begin)
    cells, expected = cells_of(shapes, blocks, begin), np.zeros((len(extents), side, side), dtype=np.int64)
    for k, page, x, y in places:
        high, wide = shapes[k]
        expected[page, y : y + high, x : x + wide] += cells[k]
    assert expected.max() == 1
    np.testing.assert_array_equal(_core.occupied_cells(side, places, blocks, begin), expected > 0)


@pytest.mark.parametrize("widest", [6, 60, 200])  # the widest rectangles are wider than a page
def test_rectangles_are_placed_on_shelves_around_occupied_cells(widest):
    spans, shapes, blocks, begin = make_masks(9)
    places, _ = _core.place_masks(48, 3, spans, shapes, blocks, begin)
    sizes = np.random.default_rng(3).uniform((0.3, 0.5), (widest, 5), (60, 2))
    sizes = sizes[np.argsort(-sizes[:, 1])]
    pages = _core.occupied_cells(48, places, blocks, begin)
    for taken in (*pages, np.zeros((48, 48), dtype=bool), np.ones((9, 9), dtype=bool)):
        made, expected = _core.pack_shelves(sizes, taken), reference.pack_shelves(sizes, taken)
        np.testing.assert_allclose(made, expected, atol=1e-11)


def make_point_groups():
    """Return four groups of points: a rotated grid, a pentagon, a random cloud, and repeated points."""
    x, y = np.divmod(np.arange(12), 4)
    five, rng = 2 * np.exp(2j * np.pi * np.arange(5) / 5), np.random.default_rng(2)
    cloud, flat = rng.normal(size=(40, 2)) @ [1, 1j], rng.normal(size=(20, 2)) @ [1, 1e-3j] * np.exp(0.3j)
    return [0.3j + np.exp(0.4j) * (x + 1j * y), five, cloud, np.tile(flat, 2)]


def test_bounding_rectangles_are_the_smallest_along_a_side_of_the_hull():
    groups = make_point_groups()
    turns = _core.min_rectangle_rotations(np.concatenate(groups), np.cumsum([0, *map(len, groups)]))
    np.testing.assert_allclose(np.abs(turns), 1, rtol=1e-11)
    for z, turn in zip(groups, turns, strict=True):
        assert reference.rectangle(z * turn) == pytest.approx(reference.least_rectangle(z), rel=1e-9)


def test_the_first_of_equivalent_sides_is_chosen():
    grid, five = make_point_groups()[:2]
    start = np.array([0, len(grid), len(grid) + 5])
    turns = _core.min_rectangle_rotations(np.concatenate((grid, five)), start)
    # the first of equivalent sides, clockwise from the lowest corner
    for z, turn in zip((grid, five), turns, strict=True):
        lowest = z[z.imag.argmin()] * turn
        assert lowest.imag == pytest.approx((z * turn).imag.max(), abs=1e-9)
        assert ((z * turn).real[(z * turn).imag > lowest.imag - 1e-9] > lowest.real - 1e-9).all()


def test_collinear_points_are_not_rotated():
    groups = [(2 + 1j) * np.arange(4), np.full(3, 1j), np.ones(1, complex), np.full(5, complex(np.nan, 0))]
    turns = _core.min_rectangle_rotations(np.concatenate(groups), np.cumsum([0, *map(len, groups), 0]))
    np.testing.assert_array_equal(turns, 1)


@pytest.mark.parametrize("seed", range(4))
def test_lines_divide_a_graph_into_parts(seed):
    rng, n = np.random.default_rng(seed), 60
    points, ends, angle = rng.normal(size=(n, 2)), rng.integers(n, size=(90, 2)), rng.uniform(0, 6, 5)
    given = (
        *(points, ends, rng.uniform(size=90), rng.random(n) < 0.5),
        *(np.column_stack((np.cos(angle), np.sin(angle))), np.array([-9, -0.5, 0, 0.5, 9]), FAN),
    )
    made = _core.evaluate_cut_lines(*given)
    np.testing.assert_allclose(np.stack(made), reference.evaluate_cut_lines(*given), rtol=1e-11, atol=1e-11)
