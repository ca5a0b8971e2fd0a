"""Any surface unwraps without flips or overlaps, completely, and with the same figures in every file."""

from __future__ import annotations

import importlib
import itertools
import sys
import warnings
from collections import Counter
from dataclasses import replace
from functools import cache

import igl
import numpy as np
import pytest
import trimesh
from carried import tube
from commands import run
from conftest import CLOSED, ROOT, load, read_pixels
from holed_surfaces import plate_with_comb, slotted_plate
from overlapping_surfaces import spiral

from igl_linabf import (
    Atlas,
    ChartOptions,
    FallbackWarning,
    LinABF,
    MeshError,
    MeshWarning,
    OutcomeWarning,
    Packing,
    cut,
    find_seams,
    flatten,
    overlaps,
    quality,
    unwrap,
)
from igl_linabf.charts import charting, options
from igl_linabf.charts.atlas.pieces import restrict_flattening, restrict_uv
from igl_linabf.flattening import Outcome
from igl_linabf.io import read_mesh, read_texture
from igl_linabf.surface import Submesh, arrays, label_face_components

ROOMY = Packing(resolution=2048, texel_density=1)  # pages that fit all charts uncut

OTHERS = (
    "punctured_nut",
    "pial_with_holes",
    "ant",
    "bumps",
    "icosahedron",
    "handles__bff_punctured-torus.obj",
    "handles__optcuts_torus_with_hole.obj",
    "holes__igl_halftunnel.off",
    "multi__bff_teapot.obj",
    "multi__optcuts_double_triangles.obj",
)


def surface(name: str) -> tuple[np.ndarray, np.ndarray]:
    if name == "icosahedron":
        return igl.icosahedron()
    if name == "bunny":
        from stretch import bunny

        return bunny()
    return load(name)


@cache
def unwrap_cached(name: str) -> Atlas:
    """Return the atlas with default options, cached for several tests."""
    return unwrap(*surface(name))


@pytest.mark.parametrize("name", ["bunny", *CLOSED, *OTHERS])
def test_atlases_have_no_flips_no_overlaps_and_few_charts(name: str) -> None:
    V, F = surface(name)
    atlas = unwrap_cached(name)
    assert atlas.good
    is_hard = (
        atlas.quality.stretch_l2 < 1.01
    )  # nearly without distortion, a surface of planes and cylinders has more charts
    most = (8 if is_hard else 3) * (label_face_components(F, len(V)).max() + 1)
    if len(atlas.charts) > most:  # cut for a page that would be less than half full
        uncut = unwrap(V, F, packing=ROOMY)
        assert len(uncut.charts) <= most
        assert atlas.fill > 0.5 > unwrap(V, F, uncut.seams).fill
    assert atlas.FTC.shape == F.shape
    assert (atlas.origin[atlas.FTC] == F).all()
    assert atlas.TC.min() >= 0
    assert atlas.TC.max() <= 1
    assert (igl.doublearea(atlas.TC, atlas.FTC) > 0).all()
    assert len(overlaps(atlas.TC, atlas.FTC, between=True)) == 0
    assert quality(V[atlas.origin], atlas.FTC, atlas.TC).flips == 0
    sizes = np.array([igl.doublearea(atlas.TC, atlas.FTC[c.faces]).sum() for c in atlas.charts])
    areas = np.array([igl.doublearea(V, F[c.faces]).sum() for c in atlas.charts])
    assert np.allclose(sizes / areas, sizes.sum() / areas.sum())
    assert (np.sort(np.concatenate([c.faces for c in atlas.charts])) == np.arange(len(F))).all()


