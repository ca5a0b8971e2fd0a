"""Packing again keeps shapes and stacks of charts, and either their sizes or an even texel density."""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pytest
from carried import quads
from test_checking import Map, grid, move_map, place_side_by_side, plane, write_given

from igl_linabf import MeshError, MeshWarning, Packing, check_uv, unwrap
from igl_linabf.cli import main
from igl_linabf.io import read_file
from igl_linabf.uv import pack


def triangular(n: int = 5) -> Map:
    V, F = grid(n)
    F = F[V[F].sum(axis=1)[:, :2].sum(axis=1) < 6]
    return V, F, 0.1 * V[:, :2] + 0.05, F


def fit_motions(given: Map, packed: object) -> dict[int, np.ndarray]:
    """Return the linear part of the affine motion of each chart."""
    _, _, TC, FTC = given
    found = {}
    for i in np.unique(packed.chart[packed.chart >= 0]).tolist():
        rows = packed.chart == i
        old = np.column_stack((TC[FTC[rows]].reshape(-1, 2), np.ones(3 * rows.sum())))
        fit, *_ = np.linalg.lstsq(old, packed.TC[packed.FTC[rows]].reshape(-1, 2), rcond=None)
        assert np.allclose(old @ fit, packed.TC[packed.FTC[rows]].reshape(-1, 2), atol=1e-9)
        found[i] = fit[:2].T
    return found


MAPS = place_side_by_side(
    triangular(), move_map(triangular(), (0.1, 0)), move_map(plane(), (0.0, 0.1), mirrored=True, size=0.3)
)


@pytest.mark.parametrize("rotate", [False, True])
def test_charts_keep_their_shapes_and_sizes_and_none_overlaps(rotate: bool) -> None:
    assert not check_uv(*MAPS).good
    packed = pack(*MAPS, Packing(resolution=256, padding=4), rotate=rotate)
    found = check_uv(*MAPS[:2], packed.TC, packed.FTC, resolution=256, min_margin=4)
    assert found.good, found.troubles
    assert (found.charts, found.report.mirrored) == (3, 1)
    assert found.fill == pytest.approx(packed.fill)
    assert found.report.texel_density.mean == pytest.approx(256 * packed.scale)
    sizes = []
    for linear in fit_motions(MAPS, packed).values():
        size = np.sqrt(np.linalg.det(linear))  # the determinant is positive, so the chart is not mirrored
        assert np.allclose(linear.T @ linear, size**2 * np.eye(2))
        assert rotate or np.allclose(linear, size * np.eye(2))
        sizes.append(size)
    assert np.allclose(sizes, sizes[0])


def test_rotated_charts_fill_more() -> None:
    V, F, TC, FTC = place_side_by_side(triangular(), triangular())
    free, fixed = (pack(V, F, TC + 0.0 * FTC.max(), FTC, rotate=turns) for turns in (True, False))
    assert free.fill >= fixed.fill


def test_even_charts_have_one_texel_density() -> None:
    kept, even = (pack(*MAPS, scale=scale) for scale in ("keep", "even"))
    spreads = [check_uv(*MAPS[:2], p.TC, p.FTC) for p in (kept, even)]
    assert spreads[0].report.texel_density.most > 2 * spreads[0].report.texel_density.least
    assert spreads[1].report.texel_density.most == pytest.approx(spreads[1].report.texel_density.least)
    with pytest.raises(ValueError, match="packing is 1024"):
        pack(*MAPS, 1024)
    with pytest.raises(ValueError, match="scale is 'same'"):
        pack(*MAPS, scale="same")


def test_stacks_are_kept_and_shared_rows_are_separated() -> None:
    V, F = grid()
    TC = np.column_stack(
        (0.1 + 0.2 * np.abs(V[:, 0] - 1), 0.1 + 0.2 * V[:, 1])
    )  # the map folds one half onto the other
    alone = move_map(plane(), (0.1, 0))
    given = place_side_by_side((V, F, TC, F), alone)
    packed = pack(*given)
    found = check_uv(*given[:2], packed.TC, packed.FTC)
    assert (found.charts, found.report.stacked, found.report.mirrored) == (3, 1, 1)
    assert found.good
    # two surfaces share the rows of TC
    shared = (
        np.concatenate((V, V + np.array([9, 0, 0]))),
        np.concatenate((F, F + len(V))),
        0.1 * V[:, :2],
        np.vstack((F, F)),
    )
    assert check_uv(*shared[:2], *(lambda p: (p.TC, p.FTC))(pack(*shared))).report.stacked == 1


