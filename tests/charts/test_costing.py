"""The three terms of the cost of an atlas, in one unit."""

import igl
import numpy as np
import pytest
from hard_surfaces import box, rounded_box

from igl_linabf import ChartOptions, Packing, find_seams, unwrap
from igl_linabf.charts import pack_together
from igl_linabf.charts.cut_graphs import ISOMETRIC_STRETCH_WEIGHT

PACKED = Packing(resolution=256)


@pytest.fixture(scope="module")
def ball():
    """Return a bumpy ball, and seams that open it."""
    V, F = igl.upsample(*igl.icosahedron(), 2)
    V = V / np.linalg.norm(V, axis=1)[:, None] * (1 + 0.2 * np.sin(4 * V[:, :1]))
    return V, F, find_seams(V, F)


def size(V, F):
    return np.sqrt(igl.doublearea(V, F).sum() / 2)


def length(V, edges):
    return np.linalg.norm(np.subtract(*V[edges.T]), axis=1).sum()


def test_the_net_of_a_cube_has_no_stretch_and_seven_sharp_seams():
    V, F = box(1, 1, 1)
    cost = unwrap(V, F, find_seams(V, F), charts=ChartOptions(trade=2.0)).cost
    assert cost.stretch == pytest.approx(0, abs=1e-9)
    assert cost.seams == pytest.approx(7 * 0.5 * 0.15 / np.sqrt(6) / 2.0)  # seven sharp edges at right angles
    assert cost.page > 0


@pytest.mark.parametrize("degrees", [0, 30, 90, 120])
def test_a_seam_counts_less_along_a_crease(degrees):
    angle = np.deg2rad(degrees)
    V = np.array([[0, 0, 0], [0, 3, 0], [-1, 0, 0], [-1, 3, 0], [np.cos(angle), 0, np.sin(angle)]])
    V = np.vstack((V, V[4] + [0, 3, 0]))
    F = np.array([[0, 1, 2], [1, 3, 2], [0, 4, 1], [4, 5, 1]])
    cost = unwrap(V, F, [[0, 1]], charts=ChartOptions(trade=1.0)).cost
    # on a body with planes, creases are sharp from 40 degrees on and smooth below 15 degrees
    sharpness = np.clip((degrees - 15) / 25, 0, 1)
    price = (1 - 0.5 * min(degrees / 90, 1)) * (1 - 0.85 * sharpness)
    assert cost.seams == pytest.approx(3 * price / np.sqrt(6))


def test_a_seam_in_the_middle_of_a_fillet_costs_as_little_as_along_a_sharp_crease():
    V, F = rounded_box(3, 2, 1, 0.1)  # each edge of a fillet bends by less than 6 degrees
    atlas = unwrap(V, F, charts=ChartOptions(trade=1.0))
    price = atlas.cost.seams * size(V, F) / atlas.seam_length
    assert 0.5 * 0.15 - 1e-9 <= price < 0.25


def test_large_angles_of_a_body_without_planes_are_not_sharp_creases():
    V, F = igl.icosahedron()
    seams = find_seams(V, F)
    price = 1 - np.arccos(np.sqrt(5) / 3) / np.pi  # faces of an icosahedron meet at an angle of 42 degrees
    cost = unwrap(V, F, seams, charts=ChartOptions(trade=1.0)).cost
    assert cost.seams == pytest.approx(price * length(V, seams) / size(V, F))


def test_no_term_depends_on_the_size_of_the_surface(ball):
    V, F, seams = ball
    cost, large = (unwrap(k * V, F, seams).cost for k in (1, 1000.0))
    assert [cost.stretch, cost.seams, cost.page] == pytest.approx([large.stretch, large.seams, large.page])


def test_trade_weighs_the_seams_alone(ball):
    V, F, seams = ball
    dear, cheap = (unwrap(V, F, seams, charts=ChartOptions(trade=trade)).cost for trade in (2, 8))
    assert dear.seams == pytest.approx(4 * cheap.seams)
    assert (dear.stretch, dear.page) == (cheap.stretch, cheap.page)
    assert np.isinf(unwrap(V, F, seams, charts=ChartOptions(trade=0)).cost.total)


def test_the_cost_is_the_sum_of_its_terms_and_is_printed(ball):
    V, F, seams = ball
    atlas = unwrap(V, F, seams, method="linabf")
    cost = atlas.cost
    assert cost.stretch == pytest.approx(atlas.quality.stretch_l2 - 1)
    assert cost.page == pytest.approx(1 / atlas.fill - 1)
    assert cost.total == cost.stretch + cost.seams + cost.page
    assert f"stretch {cost.stretch:.3g}, seams {cost.seams:.3g}, page {cost.page:.3g}" in str(atlas)


def test_isometric_stretch_counts_as_in_the_search_for_seams(ball):
    V, F, seams = ball
    atlas = unwrap(V, F, seams, method="isometric")
    assert atlas.cost.stretch == pytest.approx(ISOMETRIC_STRETCH_WEIGHT * (atlas.quality.stretch_l2 - 1))


def test_hidden_seams_cost_a_third_and_seen_ones_three_times_as_much(ball):
    V, F, seams = ball
    near = np.isin(F, seams).any(axis=1)
    plain, hidden, seen = (
        unwrap(V, F, seams, charts=ChartOptions(hide=hide)).cost.seams
        for hide in (None, near * 1.0, ~near * 1.0)
    )
    assert [3 * hidden, seen / 3] == pytest.approx([plain, plain])


@pytest.mark.filterwarnings("ignore:.*in addition to the given seams:igl_linabf.FallbackWarning")
def test_the_cost_of_several_components_is_their_mean_by_area(ball):
    V, F, seams = ball
    n = len(V)
    small = 0.5 * V[:, [1, 2, 0]] + 5  # a quarter of the area of the ball
    more = np.delete(seams, 0, axis=0)
    alone = unwrap(V, F, seams).cost
    other = unwrap(small, F, more).cost
    both = unwrap(np.vstack((V, small)), np.vstack((F, F + n)), np.vstack((seams, more + n))).cost
    assert both.stretch == pytest.approx((4 * alone.stretch + other.stretch) / 5)
    assert both.seams == pytest.approx((4 * alone.seams + other.seams) / 5)


def test_atlases_on_common_pages_share_the_waste(ball):
    V, F, seams = ball
    packed = pack_together([unwrap(k * V, F, seams) for k in (1, 2)], PACKED)
    for atlas in packed:
        assert atlas.cost.page == pytest.approx(1 / sum(other.fill for other in packed) - 1)
