"""`check_uv` tells flips and accidental overlaps from mirrored and stacked charts."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import igl
import numpy as np
import pytest
from carried import quads
from gltf_files import write_glb
from nasty_meshes import NASTY

from igl_linabf import MeshError, MeshWarning, Packing, check_uv, quality, unwrap
from igl_linabf.cli import main
from igl_linabf.io import write_textured
from igl_linabf.measures import overlapping
from igl_linabf.uv import uv_charts

Map = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def grid(n: int = 6, side: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """Return a square of n x n cells of two triangles."""
    x, y = (k.ravel() for k in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    V = np.column_stack((x, y, 0 * x)) * side / n
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a = i * (n + 1) + j
    b = a + n + 1
    return V, np.concatenate((np.column_stack((a, b, b + 1)), np.column_stack((a, b + 1, a + 1))))


def plane(n: int = 6) -> Map:
    """Return a square of side 2, mapped to the lower left of the page at a tenth of its size."""
    V, F = grid(n)
    return V, F, 0.1 * V[:, :2] + 0.05, F


def place_side_by_side(*maps: Map) -> Map:
    """Concatenate surfaces side by side in space; their maps do not move."""
    V, F, TC, FTC = ([m[k] for m in maps] for k in range(4))
    n, t = (np.cumsum([0, *map(len, arrays)]) for arrays in (V, TC))
    return (
        np.concatenate([v + np.array([10 * k, 0, 0]) for k, v in enumerate(V)]),
        np.concatenate([f + n[k] for k, f in enumerate(F)]),
        np.concatenate(TC),
        np.concatenate([f + t[k] for k, f in enumerate(FTC)]),
    )


def move_map(given: Map, by: tuple[float, float] = (0, 0), mirrored: bool = False, size: float = 1.0) -> Map:
    V, F, TC, FTC = given
    TC = TC * [-1, 1] + [0.3, 0] if mirrored else TC
    return V, F, TC * size + by, FTC


def write_given(path: Path, given: Map) -> None:
    V, F, TC, FTC = given
    igl.writeOBJ(str(path), V, F, np.zeros((0, 3)), np.zeros((0, 3), int), TC, FTC)


def test_figures_of_a_plane_are_correct() -> None:
    found = check_uv(*place_side_by_side(plane(), move_map(plane(), (0.3, 0), size=0.5)), resolution=1000)
    assert (found.charts, found.report.mirrored, found.report.stacked, found.flips, found.overlaps) == (
        2,
        0,
        0,
        0,
        0,
    )
    assert (found.report.seams, found.seam_length, found.pages) == (0, 0, 1)
    assert found.fill == pytest.approx(0.04 + 0.01)
    # the first square ends at 0.25, the second one starts at 0.325
    assert found.margin == pytest.approx(75)
    assert found.report.border == pytest.approx(25)
    assert (found.report.texel_density.least, found.report.texel_density.most) == pytest.approx((50, 100))
    assert found.report.texel_density.mean == pytest.approx(1000 * np.sqrt(0.05 / 8))
    assert found.texel_spread == pytest.approx(4)
    assert found.good


def test_figures_on_wide_pages_are_correct() -> None:
    """A square of side 2 covers 0.2 x 0.4 of a page of 1000 x 500 texels, 200 texels in each direction."""
    V, F, TC, FTC = plane()
    wide = TC * [1, 2]
    # the gap above is smaller: 0.04 of 500 texels
    beside, above = ((V, F, wide + by, FTC) for by in ((0.3, 0), (0, 0.44)))
    found = check_uv(*place_side_by_side((V, F, wide, FTC), beside, above), resolution=(1000, 500))
    assert (
        found.report.texel_density.least,
        found.report.texel_density.most,
        found.report.texel_density.mean,
    ) == pytest.approx((100, 100, 100))
    assert found.report.quality.angle_distortion == pytest.approx(0)
    assert (found.margin, found.report.border) == pytest.approx((20, 30))
    assert found.fill == pytest.approx(3 * 0.08)


def test_an_atlas_is_good_and_has_the_figures_of_unwrap() -> None:
    V, F = quads()
    atlas = unwrap(V, F, packing=Packing(resolution=512, padding=6), progress=False)
    found = check_uv(V, F, atlas.TC, atlas.FTC, resolution=512, min_margin=6, max_stretch=1.5)
    assert found.good, found.troubles
    assert (found.charts, found.report.faces, found.report.seams) == (
        len(atlas.charts),
        len(F),
        len(atlas.seams),
    )
    assert found.seam_length == pytest.approx(atlas.seam_length)
    assert found.fill == pytest.approx(atlas.fill)
    assert found.stretch_l2 == pytest.approx(atlas.quality.stretch_l2)
    assert found.report.texel_density.mean == pytest.approx(512 * atlas.report.scale)
    assert len(np.unique(found.report.chart)) == found.charts
    assert "<svg" in found._repr_html_()


def test_equal_coordinates_are_merged() -> None:
    V, F, TC, FTC = plane()
    soup = np.arange(F.size).reshape(F.shape)
    assert check_uv(V, F, TC[FTC].reshape(-1, 2), soup).charts == 1
    assert check_uv(V[F].reshape(-1, 3), soup, TC, FTC).charts == 1
    assert check_uv(V[F].reshape(-1, 3), soup, TC[FTC].reshape(-1, 2), soup).report.seams == 0


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("cells", [6, 9])
def test_charts_on_each_other_are_stacked_and_good(mirrored: bool, cells: int) -> None:
    """Charts can be stacked although their triangles differ."""
    found = check_uv(
        *place_side_by_side(plane(), move_map(plane(cells), mirrored=mirrored), move_map(plane(), (0.4, 0)))
    )
    assert (found.charts, found.report.stacked, found.report.mirrored) == (3, 1, int(mirrored))
    assert (found.flips, found.overlaps) == (0, 0)
    assert found.good
    assert found.fill == pytest.approx(0.08)


def test_halves_that_share_their_coordinates_are_a_mirrored_chart_each() -> None:
    V, F = grid()
    TC = np.column_stack((0.1 + 0.2 * np.abs(V[:, 0] - 1), 0.1 + 0.2 * V[:, 1]))  # folded along its middle
    found = check_uv(V, F, TC, F)
    assert (found.charts, found.report.mirrored, found.report.stacked, found.flips, found.overlaps) == (
        2,
        1,
        1,
        0,
        0,
    )
    assert found.good


def test_flipped_and_collapsed_faces_are_named() -> None:
    V, F, TC, FTC = plane()
    middle = int(np.flatnonzero(np.isclose(V[:, :2], 1).all(axis=1))[0])
    TC = TC.copy()
    TC[middle] += [0.05, 0]
    found = check_uv(V, F, TC, FTC)
    sign = igl.doublearea(TC, FTC)
    a, b, c = TC[FTC.transpose()]
    e, f = b - a, c - a
    sign = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
    assert found.flipped.tolist() == np.flatnonzero(sign < 0).tolist()
    assert found.flips > 0
    assert found.overlaps > 0  # flipped faces overlap their neighbours
    assert (found.charts, found.report.mirrored) == (1, 0)
    assert "are flipped or collapsed in the map" in found.troubles[0]
    mirror = check_uv(V, F, TC * [-1, 1] + [1, 0], FTC)  # the same faces in a mirrored chart
    assert (mirror.report.mirrored, mirror.flipped.tolist()) == (1, found.flipped.tolist())
    TC[middle] = TC[middle + 1]
    assert set(check_uv(V, F, TC, FTC).flipped.tolist()) >= {
        t for t, face in enumerate(F.tolist()) if {middle, middle + 1} <= set(face)
    }


@pytest.mark.parametrize(
    "given",
    [
        place_side_by_side(plane(), move_map(plane(), (0.1, 0))),
        place_side_by_side(plane(), move_map(plane(), (0.1, 0), mirrored=True)),
        place_side_by_side(
            plane(), move_map(plane(), (0.05, 0.05), size=0.4)
        ),  # a small chart inside another chart
    ],
)
def test_other_overlapping_charts_are_accidents(given: Map) -> None:
    found = check_uv(*given)
    assert found.report.stacked == 0
    assert found.overlaps > 0
    assert found.margin == 0
    assert not found.good
    assert {*np.unique(found.report.chart[found.overlapping])} == {0, 1}
    assert "overlap by accident" in found.troubles[0]


def test_more_overlaps_than_are_listed_are_reported_as_more(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (overlapping, uv_charts):
        monkeypatch.setattr(module, "MAX_PAIRS", 20)
    found = check_uv(*place_side_by_side(plane(), move_map(plane(), (0.1, 0))))
    assert found.overlaps == 21
    assert all("more than 20" in text for text in (found.troubles[0], repr(found), str(found)))


def test_a_pile_with_more_overlaps_than_are_listed_is_stacked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coincident charts have n^2 / 2 overlapping pairs, and no pair is an accident."""
    rng = np.random.default_rng(0)
    V, F, TC, FTC = plane(2)
    pile = [(V, F, TC + 1e-4 * rng.normal(size=TC.shape), FTC) for _ in range(20)]
    expected = check_uv(*place_side_by_side(*pile, move_map(plane(), (0.4, 0))))
    monkeypatch.setattr(uv_charts, "MAX_PAIRS", 500)
    monkeypatch.setattr(uv_charts, "PAIRS_AT_ONCE", 300)
    found = check_uv(*place_side_by_side(*pile, move_map(plane(), (0.4, 0))))
    assert found.good
    assert found.report.stacked == expected.report.stacked == len(pile) - 1
    beside = check_uv(*place_side_by_side(*pile, move_map(plane(2), (0.05, 0))))
    assert (beside.report.stacked, beside.charts) == (len(pile) - 1, len(pile) + 1)
    assert 0 < beside.overlaps < 500