def test_repacked_polygons_remain_polygons() -> None:
    V, F = quads()
    atlas = unwrap(V, F, progress=False)
    packed = pack(V, F, atlas.TC, atlas.FTC)
    assert np.shape(packed.FTC) == np.shape(atlas.FTC)
    assert check_uv(V, F, packed.TC, packed.FTC).good


def test_a_density_uses_as_many_pages_as_needed() -> None:
    given = place_side_by_side(
        *[plane()] * 3, *[move_map(plane(), (0.3, 0))] * 2, move_map(plane(), (0, 0.3))
    )
    packed = pack(*given, Packing(resolution=128, texel_density=40, padding=2))
    found = check_uv(*given[:2], packed.TC, packed.FTC, resolution=128, min_margin=2)
    assert found.good, found.troubles
    assert packed.pages == found.pages == 3  # three stacks fill one page each
    assert found.report.texel_density.mean == pytest.approx(40)
    with pytest.raises(MeshError, match=r"do not fit on a page .*use a smaller density"):
        pack(*given, Packing(resolution=128, texel_density=80, padding=2))


def test_charts_without_area_or_coordinates_are_reported() -> None:
    V, F, TC, FTC = MAPS
    FTC = FTC.copy()
    FTC[0] = -1
    degenerate = np.vstack((F, [[0, 0, 1]]))
    packed = pack(V, degenerate, TC, np.vstack((FTC, [[0, 0, 1]])))
    assert (packed.FTC[0] == -1).all()
    assert (packed.FTC[1:] >= 0).all()
    point = np.vstack((TC, [[0.5, 0.5]]))
    lost = FTC.copy()
    lost[packed.chart[: len(F)] == 2] = len(TC)
    with pytest.warns(MeshWarning, match="have no area in the map and are left"):
        packed = pack(V, F, point, lost)
    assert len(np.unique(packed.TC[packed.FTC[lost[:, 0] == len(TC)]].reshape(-1, 2), axis=0)) == 1
    with pytest.raises(MeshError, match="no face has texture coordinates with an area"):
        pack(V, F, TC * 0, FTC)


def test_the_command_writes_the_repacked_mesh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_given(tmp_path / "given.obj", MAPS)
    arguments = [
        "pack",
        str(tmp_path / "given.obj"),
        "-o",
        str(tmp_path / "packed.obj"),
        "--resolution",
        "256",
    ]
    assert main([*arguments, "--padding", "4", "--no-rotate", "--scale", "even"]) == 0
    assert "3 charts on 1 page" in capsys.readouterr().out
    made = read_file(tmp_path / "packed.obj")
    assert np.allclose(made.V, MAPS[0])
    found = check_uv(made.V, made.F, made.TC, made.FTC, resolution=256, min_margin=3.99)
    assert found.good, found.troubles
    assert found.report.texel_density.most == pytest.approx(found.report.texel_density.least, rel=1e-4)
    igl.write_triangle_mesh(str(tmp_path / "plain.obj"), *MAPS[:2])
    assert main(["pack", str(tmp_path / "plain.obj"), "-o", str(tmp_path / "out.obj")]) == 2
    assert not (tmp_path / "out.obj").exists()


def test_charts_on_different_images_are_packed_apart() -> None:
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], dtype=float)
    F, TC = np.arange(6).reshape(2, 3), V[:3, :2]
    for labels, stacked in ((None, 1), (["wood", "wood"], 1), (["wood", "steel"], 0)):
        packed = pack(V, F, TC, [[0, 1, 2], [0, 1, 2]], labels=labels)
        check = check_uv(V, F, packed.TC, packed.FTC)
        assert (check.report.stacked, check.good) == (stacked, True)
