"""Flat segments keep lengths, orientation and direction; segments that cannot be flattened are refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.ndimage

from igl_linabf import MeshError, MeshWarning, quality
from igl_linabf._types import FloatArray
from igl_linabf.io import Segment, write_tifxyz
from igl_linabf.scrolls import FlatSegment, flatten_segment, synthetic_segment

STEP = 20.0


def make_cylinder(rows: int = 30, columns: int = 50, radius: float = 400.0) -> Segment:
    """Return an exact cylinder around z, whose z falls along the rows of the grid."""
    row, column = np.mgrid[:rows, :columns].astype(float)
    turn = STEP * column / radius
    chord = 2 * radius * np.sin(STEP / radius / 2)  # the height of the rows, which makes the cells squares
    points = np.stack((radius * np.cos(turn), radius * np.sin(turn), 100 + chord * (rows - row)), axis=2)
    points[..., :2] += 1000
    return Segment(points, (1 / chord, 1 / chord), {"uuid": "cylinder"})


@pytest.fixture(scope="module")
def flat() -> FlatSegment:
    return flatten_segment(synthetic_segment(60, 160))


def distances(points: FloatArray, axis: int) -> FloatArray:
    length = np.linalg.norm(np.diff(points, axis=axis), axis=2)
    return np.asarray(length[np.isfinite(length)])


@pytest.mark.parametrize("method", ["isometric", "linabf"])
def test_a_cylinder_is_flattened_to_its_own_grid(method: str) -> None:
    given = make_cylinder()
    flat = flatten_segment(given, method=method)
    shape = flat.segment.points.shape
    assert all(n - 1 <= m <= n for n, m in zip(given.points.shape, shape, strict=True))
    for axis in (0, 1):
        np.testing.assert_allclose(distances(flat.segment.points, axis), 1 / given.scale[0], rtol=1e-3)
    assert (np.diff(flat.segment.points[..., 2], axis=0) < 0).all()
    assert flat.report.stretch_l2 == pytest.approx(1, abs=1e-6)
    assert flat.report.area == pytest.approx(29 * 49 / given.scale[0] ** 2)


def test_the_synthetic_segment_keeps_lengths_without_flips(flat: FlatSegment) -> None:
    report = flat.report
    assert (report.flips, report.overlaps) == (0, 0)
    assert report.stretch_l2 < 1.01 and report.area_error < 0.02
    for axis in (0, 1):
        assert np.median(distances(flat.segment.points, axis)) == pytest.approx(STEP, rel=0.01)
    assert [repair.kind for repair in report.repairs] == ["collapsed"]


def test_figures_are_those_of_quality(flat: FlatSegment) -> None:
    measured = quality(flat.V, flat.F, flat.uv)
    assert flat.report.stretch_l2 == pytest.approx(measured.stretch_l2, rel=1e-9)
    assert flat.report.stretch_linf == pytest.approx(measured.stretch_linf, rel=1e-9)
    flat_corners = np.column_stack((flat.uv, np.zeros(len(flat.uv))))[flat.F]
    a, b = (
        np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
        for x in (flat.V[flat.F], flat_corners)
    )
    a, b = a / a.sum(), b / b.sum()
    assert flat.report.area_error == pytest.approx((1 - np.minimum(a / b, b / a)).mean(), abs=1e-6)


def test_every_given_point_has_coordinates_and_holes_stay(flat: FlatSegment) -> None:
    given = synthetic_segment(60, 160)
    inside = flat.index >= 0
    assert not (inside & ~given.valid).any()
    np.testing.assert_allclose(flat.V[flat.index[inside]], given.points[inside])
    equal = (given.points[:, 1:] == given.points[:, :-1]).all(axis=2)
    assert equal.any()
    np.testing.assert_array_equal(flat.index[:, 1:][equal], flat.index[:, :-1][equal])
    _, holes = scipy.ndimage.label(~flat.segment.valid, structure=np.ones((3, 3)))
    assert holes > 3


def test_points_of_the_flat_grid_lie_on_the_surface(flat: FlatSegment) -> None:
    """Each vertex is near the point of the segment at its row and column in the map."""
    rows = flat.segment.points.shape[0]
    u, v = flat.uv.T
    column, row = u / STEP, rows - 1 - v / STEP
    near = np.rint(np.column_stack((row, column))).astype(int)
    inside = ((near >= 0) & (near < flat.segment.points.shape[:2])).all(axis=1)
    found = flat.segment.points[tuple(near[inside].T)]
    gap = np.linalg.norm(found - flat.V[inside], axis=1)
    assert np.nanmax(gap) < STEP


@pytest.mark.parametrize("reverse", [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_the_axis_points_up_and_nothing_is_mirrored(reverse: tuple[int, int]) -> None:
    given = make_cylinder()
    turned = replace(given, points=given.points[:: reverse[0], :: reverse[1]])
    z = {up: flatten_segment(turned, up=up).segment.points for up in ("axis", "rows")}
    assert (np.diff(z["axis"][..., 2], axis=0) < 0).all()
    assert (np.sign(np.diff(z["rows"][..., 2], axis=0)) == -reverse[0]).all()
    for points in (turned.points, *z.values()):
        across, down = points[1:, 1:] - points[1:, :-1], points[1:, 1:] - points[:-1, 1:]
        outward = np.cross(across, down) @ np.array([0, 0, 0.0]) + (
            np.cross(across, down)[..., :2] * (points[1:, 1:, :2] - 1000)
        ).sum(axis=2)
        assert (np.sign(outward) == -reverse[0] * reverse[1]).all()


def test_pieces_are_left_out_or_stand_side_by_side() -> None:
    given = synthetic_segment(60, 160)
    one, two = (flatten_segment(given, pieces=n) for n in (1, 2))
    assert len(one.report.left_out) >= 1
    assert two.report.faces == one.report.faces + one.report.left_out[0]
    assert two.report.overlaps == 0
    assert two.segment.points.shape[1] > one.segment.points.shape[1]
    assert np.nanmin(two.uv[:, 0]) >= -STEP


@pytest.mark.parametrize("scale", [(20, 20), (0.05, 20), (0.0005, 0.0005)])
def test_a_wrong_scale_is_refused_with_numbers(scale: tuple[float, float]) -> None:
    with pytest.raises(MeshError, match=r"median distance is .* would have .* points .*perhaps to \[0\.0"):
        flatten_segment(replace(synthetic_segment(40, 60), scale=scale))


def test_segments_without_a_surface_are_refused() -> None:
    given = make_cylinder()
    points = given.points.copy()
    points[::2, ::2] = np.nan
    with pytest.raises(MeshError, match="no cell with four valid points"):
        flatten_segment(replace(given, points=points))
    with pytest.raises(ValueError, match="up is 'left'"):
        flatten_segment(given, up="left")
    with pytest.raises(ValueError, match="pieces is 0"):
        flatten_segment(given, pieces=0)


def test_channels_and_meta_data_follow_the_surface(tmp_path: Path) -> None:
    given = make_cylinder()
    z = given.points[..., 2]
    channels = {
        "height": z.astype(np.float32),
        "label": (z > z.mean()).astype(np.uint8),
        "colour": np.stack((z, 2 * z, 3 * z), axis=2).astype(np.float32),
        "other": np.zeros((3, 4)),
    }
    write_tifxyz(tmp_path / "given", replace(given, channels=channels, meta={"area_cm2": 2.5}))
    with pytest.warns(MeshWarning, match="channels other"):
        flat = flatten_segment(tmp_path / "given").segment
    valid = flat.valid
    np.testing.assert_allclose(flat.channels["height"][valid], flat.points[valid][:, 2], rtol=1e-5)
    np.testing.assert_allclose(flat.channels["colour"][valid][:, 2], 3 * flat.points[valid][:, 2], rtol=1e-5)
    assert flat.channels["label"].dtype == np.uint8 and set(np.unique(flat.channels["label"])) == {0, 1}
    assert "other" not in flat.channels
    assert flat.meta["area_cm2"] == 2.5
    assert flat.meta["flattened_from"]["uuid"] == "given"


def test_large_holes_are_not_filled_and_not_cut() -> None:
    given = make_cylinder(90, 120)
    given.points[10:75, 20:80] = np.nan
    flat = flatten_segment(given)
    assert flat.report.flips == 0 and flat.report.stretch_l2 == pytest.approx(1, abs=1e-4)
    assert np.isnan(flat.segment.points[20:65, 30:70]).all()