@pytest.mark.parametrize("name", ["bunny", *CLOSED])
def test_distortion_is_below_that_of_igl_lscm_on_the_same_cut(name: str) -> None:
    V, F = surface(name)
    atlas = unwrap(V, F, method="linabf", packing=ROOMY)
    corners = np.zeros((0, 2))
    ours, theirs = [], []
    for chart in atlas.charts:
        used, flat = np.unique(atlas.FTC[chart.faces], return_inverse=True)
        corners = V[atlas.origin[used]]
        faces = flat.reshape(-1, 3)
        ours.append(chart.quality.angle_distortion * len(faces))
        lscm = quality(corners, faces, flatten(corners, faces, method="lscm").uv)
        theirs.append(lscm.angle_distortion * len(faces))
    assert sum(ours) < sum(theirs)
    if name == "bunny":
        assert atlas.quality.angle_distortion <= 1.5e-4
        assert atlas.quality.stretch_l2 <= 1.5


def test_exactly_the_given_seams_are_cut() -> None:
    V, F = surface("icosahedron")
    seams = find_seams(V, F)
    atlas = unwrap(V, F, seams)
    assert {tuple(sorted(e)) for e in atlas.seams.tolist()} == {tuple(sorted(e)) for e in seams.tolist()}
    assert atlas.seam_length == pytest.approx(np.linalg.norm(V[seams[:, 0]] - V[seams[:, 1]], axis=1).sum())
    with pytest.raises(MeshError, match="is closed: give more seams"):
        unwrap(V, F, np.zeros((0, 2), dtype=int))
    V, F = surface("handles__optcuts_torus_with_hole.obj")
    with pytest.raises(MeshError, match="has 1 handle"):
        unwrap(V, F, np.zeros((0, 2), dtype=int))


def test_edges_beyond_the_given_seams_are_reported_in_one_warning() -> None:
    V, F = spiral()
    given = F[:3, :2]
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        atlas = unwrap(V, F, given)
    (warning,) = told
    assert issubclass(warning.category, FallbackWarning)
    cut = {tuple(sorted(edge)) for edge in atlas.seams.tolist()}
    added = {tuple(sorted(edge)) for edge in atlas.added_seams.tolist()}
    assert added == cut - {tuple(sorted(edge)) for edge in given.tolist()} and added
    assert f"{len(added)} edges are cut in addition" in str(warning.message)
    split = [chart for chart in atlas.charts if chart.split_reasons]
    assert f"overlaps (of {len(split)} charts)" in str(warning.message)
    assert all(chart.split_reasons == ("overlaps",) for chart in split)
    whole = unwrap(*surface("icosahedron"), find_seams(*surface("icosahedron")))
    assert not len(whole.added_seams)


def test_holes_stay_uncut_if_asked() -> None:
    V, F = surface("holes__igl_halftunnel.off")
    # the isometric map overlaps itself unless holes are cut
    atlas = unwrap(V, F, charts=ChartOptions(keep_holes=True), method="linabf")
    (chart,) = atlas.charts
    assert len(chart.result.holes) == 2
    assert atlas.seams.shape == (0, 2)
    assert all(disk.result.holes == () for disk in unwrap(V, F).charts)


@pytest.mark.parametrize("method", ["linabf", "isometric"])
@pytest.mark.parametrize("plate", [plate_with_comb(5), slotted_plate(3)], ids=["comb", "slot"])
def test_a_flat_plate_keeps_its_shape_and_a_window_with_a_long_edge(
    plate: tuple[np.ndarray, np.ndarray], method: str
) -> None:
    atlas = unwrap(*plate, method=method, charts=ChartOptions(keep_holes=True))
    assert len(atlas.charts) == 1 and len(atlas.charts[0].result.holes) == 1
    assert atlas.quality.stretch_l2 == pytest.approx(1, abs=1e-9)


def test_unreferenced_vertices_are_ignored_and_strict_refuses_degenerate_faces() -> None:
    V, F = surface("icosahedron")
    atlas = unwrap(np.vstack(([[9, 9, 9]], V, [[8, 8, 8]])), F + 1)
    assert atlas.good
    assert (atlas.origin[atlas.FTC] == F + 1).all()
    with pytest.raises(MeshError, match=r"zero area.*igl_linabf\.clean"):
        unwrap(np.where(np.arange(len(V))[:, None] == F[3, 0], V[F[3, 1]], V), F, strict=True)


