"""The demos run as the README describes, and the numbers that they print are right."""

from __future__ import annotations

import re
from pathlib import Path

import igl
import numpy as np
import pytest
import pyvista as pv
from conftest import FOLDER, ROOT, load, read_pixels
from pixels import measure_colour_share
from scripts_of_repo import run

from igl_linabf.flattening import other_programs as peers
from igl_linabf.plot import MARK, WARNING


def read_row(text: str, label: str) -> list[float]:
    """Return the numbers of the table row that starts with `label`, without columns of other programs."""
    lines = text.splitlines()
    i = next(i for i, line in enumerate(lines) if line.startswith(label))
    values = [float(v.replace(",", "")) for v in re.split(r"\s{2,}", lines[i])[1:]]
    heads = [re.split(r"\s{2,}", line.strip()) for line in lines[:i] if line.startswith("  ")]
    names = heads[-1] if heads and len(heads[-1]) == len(values) else [""] * len(values)
    return [value for name, value in zip(names, values, strict=True) if name not in peers.PEERS]


@pytest.mark.slow
def test_the_cortex_demo_writes_maps_in_millimetres(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "cortex.py")
    assert read_row(text, "triangles") == [18654] * 4
    assert read_row(text, "flipped")[:3] == [0, 0, 0]
    lscm, ours, isometric, shipped = read_row(text, "angle distortion")
    assert ours <= 2.54e-3 * 1.02
    assert ours < lscm < isometric < shipped
    V, coordinates, _, F, corners, _ = igl.readOBJ(str(tmp_path / "out" / "cortex.obj"))
    assert F.shape == corners.shape == (18654, 3)
    assert coordinates.min() == 0
    assert coordinates.max() == 1
    assert (igl.doublearea(np.ascontiguousarray(coordinates[:, :2]), corners) > 0).all()
    assert np.isclose(np.ptp(V, axis=0).max(), 170, atol=10)  # the size of a cortex in millimetres
    maps = 4 + len(peers.list_installed_programs())
    assert read_pixels(tmp_path / "out" / "cortex.png").shape[:2] == (700 * maps, 1400)


def test_compare_lscm_on_any_mesh(tmp_path) -> None:
    igl.write_triangle_mesh(str(tmp_path / "bumps.ply"), *load("bumps"))
    text = run(tmp_path, ROOT / "demos" / "compare_lscm.py", "bumps.ply", "pictures")
    lscm, ours, abf = read_row(text, "angle distortion")
    assert abf <= ours <= lscm
    assert sorted(p.name for p in (tmp_path / "pictures").iterdir()) == ["bumps.obj", "bumps.png"]