def test_a_chart_is_stacked_on_the_first_chart_only() -> None:
    """Of three charts in a row, the first and the last share less than nine tenths of their area."""
    found = check_uv(
        *place_side_by_side(plane(2), move_map(plane(2), (0.015, 0)), move_map(plane(2), (0.03, 0)))
    )
    assert found.report.stacked == 1
    assert {*map(tuple, np.unique(found.report.chart[found.overlapping], axis=0).tolist())} == {(0, 2)}


def test_charts_on_different_images_do_not_overlap() -> None:
    """Three of four surfaces lie on one part of a page and on two images; the fourth lies on another page."""
    given = place_side_by_side(
        plane(), move_map(plane(), (0.1, 0)), move_map(plane(), (0.1, 0)), move_map(plane(), (1.0, 0))
    )
    n = len(plane()[1])
    assert check_uv(*given).overlaps > 0
    found = check_uv(*given, labels=np.repeat(["skin", "skin", "coat", "skin"], n))
    alone = check_uv(*place_side_by_side(plane(), move_map(plane(), (0.1, 0))))
    assert found.overlaps == alone.overlaps > 0
    assert (found.report.stacked, found.pages) == (0, 3)
    assert [(one.image, one.page, one.charts, one.overlaps > 0) for one in found.report.sheets] == [
        ("coat", (0, 0), 1, False),
        ("skin", (0, 0), 2, True),
        ("skin", (1, 0), 1, False),
    ]
    assert sum(one.fill for one in found.report.sheets) == pytest.approx(3 * found.fill)
    apart = check_uv(*given, labels=np.repeat([0, 1, 2, 3], n))
    assert apart.good
    assert (apart.margin, apart.charts, len(apart.report.sheets)) == (np.inf, 4, 4)
    with pytest.raises(MeshError, match=r"labels have the shape \(1,\)"):
        check_uv(*given, labels=[0])