@pytest.mark.parametrize(("name", "charts"), [("stress__flipfree_deer.obj", 2), ("limb", 9)])
def test_a_disk_beyond_double_precision_is_cut_open(name: str, charts: int) -> None:
    V, F = load(name)
    assert len(flatten(V, F).flipped) > 0
    assert unwrap(V, F, weld=False).good
    atlas = unwrap(V, F, method="linabf", weld=False, packing=ROOMY)
    assert atlas.good
    assert len(atlas.charts) <= charts


def test_a_map_beyond_double_precision_is_cut_into_few_charts_without_seams() -> None:
    V, F = tube(50.0)
    assert len(flatten(V, F).flipped) > len(F) / 10
    with pytest.warns(OutcomeWarning), pytest.warns(FallbackWarning, match="limits of double precision"):
        atlas = unwrap(V, F, np.zeros((0, 2), dtype=int), method="linabf")
    assert atlas.quality.flips == atlas.quality.overlaps == 0
    assert len(atlas.charts) <= 6


@pytest.mark.parametrize(
    ("name", "stretched"),
    [
        ("stress__optcuts_male_body_i_f10000.obj", [1, 20, 1]),
        ("stress__optcuts_golf.obj", [20, 1, 1]),
        ("disk__igl_lion.off", [20, 1, 1]),
    ],
)
def test_seams_grow_until_nothing_flips(name: str, stretched: list[float]) -> None:
    V, F = load(name)
    V = V * stretched
    assert len(flatten(V, F).flipped) > 0
    atlas = unwrap(V, F)
    assert atlas.good
    assert atlas.quality.flips == atlas.quality.overlaps == 0
    assert all(chart.result.report.layout != "SLIM" for chart in atlas.charts)


def test_after_some_rounds_of_longer_seams_charts_that_flip_are_halved(monkeypatch) -> None:
    V, F = load("stress__optcuts_golf.obj")
    V = V * [20, 1, 1]
    monkeypatch.setattr(charting, "MAX_SEAM_ROUNDS", 0)
    monkeypatch.setattr(charting, "MAX_SEAM_ROUNDS_WITH_MANY_FLIPS", 0)
    monkeypatch.setattr(charting, "_flatten_without_flips", pytest.fail)  # fails if the guarantee is needed
    atlas = unwrap(V, F, charts=ChartOptions(max_stretch=np.inf), method="linabf")
    assert atlas.good
    assert atlas.quality.flips == 0
    assert len(atlas.charts) > 1


def test_the_guarantee_is_used_with_a_warning_if_no_seam_helps(monkeypatch) -> None:
    monkeypatch.setattr(charting, "MAX_TRADE_DOUBLINGS", 0)
    V, F = load("stress__optcuts_golf.obj")
    with pytest.warns(FallbackWarning, match="guarantee='injective'"):
        atlas = unwrap(V * [20, 1, 1], F, charts=ChartOptions(max_stretch=np.inf), method="linabf")
    assert atlas.good
    assert any(chart.result.report.attempts[-1].name == "injective" for chart in atlas.charts)


def test_troubles_describe_faulty_charts() -> None:
    atlas = unwrap(*surface("icosahedron"))
    (chart,) = atlas.charts
    over = replace(atlas, charts=(replace(chart, overlapping=2),))
    assert not over.good
    assert over.troubles == [
        "chart 0 (faces 0, 1, 2, 3, 4, ... (20 in all)) lies over itself in 2 pairs of faces: "
        "give more seams there"
    ]
    result = replace(chart.result, outcome=Outcome.FLIPPED, flipped=np.array([3]))
    assert (
        "has flipped faces, 3: give more seams"
        in replace(atlas, charts=(replace(chart, result=result),)).troubles[0]
    )