def find_rows_with_flips(picture: Path) -> list[bool]:
    """Return, for each row of a comparison, whether flipped triangles are drawn in their colour."""
    image = read_pixels(picture)[:, 700:, :3].astype(int)
    red = np.abs(image - pv.Color(WARNING).int_rgb).sum(axis=2) < 12
    return [part.sum() > 200 for part in np.split(red, len(image) // 700)]


@pytest.mark.slow
def test_lscm_flips_the_obtuse_disk_and_linear_abf_agrees_with_abf(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "obtuse.py")
    for method in ("lscm", "dncp", "scp"):
        assert f"{method:8} flipped triangles with each pair of pins: [1, 1, 1]" in text
    assert re.search(r"linABF +flipped triangles: 0; from ABF at most 0\.07 degrees", text)
    assert find_rows_with_flips(tmp_path / "out" / "obtuse.png") == [True, True, True, False, False]


@pytest.mark.slow
def test_the_second_iteration_removes_the_flip_of_the_first(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "second_iteration.py")
    flips = [line.split()[2] for line in text.splitlines() if re.match(r" +[123] ", line)]
    assert flips == ["1", "0", "0"]
    assert "by default: 0 flipped" in text
    assert find_rows_with_flips(tmp_path / "out" / "second_iteration.png") == [True, False, False]


@pytest.mark.slow
def test_high_curvature_flips_lscm_but_not_linear_abf(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "high_curvature.py")
    spiky, crown = text.split("crown: ")
    assert read_row(spiky, "flipped") == [0, 0, 0]
    assert read_row(crown, "flipped")[0] > 0
    assert read_row(crown, "flipped")[1:] == [0, 0]
    assert find_rows_with_flips(tmp_path / "out" / "spiky.png")[:3] == [False] * 3


@pytest.mark.slow
def test_holes_close_without_cuts(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "holes.py")
    assert read_row(text, "flipped")[0] > 0
    assert read_row(text, "flipped")[1:] == [0, 0]
    holes = [line.split() for line in text.splitlines() if re.match(r" +\d+ +(20|24)  ", line)]
    assert len(holes) == 7
    assert all(float(value) < 1e-8 for line in holes for value in line[5:])
    assert any(float(line[4]) > 1e-2 for line in holes)  # the loops are still open after one step
    assert find_rows_with_flips(tmp_path / "out" / "holes.png")[1:3] == [False, False]


@pytest.mark.slow
def test_a_nut_has_a_net_and_the_bunny_hides_its_seams(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "hidden_seams.py")
    assert re.search(r"nut: \d charts, L2 stretch 1\.0", text)
    seen = [int(share) for share in re.findall(r"(\d+)% of them seen", text)]
    assert seen[1] < seen[0] / 2
    picture = read_pixels(tmp_path / "out" / "hidden_seams.png").astype(int)
    red = (picture[..., 0] > 200) & (picture[..., 1:3].max(axis=-1) < 80)
    middle = picture.shape[1] // 2
    anywhere, hidden = (red[middle:, :middle].sum(), red[middle:, middle:].sum())
    assert red[:middle, :middle].sum() > 0
    assert 0 < hidden < anywhere / 2


@pytest.mark.slow
def test_the_bunny_unwraps_at_three_trades(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "seams_bunny.py")
    parts = text.split("trade ")[1:]
    figures = [
        re.search(r"seams ([\d.]+) of.*\nall +[\d,]+ +(\S+) +(\S+) +(\d+) +(\d+)", p, re.S) for p in parts
    ]
    seams, distortion, stretch, flips, pairs = np.array([m.groups() for m in figures], dtype=float).T
    assert (np.diff(seams) > 0).all()
    assert (np.diff(stretch) < 0).all()
    assert (distortion <= 1.5e-4).all()
    assert (stretch <= 1.5).all()
    assert (flips == 0).all()
    assert (pairs == 0).all()
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        f"seams_bunny.{suffix}" for suffix in ("glb", "obj", "png")
    ]


@pytest.mark.slow
def test_the_baked_texture_shows_the_details_of_the_fine_model(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "baking.py")
    assert "differ by" in text
    picture = read_pixels(tmp_path / "out" / "baking.png")[..., :3].astype(int)
    assert picture.shape[:2] == (700, 2100)
    colourful = np.ptp(picture, axis=2) > 40
    plain, texture, dressed = (part.mean() for part in np.split(colourful, 3, axis=1))
    assert plain < 0.01
    assert texture > 0.2
    assert dressed > 0.1


@pytest.mark.slow
def test_the_isometric_map_has_even_texels_on_the_same_few_seams(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "even_texels.py")
    found = re.findall(
        r", (\w+): texels ([\d.]+) : 1, (\d+) charts, L2 stretch ([\d.]+), (\d+) flipped", text
    )
    assert {flips for *_, flips in found} == {"0"}
    for name, spread, charts, stretch, _ in found:
        if name != "xatlas":
            assert int(charts) <= 4
            assert (float(spread) < 3) == (float(stretch) < 1.06) == (name == "isometric")
    picture = read_pixels(tmp_path / "out" / "even_texels.png")[..., :3].astype(int)
    assert (np.abs(picture - pv.Color(WARNING).int_rgb).sum(axis=2) < 12).sum() == 0
    assert picture.shape[0] == 1000


@pytest.mark.slow
def test_charts_share_no_texel_and_pages_hold_two_surfaces(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "packing.py")
    found = re.findall(r"(.+): (\d+)% covered, (\d+) texels shared", text)
    assert [name for name, *_ in found][:3] == ["padding 2", "padding 12", "two surfaces"]
    near, apart = (int(share) for _, share, _ in found[:2])
    assert near > apart  # more padding leaves less space for charts
    picture = read_pixels(tmp_path / "out" / "packing.png")[..., :3].astype(int)
    assert (np.abs(picture - pv.Color(WARNING).int_rgb).sum(axis=2) < 12).sum() == 0
    parts = [part for row in np.split(picture, 2) for part in np.split(row, 3, axis=1)]
    # charts are coloured, the background is not
    shown = [(np.ptp(part, axis=2) > 20).mean() for part in parts]
    for (_, share, _), seen in zip(found, shown, strict=True):
        assert abs(seen - 0.8 * int(share) / 100) < 0.06  # a page covers 0.8 of its panel in the picture


@pytest.mark.slow
def test_pins_flip_triangles_in_least_squares_and_none_in_the_isometric_map(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "pins.py")
    found = re.findall(r"^(.+): (\d+) flipped, pins at most (\S+) mm away", text, re.M)
    flips, off = ({name: float(row[k]) for name, *row in found} for k in (0, 1))
    assert flips["least squares"] > 0 == flips["free"] == flips["isometric"]
    assert off["free"] > 10 > 1e-3 > max(off["least squares"], off["isometric"])
    image = read_pixels(tmp_path / "out" / "pins.png")[..., :3].astype(int)
    dots = np.abs(image - pv.Color(MARK).int_rgb).max(axis=2) < 60
    assert min(part.sum() for part in np.split(dots, 3, axis=1)) > 14 * 20


@pytest.mark.slow
def test_the_boundaries_are_a_circle_and_a_rectangle(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "boundaries.py")
    assert len(re.findall(r", 0 flipped", text)) == 6
    for name in ("face", "sleeve"):
        picture = read_pixels(tmp_path / "out" / f"{name}_shapes.png")[..., :3].astype(int)
        assert (np.abs(picture - pv.Color(WARNING).int_rgb).sum(axis=2) < 12).sum() == 0
        coloured = (picture.min(axis=2) < 200)[510:]  # the maps are in the lower row of the picture
        circle, rectangle = (coloured[:, k * 500 : (k + 1) * 500].nonzero() for k in (1, 2))
        height, width = (np.ptp(part) + 1 for part in circle)
        assert abs(height - width) <= 4  # the boundary is a circle; half of the checkerboard is blue
        share = len(rectangle[0]) / np.prod([np.ptp(part) + 1 for part in rectangle])
        assert 0.4 < share < 0.62


@pytest.mark.slow
def test_greedy_layout_breaks_far_from_its_seed_and_least_squares_does_not(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "greedy.py")
    one, converged = text.split("converged\n")
    assert "298,464 triangles" in one
    flips = [int(line.split()[1]) for line in one.splitlines() if re.match(r" +\d+  ", line)]
    assert flips[0] < 0.01 * flips[-1]
    assert "greedy: F/3nt 0.000215, 0 flipped; least squares: F/3nt 0.000215, 0 flipped" in converged
    assert read_pixels(tmp_path / "out" / "greedy.png").shape[:2] == (1400, 1400)


@pytest.mark.slow
def test_stretch_of_linear_abf_is_that_of_abf(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "stretch.py")
    models = [name for name in ("horse", "dino", "bunny") if f"\n{name}, " in text]
    assert "bunny" in models
    for name in ("horse", "dino"):  # each model is either measured or reported as missing
        there = FOLDER is not None and any(Path(FOLDER).glob(f"*{name}*"))
        assert (f"\n{name}, " in text) == there
        assert (f"{name}: no such file" in text) == (not there)
    for name in models:
        part = text.split(f"\n{name}, ")[1]
        lscm, one, ours, abf = (
            read_row(part, label) for label in ("igl.lscm", "linABF, one", "linABF ", "ABF")
        )
        assert one[2] == ours[2] == abf[2] == 0
        assert abs(one[0] / abf[0] - 1) < 0.01
        assert abf[0] < ours[0] * 1.001 < lscm[0]
        assert abf[1] <= ours[1] <= lscm[1]


@pytest.mark.slow
def test_the_checkerboards_have_no_flips_and_show_seams(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "checkerboards.py")
    assert len(re.findall(r" 0 flipped", text)) == 6
    picture = tmp_path / "out" / "checkerboards.png"
    assert min(measure_colour_share(picture, 2, 3)) > 15
    seams = [
        int((part[60:, :, :3].astype(int).max(axis=2) < 32).sum())
        for row in np.split(read_pixels(picture), 2)
        for part in np.split(row, 3, axis=1)
    ]
    assert min(seams[4:]) > 1000  # seams are drawn on the closed surfaces
    assert min(seams[4:]) > 2 * max(seams[1:4])


@pytest.mark.slow
def test_angle_error_shrinks_by_two_orders(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "angle_error.py")
    before, after = (float(m) for m in re.findall(r"median (\S+)", text))
    assert after < 0.01 * before
    lscm, ours = (float(m) for m in re.findall(r"F/3nt ([\d.]+),", text))
    assert ours < lscm
    picture = read_pixels(tmp_path / "out" / "angle_error.png")[:560, :, :3].astype(int)
    bright = [((p[..., 1] > 150) & (p[..., 2] < 120)).mean() for p in np.split(picture, 2, axis=1)]
    assert bright[0] > 5 * bright[1]  # after flattening, only the colour bar is green and yellow


@pytest.mark.slow
def test_quads_have_nearly_right_angles_and_are_written(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "quads.py")
    found = re.findall(r"(\w+): ([\d,]+) faces, (\d+)% quads, angles ([\d.]+) \+-([\d.]+)", text)
    assert [name for name, *_ in found] == ["cortex", "holes", "double_torus"]
    for name, faces, share, mean, off in found:
        written = (tmp_path / "out" / f"quads_{name}.obj").read_text().splitlines()
        corners = [len(line.split()) - 1 for line in written if line.startswith("f ")]
        assert len(corners) == int(faces.replace(",", ""))
        assert corners.count(4) >= int(share) / 100 * len(corners)
        assert abs(float(mean) - 90) < 2
        assert float(off) < 6
    assert min(measure_colour_share(tmp_path / "out" / "quads.png", 3, 2)) > 8


@pytest.mark.slow
def test_the_window_demo_writes_a_picture_without_a_display(tmp_path, monkeypatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    text = run(tmp_path, ROOT / "demos" / "interactive.py")
    assert "linABF: F/3nt 0.00254" in text
    image = read_pixels(tmp_path / "out" / "interactive.png")[..., :3].astype(int)
    marked = np.abs(image - pv.Color(MARK).int_rgb).max(axis=2) < 12
    assert min(half.sum() for half in np.split(marked, 2, axis=1)) > 100


@pytest.mark.slow
def test_timing_prints_a_ratio_for_each_mesh(tmp_path) -> None:
    igl.write_triangle_mesh(str(tmp_path / "bumps.off"), *load("bumps"))
    text = run(tmp_path, ROOT / "benchmarks" / "timing.py", "--repeat", 1, "bumps.off")
    assert re.search(r"^\| bumps \| [\d,]+ \| \*\*[\d.]+\*\* \|", text, re.MULTILINE)
    assert "CHOLMOD" in text


@pytest.mark.slow
def test_a_weave_continues_across_the_seam_between_quarter_cones(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "cones_bunny.py")
    figures = re.findall(r"differ by ([\d.]+)% in length and (\S+) degrees\nF/3nt (\S+),", text)
    matched, free = np.array(figures, dtype=float)
    assert matched[0] == 0 and matched[1] < 1e-4
    assert free[0] > 1 and free[1] > 20
    assert matched[2] < 1e-3
    image = read_pixels(tmp_path / "out" / "cones_bunny.png")
    assert (
        np.unique(image[1400:, :750].reshape(-1, image.shape[2]), axis=0).shape[0] > 1000
    )  # the two sides of each seam have colours


@pytest.mark.slow
def test_quadrangles_survive_in_files_and_seams_are_not_diagonals(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "polygons.py")
    assert " 0 of them diagonals" in text
    for suffix in ("obj", "ply", "glb"):
        assert f"out/polygons.{suffix}: 1,440 faces of 4 corners" in text
    assert min(measure_colour_share(tmp_path / "out" / "polygons.png", 1, 2)) > 5


@pytest.mark.slow
def test_patterns_are_drawn_beside_their_surfaces(tmp_path) -> None:
    text = run(tmp_path, ROOT / "demos" / "pattern.py")
    assert "edges change by 0.00% at most" in text  # the lampshade is a cone, which is developable
    assert len(re.findall(r"^[1-6] +\d \d +4\d\d\.", text, re.M)) == 6  # the six seams of the bodice
    for name in ("lampshade", "bodice"):
        for suffix in ("svg", "dxf", "pdf"):
            assert (tmp_path / "out" / f"{name}.{suffix}").stat().st_size > 1500
    image = read_pixels(tmp_path / "out" / "pattern.png")[..., :3].astype(int)
    drawn = image[:, image.shape[1] // 2 :].sum(axis=2) < 720
    assert all(half.sum() > 1000 for half in np.split(drawn, 2))