def test_a_connected_map_on_two_images_has_a_chart_on_each() -> None:
    V, F, TC, FTC = plane()
    found = check_uv(V, F, TC, FTC, labels=V[F].mean(axis=1)[:, 0] < 1)
    assert (found.charts, found.report.seams, found.good) == (2, 0, True)


@pytest.mark.parametrize("shared", [False, True])
def test_the_command_compares_charts_of_materials_that_share_an_image(
    shared: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_given(tmp_path / "body.obj", place_side_by_side(plane(2), move_map(plane(2), (0.1, 0))))
    lines = (tmp_path / "body.obj").read_text().splitlines()
    faces = [line for line in lines if line.startswith("f ")]
    rest = [line for line in lines if not line.startswith("f ")]
    half = len(faces) // 2
    body = ["mtllib body.mtl", *rest, "usemtl skin", *faces[:half], "usemtl coat", *faces[half:]]
    (tmp_path / "body.obj").write_text("\n".join(body))
    images = ("a.png", "a.png" if shared else "b.png")
    library = [f"newmtl {name}\nmap_Kd {image}" for name, image in zip(("skin", "coat"), images, strict=True)]
    (tmp_path / "body.mtl").write_text("\n".join(library))
    assert main(["check", str(tmp_path / "body.obj"), "--json"]) == int(shared)
    check = json.loads(capsys.readouterr().out)["check"]
    assert (check["overlaps"] > 0) == shared
    assert len(check["sheets"]) == (1 if shared else 2)
    main(["check", str(tmp_path / "body.obj")])
    assert ("coat   0, 0" in capsys.readouterr().out) != shared


def test_a_chart_over_itself_is_an_accident() -> None:
    n = 40
    turn = np.linspace(0, 3 * np.pi, n)  # a strip that winds around itself one and a half times
    line = np.column_stack((np.cos(turn), np.sin(turn)))
    V = np.concatenate((np.column_stack((line, 0.1 * turn)), np.column_stack((2 * line, 0.1 * turn))))
    i = np.arange(n - 1)
    F = np.concatenate((np.column_stack((i, i + n, i + n + 1)), np.column_stack((i, i + n + 1, i + 1))))
    found = check_uv(V, F, 0.2 * V[:, :2] + 0.5, F)
    assert (found.charts, found.flips) == (1, 0)
    assert found.overlaps > 0


@pytest.mark.parametrize("gap", [1e-4, 3e-3, 0.02, 0.4])
def test_the_margin_is_the_least_distance(gap: float) -> None:
    corner = move_map(plane(), (0.2 + gap, 0.2 + gap))  # corner to corner
    found = check_uv(*place_side_by_side(plane(), corner, move_map(plane(), (1.2, 0))), resolution=1)
    assert found.margin == pytest.approx(gap * np.sqrt(2))
    assert found.pages == 2
    assert check_uv(*plane(), resolution=1).margin == np.inf
    assert check_uv(*move_map(plane(), (-0.1, 0)), resolution=1).report.border == pytest.approx(-0.05)


def test_charts_beside_each_other_on_two_pages_have_no_margin_between_them() -> None:
    # two charts, 0.06 apart on opposite sides of a page border
    across = move_map(plane(), (0.7, 0)), move_map(plane(), (0.96, 0))
    above = move_map(plane(), (0.7, 0.4))
    assert check_uv(*place_side_by_side(*across, above), resolution=1).margin == pytest.approx(0.2)


def test_exceeded_limits_are_reported() -> None:
    V, F, TC, FTC = place_side_by_side(plane(), move_map(plane(), (0.3, 0.1), size=0.5))
    within = {"max_stretch": 1.26, "max_spread": 4, "min_margin": 7.5}
    assert check_uv(V, F, TC, FTC, resolution=100, **within).good
    for name, value, message in (
        ("max_stretch", 1.24, "stretch, L2: 1.25, above 1.24; unwrap the mesh"),
        ("max_spread", 3.9, "texel areas, 99 % : 1 %: 4, above 3.9; repack the charts with scale='even'"),
        ("min_margin", 7.6, "texels between charts, least: 7.5, below 7.6; repack the charts with more"),
    ):
        found = check_uv(V, F, TC, FTC, resolution=100, **{name: value})
        assert not found.good
        assert message in found.troubles[0]
    flush = check_uv(V, F, TC - [0.04, 0], FTC, resolution=100, min_margin=3)
    assert "texels to the border, least: 1, below 1.5" in flush.troubles[0]


def test_faces_without_coordinates_are_counted() -> None:
    V, F, TC, FTC = plane()
    some = FTC.copy()
    some[[3, 5]] = -1
    found = check_uv(V, F, TC, some)
    assert (found.report.unmapped, np.flatnonzero(found.report.chart < 0).tolist()) == (2, [3, 5])
    assert "2 faces of 72 without texture coordinates" in found.troubles[0]
    with pytest.raises(MeshError, match="no face has texture coordinates"):
        check_uv(V, F, TC, np.full_like(FTC, -1))
    flat = np.vstack((F, [[0, 0, 1]]))  # a triangle without area in space
    assert check_uv(V, flat, TC, flat).good


def test_malformed_arrays_are_refused() -> None:
    V, F, TC, FTC = plane()
    for arrays, message in (
        ((V, F, TC, FTC[1:]), "FTC has 71 rows for 72 faces"),
        ((V, F, TC[:-1], FTC), "refer to texture coordinates outside"),
        ((V[:-1], F, TC, FTC), "refer to vertices outside"),
        ((V, F, np.where(np.arange(len(TC))[:, None] == 4, np.nan, TC), FTC), "rows 4 of TC are NaN"),
    ):
        with pytest.raises(MeshError, match=message):
            check_uv(*arrays)
    with pytest.raises(ValueError, match="resolution is 0"):
        check_uv(V, F, TC, FTC, resolution=0)
    with pytest.raises(ValueError, match="max_stretch is -1"):
        check_uv(V, F, TC, FTC, max_stretch=-1)


def test_stretch_agrees_with_quality_for_mirrored_charts() -> None:
    V, F, TC, _ = plane()
    TC = TC * [1, 2]
    expected = quality(V, F, TC)
    for map_ in (TC, TC * [-1, 1]):
        found = check_uv(V, F, map_, F)
        assert found.stretch_l2 == pytest.approx(expected.stretch_l2)
        assert found.report.quality.angle_distortion == pytest.approx(expected.angle_distortion)


def test_the_exit_code_reports_troubles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, bad = tmp_path / "good.obj", tmp_path / "bad.obj"
    write_given(good, place_side_by_side(plane(), move_map(plane(), (0.3, 0))))
    write_given(bad, place_side_by_side(plane(), move_map(plane(), (0.1, 0))))
    assert main(["check", str(good), "--resolution", "512", "--quiet"]) == 0
    assert main(["check", str(bad), "--quiet"]) == 1
    assert "overlap by accident" in capsys.readouterr().err
    assert main(["check", str(good), "--resolution", "100", "--min-margin", "11"]) == 1
    assert "accidental overlaps" in capsys.readouterr().out
    assert main(["check", str(good), str(bad), "--json"]) == 1
    first, second = map(json.loads, capsys.readouterr().out.splitlines())
    assert (first["good"], first["check"]["charts"], first["check"]["flipped"]) == (True, 2, [])
    assert second["check"]["overlaps"] > 0
    igl.write_triangle_mesh(str(tmp_path / "plain.obj"), *plane()[:2])
    assert main(["check", str(tmp_path / "plain.obj")]) == 2
    assert "has no texture coordinates: unwrap it" in capsys.readouterr().err


def test_the_command_counts_faces_without_coordinates(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 1 1 0", "v 2 0 0", "vt 0 0", "vt 1 0", "vt 0 1"]
    (tmp_path / "a.obj").write_text("\n".join([*lines, "f 1/1 2/2 3/3", "f 2/2 4 3/3", "f 2 5 4"]))
    V, F, TC, _ = plane(2)
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(V), "type": "VEC3"},
        {"bufferView": 1, "componentType": 5126, "count": len(V), "type": "VEC2"},
        {"bufferView": 2, "componentType": 5125, "count": F.size, "type": "SCALAR"},
    ]
    with_map = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    without = {"attributes": {"POSITION": 0}, "indices": 2}
    text = {
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [with_map, without]}],
        "accessors": accessors,
    }
    write_glb(
        tmp_path / "a.glb",
        text,
        [V.astype("<f4").tobytes(), TC.astype("<f4").tobytes(), F.astype("<u4").tobytes()],
    )
    for name, unmapped, faces in (("a.obj", 2, 3), ("a.glb", len(F), 2 * len(F))):
        assert main(["check", str(tmp_path / name), "--json"]) == 1
        streams = capsys.readouterr()
        check = json.loads(streams.out)["check"]
        assert (check["unmapped"], check["faces"]) == (unmapped, faces)
        assert f"{unmapped} faces of {faces} without texture coordinates" in streams.err