def test_only_parts_with_flipped_triangles_count_as_flipped() -> None:
    V, F = load("crown")
    whole = flatten(V, F, method="lscm")
    assert whole.outcome is Outcome.FLIPPED
    piece = Submesh(V, F, np.arange(len(F)), np.arange(len(V)), len(V))
    near = np.isin(F, F[whole.flipped]).any(axis=1)
    parts = piece.cut_between_labels(near)
    made = [restrict_flattening(whole, piece, part, restrict_uv(whole.uv, piece, part)) for part in parts]
    flips = [bool(near[part.faces].any()) for part in parts]
    assert any(flips) and not all(flips)
    assert [result.outcome is Outcome.FLIPPED for result in made] == flips
    for part, result in zip(parts, made, strict=True):
        assert (part.faces[result.flipped] == np.intersect1d(part.faces, whole.flipped)).all()


@pytest.mark.parametrize(
    ("name", "method", "says"),
    [("crown", "lscm", "has flipped faces"), ("spiral", "linabf", "lies over itself in")],
)
def test_unwrap_warns_of_every_chart_that_flips_or_overlaps(
    name: str, method: str, says: str, monkeypatch
) -> None:
    monkeypatch.setattr(charting.constants, "MAX_OVERLAP_ROUNDS", 0)
    monkeypatch.setattr(charting, "bisect_piece", lambda _: [])
    V, F = spiral() if name == "spiral" else load(name)
    with pytest.warns(OutcomeWarning, match=rf"chart 0 .* {says}") as caught:
        atlas = unwrap(V, F, np.zeros((0, 2), dtype=int), method=method)
    assert not atlas.good
    assert atlas.quality.flips + atlas.quality.overlaps > 0
    assert [str(w.message) for w in caught if w.category is OutcomeWarning] == atlas.troubles
    assert caught[0].filename == __file__


def test_a_part_of_a_chart_that_is_stretched_gets_seams_for_itself() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 3)
    V /= np.linalg.norm(V, axis=1)[:, None]
    # a dome whose map has an L2 stretch of 1.6
    dome = Submesh.manifold_from_input(V, F[V[F].mean(axis=1)[:, 2] > -0.7])
    asked = options.ChartRules(LinABF(), True, 6.0, False, False, None, None)
    work = charting._PendingPiece((0,), dome, Counter({charting.Reason.OVERLAP: 9}))
    tried = charting._try_piece(work, asked, None)
    assert tried.reason is charting.Reason.STRETCH
    assert tried.chart.quality.stretch_l2 > 1.5
    charts = charting.make_charts(tried.parts, np.zeros((0, 2), dtype=np.int64), asked)
    assert max(chart.quality.stretch_l2 for chart, _ in charts) < 1.2


def test_seams_that_turn_out_to_cost_more_than_they_save_are_not_cut(monkeypatch) -> None:
    V, F = igl.upsample(*igl.icosahedron(), 3)
    V /= np.linalg.norm(V, axis=1)[:, None]
    dome = Submesh.manifold_from_input(V, F[V[F].mean(axis=1)[:, 2] > 0.3])
    sides = np.concatenate((F[:, [0, 1]], F[:, [1, 2]]))
    across = sides[(V[sides][..., 0] > 0).sum(axis=1) == 2]
    middle = across[np.abs(V[across][..., 0]).max(axis=1) < 0.12]
    tried = []

    def found(piece, change, stretch, rounds, options):
        tried.append(rounds)
        return [] if rounds else piece.cut_along(middle[np.isin(middle, piece.vertices).all(axis=1)])

    monkeypatch.setattr(charting, "_cut_for_stretch", found)
    none = np.zeros((0, 2), dtype=np.int64)
    for trade, pays in ((1.0, False), (1e4, True)):
        asked = options.ChartRules(LinABF(), True, trade, False, False, None, None)
        before = len(tried)
        charts = charting.make_charts([dome], none, asked)
        assert len(tried) > before + 1  # the parts of the dome were tried as well
        assert (max(chart.n_splits for chart, _ in charts) > 0) == pays


