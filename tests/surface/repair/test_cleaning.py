"""Repaired surfaces are clean and can be unwrapped; clean meshes do not change."""

from __future__ import annotations

import warnings

import igl
import numpy as np
import pytest
import pyvista
from commands import run
from conftest import load
from hard_surfaces import box
from hostile_meshes import check_any, check_atlas
from nasty_meshes import NASTY, band, concatenate_surfaces, merge_equal_vertices, sheet, soup, sphere

from igl_linabf import (
    ChartOptions,
    MeshError,
    MeshWarning,
    OutcomeWarning,
    Packing,
    clean,
    cut,
    find_seams,
    flatten,
    quality,
    unwrap,
)
from igl_linabf.io import read_texture
from igl_linabf.surface import Submesh, label_face_components

CLEAN = ("a body whose faces without area were removed", "bodies through each other")


def unwrapped(V: np.ndarray, F: np.ndarray, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return unwrap(V, F, **options)


def signed_areas(atlas) -> np.ndarray:
    a, b, c = atlas.TC[atlas.FTC].swapaxes(0, 1)
    u, v = b - a, c - a
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


@pytest.mark.parametrize("name", [name for name in NASTY if name != "a thousand loose triangles"])
def test_a_nasty_mesh_is_repaired_and_unwrapped_without_loss(name: str) -> None:
    V, F = NASTY[name]()
    cleaned = clean(V, F)
    new_V, new_F, origin, repairs = cleaned
    assert (cleaned.faces[1:] > cleaned.faces[:-1]).all()
    if len(new_F):
        Submesh.manifold_from_input(new_V, new_F)
        turned = np.where(cleaned.turned[:, None], new_F[:, [0, 2, 1]], new_F)
        assert (origin[turned] == cleaned.merged[F[cleaned.faces]]).all()
    atlas = unwrapped(V, F)
    check_atlas(V, F, atlas)
    assert atlas.good
    assert atlas.quality.flips == 0
    assert [str(r) for r in atlas.report.repairs] == [str(r) for r in repairs]
    # strict mode accepts loose triangles, because these form a clean surface, too
    if repairs and repairs[0].kind != "welded":
        with pytest.raises(MeshError):
            unwrap(V, F, strict=True)


def test_sheets_are_cut_apart_and_the_best_pair_stays_joined() -> None:
    V, F = NASTY["three sheets at an edge"]()
    _, new_F, _, repairs = clean(V, F)
    assert [r.kind for r in repairs] == ["crowded"]
    label = label_face_components(new_F, new_F.max() + 1)
    assert np.bincount(label).tolist() == [98, 98]
    # the bent sheet is one component, not one half of it joined to the upright sheet
    assert (label[:98] == 0).all()
    V, F = NASTY["two cubes at an edge"]()
    _, new_F, _, _ = clean(V, F)
    assert (label_face_components(new_F, new_F.max() + 1) == np.arange(24) // 12).all()


def test_the_repaired_orientation_is_consistent_and_the_result_has_the_given_one() -> None:
    V, F = sphere()
    V = V * (
        1 + 0.1 * np.sin(3 * V[:, :1] + 1) * np.cos(2 * V[:, 1:2])
    )  # break the symmetry, so that a single seam is the best one
    turned = np.random.default_rng(1).random(len(F)) < 0.3
    other = np.where(turned[:, None], F[:, ::-1], F)
    plain, mixed = unwrap(V, F), unwrapped(V, other)
    assert (mixed.origin[mixed.FTC] == other).all()
    assert np.allclose(mixed.TC[mixed.FTC[turned][:, ::-1]], plain.TC[plain.FTC[turned]])
    assert ((signed_areas(mixed) < 0) == turned).all()
    assert mixed.report.repairs[0].count == turned.sum()
    assert mixed.report.repairs[0].first.tolist() == np.flatnonzero(turned)[:5].tolist()


def test_a_one_sided_band_is_cut_once_and_unrolls_nearly_isometrically() -> None:
    V, F = band(80, 9, 1)
    atlas = unwrapped(V, F, charts=ChartOptions(trade=0))  # no cuts to fill the page
    assert len(atlas.charts) == 1
    assert atlas.quality.stretch_l2 < 1.01
    torn = next(r for r in atlas.report.repairs if r.kind == "torn")
    assert torn.count < 20


def test_a_welded_soup_has_the_atlas_of_the_mesh() -> None:
    V, F = sphere()
    whole, loose = unwrap(V, F), unwrapped(*soup(V, F))
    assert len(loose.charts) == 1
    assert loose.quality.stretch_l2 == pytest.approx(whole.quality.stretch_l2, rel=0.02)
    order = np.unique(F, return_index=True)[1]  # number the vertices as in the soup
    new = np.argsort(np.argsort(order))
    ordered = unwrap(V[np.argsort(new)], new[F])
    assert (ordered.TC[ordered.FTC] == loose.TC[loose.FTC]).all()
    noisy = soup(V, F)[0] + 1e-7 * np.random.default_rng(0).normal(size=(F.size, 3))
    assert len(unwrap(noisy, soup(V, F)[1]).charts) == len(F)
    near = unwrapped(noisy, soup(V, F)[1], weld=1e-5)
    assert len(near.charts) == 1
    assert near.quality.stretch_l2 == pytest.approx(whole.quality.stretch_l2, rel=0.02)
    with pytest.raises(ValueError, match="weld is -1"):
        unwrap(V, F, weld=-1)


def test_separate_sides_of_a_closed_surface_are_welded_on_default() -> None:
    V, F = box(1, 2, 3, times=3)
    normal = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    side = np.round(normal) @ [1, 2, 3]
    apart = concatenate_surfaces(*(igl.remove_unreferenced(V, F[side == k])[:2] for k in np.unique(side)))
    atlas = unwrapped(*apart)
    assert [repair.kind for repair in atlas.report.repairs] == ["welded"]
    assert len(atlas.charts) == 1
    assert atlas.quality.stretch_l2 == pytest.approx(1)
    turned = apart[1].copy()
    turned[::2] = turned[::2, ::-1]
    assert len(unwrapped(apart[0], turned).charts) == 1
    V, F = sphere()
    octant = (V[F].mean(axis=1) > 0) @ [1, 2, 4]
    apart = concatenate_surfaces(*(igl.remove_unreferenced(V, F[octant == k])[:2] for k in range(8)))
    assert len(unwrapped(*apart, charts=ChartOptions(trade=0)).charts) == 1
    assert len(unwrap(*apart, weld=False).charts) == 8
    beside = concatenate_surfaces(*((box(1, 1, 1)[0] + [k, 0, 0], box(1, 1, 1)[1]) for k in range(5)))
    assert len(unwrap(*beside, charts=ChartOptions(trade=0)).charts) == 5


def test_faces_without_area_leave_no_hole() -> None:
    V, F = load("closed__igl_cow.off")
    plain = unwrap(V, F).quality
    a, b = F[100, :2]
    middle = len(V)
    on = [
        t for t in range(len(F)) if {a, b} <= set(F[t].tolist())
    ]  # faces at an edge; the first face is split and a cap is added
    c = next(v for v in F[on[0]] if v not in (a, b))
    i, j = (a, b) if (np.roll(F[on[0]], -1) == b)[np.flatnonzero(F[on[0]] == a)[0]] else (b, a)
    split = np.vstack((np.delete(F, on[0], axis=0), [[i, middle, c], [middle, j, c], [i, j, middle]]))
    V2 = np.vstack((V, (V[a] + V[b]) / 2))
    V2[F[2000, 0]] = V2[F[2000, 1]]
    with pytest.raises(MeshError, match="zero area"):
        unwrap(V2, split, strict=True)
    cleaned = clean(V2, split)
    assert igl.boundary_loop_all(cleaned.F) == []
    assert {r.kind for r in cleaned.repairs} == {"collapsed", "opened"}
    atlas = unwrapped(V2, split)
    assert atlas.good
    assert atlas.quality.stretch_l2 < plain.stretch_l2 + 0.05
    cap, beside = atlas.TC[atlas.FTC[-1]], np.ptp(atlas.TC, axis=0).max()
    assert abs(signed_areas(atlas)[-1]) < 0.1 * np.linalg.norm(cap[0] - cap[1]) ** 2 < beside**2


@pytest.mark.parametrize(("loose", "welded"), [(30, False), (210, True)])
def test_equal_positions_are_welded_where_most_of_the_boundary_coincides(loose: int, welded: bool) -> None:
    V, F = sphere()
    body, faces = igl.triangulated_grid(20, 20)
    body = np.column_stack((body + 3, np.zeros(len(body))))
    both = concatenate_surfaces((body, faces), soup(V, F[:loose]))
    cleaned = clean(*both)
    assert ("welded" in [repair.kind for repair in cleaned.repairs]) == welded
    places = len(np.unique(F[:loose])) if welded else 3 * loose
    assert len(np.unique(cleaned.merged)) == len(body) + places


def test_zero_and_minus_zero_are_the_same_position() -> None:
    V, F = sheet()
    apart, loose = soup(V * [1, 1, 0], F)
    apart[::2, 2] = -0.0
    apart[1::3] *= np.where(apart[1::3] == 0, -1.0, 1.0)
    assert len(clean(apart, loose).V) == len(V)


@pytest.mark.parametrize("turn", [0, 1, 2])
def test_a_cap_in_the_plane_is_opened_upright_and_a_piece_without_area_is_removed(turn: int) -> None:
    V, F = igl.triangulated_grid(5, 5)
    V, F = np.insert(V, 2, 0.0, axis=1), F.astype(np.int64)
    inside = np.flatnonzero(~np.isin(F, igl.boundary_loop(F)).any(axis=1))[0]
    a, b, c = np.roll(F[inside], turn)
    middle, lone = len(V), len(V) + 1 + np.arange(3)
    V = np.vstack((V, (V[a] + V[b]) / 2, np.outer([9.0, 10, 11], [1, 1, 1])))
    F = np.vstack((np.delete(F, inside, axis=0), [[a, middle, c], [middle, b, c], [a, b, middle], lone]))
    cleaned = clean(V, F)
    assert [(repair.kind, repair.first.tolist()) for repair in cleaned.repairs] == [
        ("arealess", [len(F) - 1]),
        ("opened", [len(F) - 2]),
    ]
    assert np.array_equal(cleaned.faces, np.arange(len(F) - 1))
    corner = cleaned.V[cleaned.F]
    assert (np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2] > 0).all()
    assert np.abs(cleaned.V - V[cleaned.origin]).max() < 0.1 * np.linalg.norm(V[a] - V[b]) / 2


def test_repairs_are_reported_by_one_warning_of_one_line() -> None:
    V, F = NASTY["one face turned"]()
    with pytest.warns(MeshWarning, match="the mesh is repaired: faces 7 are turned") as said:
        atlas = unwrap(V, F)
    assert len(said) == 1
    assert "\n" not in str(said[0].message)
    assert str(atlas.report.repairs[0]) in str(atlas)


def test_clean_meshes_are_returned_unchanged() -> None:
    for V, F in (igl.icosahedron(), load("disk__igl_snail.obj"), *(NASTY[name]() for name in CLEAN)):
        cleaned = clean(V, F)
        assert cleaned.repairs == ()
        assert (cleaned.V == V).all()
        assert (cleaned.F == F).all()
        one, two = unwrap(V, F), unwrap(V, F, strict=True)
        assert (one.TC == two.TC).all()
        assert (one.FTC == two.FTC).all()


@pytest.mark.parametrize("power", [-1070, -1000, 1000, 1023])
def test_a_surface_of_any_size_has_the_atlas_of_its_shape(power: int) -> None:
    V, F = igl.icosahedron()
    V = np.round(V * 8) / 8  # multiples of 1/8, which are exact after scaling by any power of two
    plain = unwrap(V, F[1:])
    with pytest.warns(MeshWarning, match="scaled by a power of two"):
        atlas = unwrap(np.ldexp(V, power), F[1:])
    assert atlas.good
    assert np.allclose(atlas.TC, plain.TC)
    with np.errstate(over="ignore"):  # an overflow gives infinity
        assert np.isclose(atlas.report.scale, np.ldexp(plain.report.scale, -power))
        assert np.isclose(atlas.seam_length, np.ldexp(plain.seam_length, power))
    density = 1e-300 if power < 0 else 1e300
    with pytest.warns(MeshWarning), pytest.raises(MeshError, match=r"out of all proportion.*: change"):
        unwrap(np.ldexp(V, power), F[1:], packing=Packing(resolution=64, texel_density=density))


def test_only_coordinates_that_are_not_finite_are_rejected() -> None:
    V, F = sphere(0)
    V[3] = np.nan
    with pytest.raises(MeshError, match="vertices 3 are NaN or infinite"):
        unwrap(V, F)
    assert unwrap(V, F[(F != 3).all(axis=1)]).good


@pytest.mark.parametrize("name", ["closed__igl_cow.off", "closed__optcuts_horse_f10000.obj"])
def test_a_body_with_a_small_hole_is_cut_because_of_its_stretch(name: str) -> None:
    V, F = load(name)
    atlas = unwrap(V, F[1:])
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.3
    assert flatten(V, F[1:]).uv.shape == (len(V), 2)  # flattening is possible, but its stretch exceeds 150


def test_tips_that_would_shrink_get_a_seam() -> None:
    V, F = load("closed__igl_cow.off")
    assert quality(*flat_with(V, F, find_seams(V, F))).stretch_l2 > 1.25  # ears and horns shrink
    assert unwrap(V, F).quality.stretch_l2 < 1.2


def flat_with(V: np.ndarray, F: np.ndarray, seams: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    V, F, _ = cut(V, F, seams)
    return V, F, flatten(V, F).uv


@pytest.mark.parametrize(
    "name", ["disk__bff_hemisphere.obj", "disk__igl_lilium.obj", "disk__igl_camel_b.obj"]
)
def test_a_disk_that_would_gain_little_is_not_cut(name: str) -> None:
    V, F = load(name)
    uncut = unwrap(V, F, charts=ChartOptions(trade=0), weld=False)  # the camel was cut open along a path
    roomy = Packing(resolution=2048, texel_density=1)  # so large that no chart is cut
    assert unwrap(V, F, weld=False, packing=roomy).seam_length == uncut.seam_length


def test_the_stretch_of_each_chart_is_bounded_on_request() -> None:
    V, F = load("closed__igl_cow.off")
    for most in (1.2, 1.05):
        atlas = unwrap(V, F, charts=ChartOptions(max_stretch=most))
        assert atlas.good
        assert max(chart.quality.stretch_l2 for chart in atlas.charts) <= most * (1 + 1e-9)
    assert len(atlas.charts) < 60
    with pytest.raises(ValueError, match=r"max_stretch is 0\.5"):
        unwrap(V, F, charts=ChartOptions(max_stretch=0.5))


def test_cuts_for_a_fuller_page_respect_the_bound_of_the_stretch() -> None:
    """A part of a chart can have a larger stretch than the whole chart."""
    dome = pyvista.ParametricBohemianDome(u_res=30, v_res=30, w_res=10).triangulate().clean()
    V, F = np.asarray(dome.points, dtype=np.float64), dome.faces.reshape(-1, 4)[:, 1:]
    for packing in (None, Packing(resolution=100, padding=0)):
        atlas = unwrap(V, F, charts=ChartOptions(max_stretch=1.05), packing=packing)
        assert not atlas.troubles
        assert max(chart.quality.stretch_l2 for chart in atlas.charts) <= 1.05 * (1 + 1e-9)


def test_given_seams_can_be_extended() -> None:
    V, F = load("closed__igl_3holes.off")
    mine = F[:1, :2]
    with pytest.raises(MeshError, match="extend=True"):
        unwrap(V, F, mine)
    atlas = unwrap(V, F, mine, charts=ChartOptions(extend=True))
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.3
    V, F = load("closed__igl_cow.off")
    begun = find_seams(V, F, trade=0)
    with pytest.warns(OutcomeWarning, match="L2 stretch of .* beyond 10"):
        short = unwrap(V, F, begun, method="linabf")
    assert not short.good
    whole = unwrap(V, F, begun, charts=ChartOptions(extend=True), method="linabf")
    assert whole.good
    assert whole.quality.stretch_l2 < 1.4
    cut = {tuple(e) for e in np.sort(whole.seams, axis=1).tolist()}
    assert cut >= {tuple(e) for e in np.sort(short.seams, axis=1).tolist()}


def test_given_seams_refer_to_the_mesh_before_its_repair() -> None:
    V, F = sheet()
    line = np.flatnonzero(V[:, 1] == 4)
    seams = np.column_stack((line[:-1], line[1:]))
    turned = np.vstack((F[:5], F[5:9, ::-1], F[9:]))
    loose = soup(V, turned)
    assert len(unwrapped(V, turned, seams=seams).charts) == 2
    mask = np.isin(turned, line) & np.isin(turned[:, [1, 2, 0]], line)
    assert len(unwrapped(*loose, seams=mask).charts) == 2
    below = mask & (V[turned].mean(axis=1)[:, 1:2] < 4)  # marking one side of each seam edge suffices
    assert len(unwrapped(*loose, seams=below).charts) == 2


def test_randomly_damaged_meshes_are_repaired() -> None:
    for seed in range(60):
        check_any(seed)


def test_the_command_repairs_a_soup_unless_it_is_strict(tmp_path) -> None:
    V, F = sphere()
    mesh, out = tmp_path / "in.obj", tmp_path / "out.obj"
    igl.write_triangle_mesh(
        str(mesh), *merge_equal_vertices(*concatenate_surfaces((V, F), (V + np.array([3, 0, 0]), F)))
    )
    V, F = igl.read_triangle_mesh(str(mesh))
    F[7] = F[7, ::-1]
    igl.write_triangle_mesh(str(mesh), V, F)
    process = run("unwrap", mesh, "-o", out, "--max-stretch", "1.1", "--weld", "1e-9")
    assert process.returncode == 0, process.stderr
    assert "faces 7 are turned" in process.stderr
    assert len(process.stderr.splitlines()) == 1
    assert (read_texture(out)[1] >= 0).all()
    process = run("unwrap", mesh, "-o", out, "--strict")
    assert process.returncode == 2
    assert "igl_linabf.clean" in process.stderr