def test_transforms_of_materials_are_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    V, F, TC, FTC = plane()
    for moved in ({}, {"scale": [4, 4]}, {"texCoord": 0}):
        write_textured(tmp_path / "plane.gltf", V, F, TC, FTC, np.ones((2, 2, 3)))
        text = json.loads((tmp_path / "plane.gltf").read_text())
        use = text["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
        use["extensions"] = {"KHR_texture_transform": moved}
        (tmp_path / "plane.gltf").write_text(json.dumps(text))
        assert main(["check", str(tmp_path / "plane.gltf"), "--quiet"]) == 0
        assert ("KHR_texture_transform" in capsys.readouterr().err) == ("scale" in moved)


NOTHING_TO_CHECK = {"all on a line", "coordinates of 1e200"}  # `check_uv` finds no face with an area


@pytest.mark.parametrize("name", sorted(NASTY.keys() - NOTHING_TO_CHECK))
def test_an_atlas_that_unwrap_calls_good_is_good_with_the_same_options(name: str) -> None:
    """Even if `unwrap` reorients faces, separates sheets, cuts one-sided surfaces or opens caps."""
    V, F = NASTY[name]()
    for packing in (None, Packing(resolution=1024, padding=2)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)
            atlas = unwrap(V, F, packing=packing)
        limits = {} if packing is None else {"resolution": 1024, "min_margin": 2}
        check = check_uv(V, F, atlas.TC, atlas.FTC, **limits)
        assert atlas.good and check.good, check.troubles
        assert check.charts == len(atlas.charts)


REPAIRED = ["one face turned", "three sheets at an edge", "a one sided band", "t junctions filled with caps"]


@pytest.mark.parametrize(
    "name",
    [*REPAIRED, *(pytest.param(n, marks=pytest.mark.slow) for n in sorted(NASTY.keys() - {*REPAIRED}))],
)
def test_a_file_that_the_command_calls_good_is_good_in_every_format(name: str, tmp_path, capsys) -> None:
    if name in NOTHING_TO_CHECK:
        return
    V, F = NASTY[name]()
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in V.tolist()]
    (tmp_path / "in.obj").write_text("\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in (F + 1).tolist())]))
    options = ["--resolution", "1024"]
    for suffix in ("obj", "ply", "glb", "gltf", "3mf", "vtp"):
        out = str(tmp_path / f"out.{suffix}")
        assert main(["unwrap", str(tmp_path / "in.obj"), "-o", out, "--quiet", *options]) == 0
        assert main(["check", out, "--min-margin", "2", "--quiet", *options]) == 0, capsys.readouterr().err


def test_a_face_that_is_folded_over_is_flipped_in_a_mesh_whose_faces_are_oriented_at_random() -> None:
    V, F = NASTY["faces turned at random"]()
    with pytest.warns(MeshWarning, match="turned"):
        atlas = unwrap(V, F)
    inner = np.flatnonzero(np.bincount(atlas.FTC.ravel()) == 6)
    row = next(k for k in inner if np.ptp(atlas.TC[atlas.FTC[(k == atlas.FTC).any(axis=1)]], axis=0).all())
    around = (row == atlas.FTC).any(axis=1)
    TC = atlas.TC.copy()
    ring = atlas.TC[np.setdiff1d(atlas.FTC[around], [row])]
    TC[row] += 1.5 * (ring[0] - TC[row])  # beyond a neighbour
    check = check_uv(V, F, TC, atlas.FTC)
    assert 0 < check.flips < around.sum()
    assert set(check.flipped.tolist()) < set(np.flatnonzero(around).tolist())


@pytest.mark.parametrize("suffix", ["glb", "obj"])
def test_texels_are_those_of_the_largest_image_of_the_file(suffix: str, tmp_path, capsys) -> None:
    atlas, path = unwrap(*igl.icosahedron()), tmp_path / f"ball.{suffix}"
    write_textured(path, *igl.icosahedron(), atlas.TC, atlas.FTC, np.ones((32, 64, 3)))

    def check(*options: str) -> tuple[int | list[int], str]:
        assert main(["check", str(path), "--json", *options]) == 0
        found = json.loads(capsys.readouterr().out)["check"]["resolution"]
        assert main(["check", str(path), *options]) == 0
        return found, capsys.readouterr().out

    size, text = check()
    assert size == [64, 32] and "64 x 32, without --resolution: the size of " in text
    assert check("--resolution", "16")[0] == 16
    if suffix == "obj":
        path.with_suffix(".png").unlink()
        size, text = check()
        assert size == 1024 and "1024 x 1024" in text and "ball.png, which is not in" in text


def test_a_material_without_a_name_is_named_by_its_number_once(tmp_path, capsys) -> None:
    atlas, path = unwrap(*igl.icosahedron()), tmp_path / "ball.gltf"
    write_textured(path, *igl.icosahedron(), atlas.TC, atlas.FTC, np.ones((32, 32, 3)))
    assert "name" not in json.loads(path.read_text())["materials"][0]
    assert main(["check", str(path)]) == 0
    assert "the size of baseColorTexture of material 0." in capsys.readouterr().out