@pytest.mark.parametrize("name", ["closed__igl_cow.off", "closed__optcuts_horse_f10000.obj"])
def test_a_larger_trade_reduces_stretch_by_longer_seams(name: str) -> None:
    V, F = load(name)
    made = [unwrap(V, F, charts=ChartOptions(trade=trade)) for trade in (1, 3, 10, 30, 100, 300)]
    assert all(atlas.good for atlas in made)
    lengths = [atlas.seam_length for atlas in made]
    stretches = [atlas.quality.stretch_l2 for atlas in made]
    assert all(short <= 1.001 * long for short, long in itertools.pairwise(lengths))
    assert all(less <= more + 0.001 for more, less in itertools.pairwise(stretches))
    assert stretches[-1] < 1.02


@pytest.mark.parametrize("suffix", ["obj", "glb", "ply"])
def test_other_programs_read_the_output_of_the_command(tmp_path, suffix: str) -> None:
    mesh, out, picture = tmp_path / "in.off", tmp_path / f"out.{suffix}", tmp_path / "out.png"
    V, F = load("bumps")
    V, F = np.vstack((V, V + np.array([3, 0, 0]))), np.vstack((F, F + len(V)))
    igl.write_triangle_mesh(str(mesh), V, F)
    process = run("unwrap", mesh, "-o", out, "--picture", picture)
    assert process.returncode == 0, process.stderr
    assert "; 0 splits; " in process.stdout
    V, F = read_mesh(mesh)
    atlas = unwrap(V, F)
    loaded = trimesh.load(out, process=False, force="mesh")
    assert len(loaded.faces) == len(F)
    uv = np.asarray(loaded.visual.uv)[loaded.faces]
    assert np.allclose(uv, atlas.TC[atlas.FTC], atol=1e-6)
    assert np.allclose(np.asarray(loaded.vertices)[loaded.faces], V[F], atol=1e-5)
    assert read_pixels(picture).shape[:2] == (700, 1400)


def test_the_command_flattens_the_seams_of_a_file_again(tmp_path) -> None:
    V, F = surface("icosahedron")
    V = V * [1, 1.2, 0.8]
    igl.write_triangle_mesh(str(tmp_path / "in.obj"), V, F)
    V, F = read_mesh(tmp_path / "in.obj")
    assert run("unwrap", tmp_path / "in.obj", "-o", tmp_path / "a.obj", "--trade", 1).returncode == 0
    process = run("unwrap", tmp_path / "a.obj", "-o", tmp_path / "b.obj", "--seams", "uv")
    assert process.returncode == 0, process.stderr
    (first, FTC), (second, again) = (read_texture(tmp_path / name) for name in ("a.obj", "b.obj"))
    assert np.allclose(first[FTC], second[again], atol=1e-9)
    pairs = tmp_path / "seams.txt"
    np.savetxt(pairs, find_seams(V, F, trade=1), fmt="%d")
    process = run("unwrap", tmp_path / "in.obj", "-o", tmp_path / "c.obj", "--seams", pairs)
    assert process.returncode == 0, process.stderr
    assert (read_texture(tmp_path / "c.obj")[1] == FTC).all()
    process = run("flatten", tmp_path / "in.obj", "-o", tmp_path / "d.obj")
    assert process.returncode == 2
    assert "unwrap" in process.stderr
    process = run("unwrap", tmp_path / "in.obj", "-o", tmp_path / "d.obj", "--seams", "uv")
    assert process.returncode == 2
    assert len(process.stderr.splitlines()) == 1
    process = run("unwrap", tmp_path / "in.obj", "-o", tmp_path / "d.obj", "--cones", "3,30")
    assert process.returncode == 2
    assert "there is no file 3,30" in process.stderr
    assert not (tmp_path / "d.obj").exists()


def test_flattening_the_cut_surface_gives_the_maps_of_the_atlas() -> None:
    V, F = surface("icosahedron")
    cut_V, cut_F, origin = cut(V, F, find_seams(V, F))
    assert (V[origin] == cut_V).all()
    assert quality(cut_V, cut_F, flatten(cut_V, cut_F).uv).angle_distortion == pytest.approx(
        unwrap(V, F).quality.angle_distortion
    )


def test_the_input_is_checked_once_for_any_number_of_charts(monkeypatch) -> None:
    calls: list[str] = []

    def counted(name: str) -> None:
        check = getattr(arrays, name)

        def count(*given, **named):
            calls.append(name)
            return check(*given, **named)

        for module in [m for key, m in sys.modules.items() if key.startswith("igl_linabf.")]:
            if hasattr(module, name):
                monkeypatch.setattr(module, name, count)

    counted("vertex_array")
    counted("face_array")
    V, F = spiral()
    for repair_overlaps in (False, True):
        calls.clear()
        atlas = unwrap(V, F, charts=ChartOptions(repair_overlaps=repair_overlaps))
        assert atlas.report.n_splits or repair_overlaps
        assert calls == ["vertex_array", "face_array"]


@pytest.mark.parametrize("seams", [None, "given"])
@pytest.mark.parametrize("turned", [False, True])
def test_charts_do_not_cross_labels(seams: str | None, turned: bool) -> None:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    labels = np.array([7, -1, 3])[(V[F].mean(axis=1)[:, 0] * 1.5 + 1.5).astype(int).clip(0, 2)]
    edges = find_seams(V, F)[:5] if seams else None
    if turned:  # the repair of a mesh changes the rows of F
        F[::7] = F[::7, ::-1]
        F = np.vstack((F[:3], F[:1], F[3:]))
        labels = np.insert(labels, 3, labels[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        atlas = unwrap(V, F, edges, charts=ChartOptions(extend=edges is not None, labels=labels))
    assert atlas.good
    assert [len(set(labels[atlas.chart == k])) for k in range(len(atlas.charts))] == [1] * len(atlas.charts)
    # few charts in spite of the labels; the duplicate face is a chart of its own
    assert len(atlas.charts) <= 4 + turned


def test_labels_belong_to_polygons() -> None:
    V = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    F = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    plain = unwrap(V, F)
    assert (plain.chart == plain.chart[3]).sum() > 1
    atlas = unwrap(V, F, charts=ChartOptions(labels=[0, 0, 0, 1, 0, 0]))
    assert (atlas.chart == atlas.chart[3]).tolist() == [False, False, False, True, False, False]


@pytest.mark.parametrize(
    ("labels", "said"), [([1, 2], "20 faces"), ([0.5] * 20, "not integers"), ("x", "not an array")]
)
def test_invalid_labels_are_refused(labels: object, said: str) -> None:
    with pytest.raises(MeshError, match=said):
        unwrap(*igl.icosahedron(), charts=ChartOptions(labels=labels))


@pytest.mark.slow
def test_bumpy_surfaces_get_even_texels_by_more_seams(monkeypatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    V, F = importlib.import_module("generated").generate_mesh("box", 96, 0.03, 1)
    few, even = (unwrap(V, F, charts=ChartOptions(trade=trade), method="isometric") for trade in (2.0, 6.0))
    assert even.good
    assert few.seam_length < even.seam_length
    assert even.quality.stretch_l2 < 1.035 < few.quality.stretch_l2
    assert even.quality.texel_spread < 2.45 < few.quality.texel_spread


def test_the_default_margin_leaves_room_for_many_charts() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    n = 1600
    V = (square + 2 * np.arange(n)[:, None, None] * [0, 0, 1]).reshape(-1, 3)
    F = (np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(n)[:, None, None]).reshape(-1, 3)
    assert unwrap(V, F).fill > 0.8
    wide = unwrap(V, F, packing=Packing(margin=0.005))
    assert wide.fill < 0.7  # a margin that is given is kept


def test_isometric_atlases_of_bodies_with_many_spikes_have_even_texels() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 4)
    V /= np.linalg.norm(V, axis=1)[:, None]
    tips = np.random.default_rng(3).normal(size=(60, 3))
    tips /= np.linalg.norm(tips, axis=1)[:, None]
    V *= 1 + 4 * np.clip(((V @ tips.T).max(axis=1) - 0.99) / 0.01, 0, 1)[:, None]
    atlas = unwrap(V, F, method="isometric")
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.1
    assert atlas.quality.texel_spread < 3
