"""Cones: angle sums, seams with matching sides, and invariances of the maps."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations, product
from pathlib import Path

import igl
import numpy as np
import pytest
import pyvista as pv
from conftest import load
from hard_surfaces import plate_with_holes
from nasty_meshes import NASTY, concatenate_surfaces, voxels
from scipy.spatial import cKDTree

from igl_linabf import (
    ABF,
    Atlas,
    ChartOptions,
    Cones,
    LinABF,
    MeshError,
    OutcomeWarning,
    Packing,
    find_seams,
    overlaps,
    quality,
    unwrap,
)
from igl_linabf.angles import build_constraints, compute_rescaled_angles, residual
from igl_linabf.charts import find_cones, texture_seams
from igl_linabf.charts.cones.seams import find_closed_paths, find_seam
from igl_linabf.charts.cut_graphs.closed_surface import ClosedSurface
from igl_linabf.charts.packing.spacing import Spacing
from igl_linabf.charts.periodic.lattice import find_nearest_integers
from igl_linabf.cli import main
from igl_linabf.io import read_texture
from igl_linabf.surface import Submesh

CLOSED = ("pial", "closed__igl_cow.off", "closed__optcuts_horse_f10000.obj", "closed__igl_fandisk.off")
HANDLES = ("nut", "double_torus", "closed__igl_3holes.off", "handles__bff_punctured-torus.obj")
BOUNDED = ("ball", "crown", "punctured_nut", "stress__optcuts_duck1.obj", "holes__igl_halftunnel.off")
ALL = CLOSED + HANDLES + BOUNDED
SEVERAL = ("ant", "multi__bff_teapot.obj")  # meshes of several components

Surface = tuple[np.ndarray, np.ndarray]


def cube(n: int, size: tuple[float, float, float] = (1, 1, 1)) -> Surface:
    """Return a box with n by n squares per side, each split into four triangles."""
    t = np.linspace(-1, 1, 2 * n + 1)
    even = np.arange(0, 2 * n, 2)
    x, y = (i.ravel() for i in np.meshgrid(even, even, indexing="ij"))
    square = np.array([[0, 0], [2, 0], [2, 2], [0, 2]])
    flat = [[(x + dx, y + dy) for dx, dy in (square[k], square[k - 3], (1, 1))] for k in range(4)]
    uv = t[np.array(flat)].transpose(0, 3, 1, 2).reshape(-1, 2)
    sides = []
    for axis in range(3):
        for sign in (-1, 1):
            side = np.full((len(uv), 3), float(sign))
            side[:, axis - 2], side[:, axis - 1] = uv[:, 0] * sign, uv[:, 1]
            sides.append(side)
    V, F = np.unique(np.concatenate(sides).round(12), axis=0, return_inverse=True)
    return V * size, F.reshape(-1, 3)


def corners_of(V: np.ndarray) -> np.ndarray:
    return np.flatnonzero((np.abs(V) == np.abs(V).max(axis=0)).all(axis=1))


def collect_angles(atlas: Atlas) -> np.ndarray:
    """Return the target angles of all faces of an atlas."""
    angles = np.empty(atlas.FTC.shape)
    for chart in atlas.charts:
        angles[chart.faces] = chart.result.angles
    return angles


def collect_seam_sides(atlas: Atlas, F: np.ndarray) -> np.ndarray:
    """Return the two sides of each seam edge in the map as complex vectors, (2, #E)."""
    side = {}
    for t in range(len(F)):
        for k in range(3):
            a, b = atlas.TC[atlas.FTC[t, [k, (k + 1) % 3]]] @ [1, 1j]
            side[F[t, k], F[t, (k + 1) % 3]] = b - a
    return np.array([(side[i, j], -side[j, i]) for i, j in atlas.seams.tolist()]).reshape(-1, 2).T


def free(V: np.ndarray, F: np.ndarray, atlas: Atlas) -> Atlas:
    """Return the atlas along the same seams with a free boundary."""
    return unwrap(V, F, atlas.seams)


@pytest.mark.parametrize("how", [None, "quarter"])
@pytest.mark.parametrize("name", ALL + SEVERAL)
def test_angle_sums_are_reached_and_seams_match(name: str, how: str | None) -> None:
    V, F = load(name)
    atlas = unwrap(V, F, cones=Cones(find_cones(V, F), angles=how))
    assert not atlas.quality.flips
    total = np.bincount(F.ravel(), weights=collect_angles(atlas).ravel(), minlength=len(V))
    asked = np.full(len(V), 2 * np.pi)
    asked[atlas.report.cones] = atlas.report.cone_angles
    inside = np.setdiff1d(F, igl.boundary_facets(F)[0])
    assert np.abs(total - asked)[inside].max() <= 1e-8
    a, b = collect_seam_sides(atlas, F)
    assert np.abs(np.log(np.abs(a) / np.abs(b))).max(initial=0) <= 1e-6
    assert atlas.report.seam_mismatch == pytest.approx(
        np.abs(np.log(np.abs(a) / np.abs(b))).max(initial=0), abs=1e-9
    )
    if how == "quarter":
        turns = np.angle(b / a) / (np.pi / 2)
        assert np.abs(turns - np.round(turns)).max(initial=0) <= 1e-6
        quarters = atlas.report.cone_angles / (np.pi / 2)
        assert np.abs(quarters - np.round(quarters)).max(initial=0) <= 1e-12
        assert (atlas.report.cone_angles > 1.5).all()


@pytest.mark.parametrize(
    "name",
    ("pial", "nut", "double_torus", "crown", "closed__igl_fandisk.off", "closed__igl_3holes.off", SEVERAL[1]),
)
def test_a_periodic_texture_continues_across_quarter_seams(name: str) -> None:
    V, F = load(name)
    period = 1 / 200
    given = Cones(find_cones(V, F), angles="quarter")
    atlas = unwrap(V, F, cones=replace(given, period=period))
    assert atlas.good and not atlas.quality.flips
    assert atlas.report.seam_mismatch <= 1e-9
    # at both ends of a seam edge, a quarter turn and whole periods map one side to the other
    at = {}
    for vertices, places in zip(F.tolist(), atlas.TC[atlas.FTC] @ [1, 1j], strict=True):
        at.update({(vertices[k - 1], vertices[k]): places[[k - 1, k]] for k in range(3)})
    one, other = (
        np.array([at[i, j] for i, j in ends.tolist()]) for ends in (atlas.seams, atlas.seams[:, ::-1])
    )
    other = other[:, ::-1]
    turn = (other[:, 1] - other[:, 0]) / (one[:, 1] - one[:, 0])
    quarter = np.exp(0.5j * np.pi * np.round(np.angle(turn) / (np.pi / 2)))
    assert np.abs(turn - quarter).max() <= 1e-9
    shift = (other - quarter[:, None] * one) / period
    assert np.abs(shift - np.round(shift)).max() <= 1e-9
    assert len(np.unique(np.round(shift))) > 2
    # a period increases the distortion of a map only slightly
    free = unwrap(V, F, cones=given, packing=Packing(margin=0.01))
    assert atlas.quality.angle_distortion <= 1.05 * free.quality.angle_distortion
    assert atlas.quality.stretch_l2 == pytest.approx(free.quality.stretch_l2, rel=0.01)


def test_nearest_integers_minimize_the_quadratic_form() -> None:
    rng = np.random.default_rng(0)
    even = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 4), axis=-1).reshape(-1, 2, 2) @ [1, 1j]
    for _ in range(50):
        A = np.eye(2) + rng.uniform(-0.4, 0.4, (2, 2, 2)) @ [1, 1j]
        wanted = rng.uniform(-0.5, 0.5, (2, 2)) @ [1, 1j]
        off = (np.concatenate((even, find_nearest_integers(A.conj().T @ A, wanted)[None])) - wanted) @ A.T
        costs = (np.abs(off) ** 2).sum(axis=1)
        assert costs[-1] <= costs.min() + 1e-12
    # with 30 numbers, the result is far better than rounding each number separately
    A = rng.normal(size=(30, 30, 2)) @ [1, 1j]
    wanted = rng.uniform(-9, 9, (30, 2)) @ [1, 1j]
    q = find_nearest_integers(A.conj().T @ A, wanted)
    assert (q == np.round(q)).all()
    assert np.linalg.norm(A @ (q - wanted)) < np.linalg.norm(A @ (np.round(wanted) - wanted)) / 1.5


@pytest.mark.filterwarnings("ignore::igl_linabf.OutcomeWarning")  # parts of the map may touch
def test_a_period_that_flips_triangles_is_refused_with_a_feasible_one() -> None:
    V, F = load("closed__optcuts_horse_f10000.obj")
    with pytest.raises(MeshError, match=r"triangles of chart .* would flip") as raised:
        unwrap(V, F, cones=Cones("auto", angles="quarter", period=0.15))
    enough = float(str(raised.value).split("use ")[-1].split(",")[0])
    assert not unwrap(V, F, cones=Cones("auto", angles="quarter", period=enough)).quality.flips


def test_unused_vertices_do_not_change_maps_with_a_period() -> None:
    V, F = load("closed__igl_fandisk.off")
    given = Cones(10, angles="quarter", period=1 / 100)
    atlas = unwrap(V, F, cones=given)
    among = unwrap(np.vstack((np.full((4321, 3), np.nan), V)), F + 4321, cones=given)
    assert (among.report.cones == atlas.report.cones + 4321).all()
    assert np.abs(among.TC - atlas.TC).max() < 1e-9


def test_components_do_not_affect_each_others_period() -> None:
    V, F = load("closed__igl_fandisk.off")
    sheet = np.array([[9.0, 0, 0], [10, 0, 0], [9, 1, 0]]), np.array([[0, 1, 2]])
    given = Cones("auto", angles="quarter", period=1 / 500)
    assert unwrap(*sheet, cones=given).good
    atlas = unwrap(*concatenate_surfaces((V, F), sheet, (V + np.array([0, 5, 0]), F)), cones=given)
    assert atlas.good and atlas.report.seam_mismatch < 1e-8
    assert (
        atlas.report.cones[: len(atlas.report.cones) // 2] + len(V) + 3
        == atlas.report.cones[len(atlas.report.cones) // 2 :]
    ).all()


def test_charts_that_a_period_moves_stay_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    surface = concatenate_surfaces(*((V + 3 * k, F) for k in range(8)))
    given = Cones("auto", angles="quarter", period=1 / 50)
    asked: list[float] = []
    wider = Spacing.widen

    def small_at_first(spacing: Spacing, by: float) -> Spacing:
        asked.append(by)
        return wider(spacing, 0.0 if len(asked) == 1 else by)

    monkeypatch.setattr(Spacing, "widen", small_at_first)
    atlas = unwrap(*surface, cones=given, packing=Packing(resolution=256, padding=2))
    assert asked == [0.02, 0.04]
    corners = atlas.TC[atlas.FTC]
    for i, j in zip(*np.triu_indices(len(atlas.charts), 1), strict=True):
        one, other = (corners[atlas.chart == k].reshape(-1, 2) for k in (i, j))
        assert cKDTree(one).query(other)[0].min() > 2 / 256 * (1 - 1e-6)
    assert not len(overlaps(atlas.TC, atlas.FTC, between=True))


def test_the_default_margin_grows_until_a_period_moves_no_chart_onto_another() -> None:
    surface = concatenate_surfaces(*(igl.upsample(*igl.icosahedron(), 3) for _ in range(6)))
    given = Cones(12, angles="quarter", period=0.03)
    default, same = (
        unwrap(*surface, cones=given, packing=packing) for packing in (None, Packing(margin=0.005))
    )
    assert default.report.scale == same.report.scale
    assert not len(overlaps(default.TC, default.FTC, between=True))


def test_triangles_between_three_cones_can_have_a_period() -> None:
    V, F = igl.icosahedron()
    atlas = unwrap(V, F, cones=Cones(np.arange(12), angles="quarter", period=1 / 100))
    assert atlas.good
    assert atlas.report.seam_mismatch < 1e-8


@pytest.mark.parametrize("method", ["linabf", "abf"])
def test_a_tube_without_interior_vertices_turns_by_quarters(method: str) -> None:
    i, j = np.arange(20), np.roll(np.arange(20), -1)
    angle = 2 * np.pi * i / 20
    low, high = (np.column_stack((r * np.cos(angle), r * np.sin(angle), 2.5 - r + 0 * i)) for r in (2, 1))
    F = np.vstack((np.column_stack((i, j, j + 20)), np.column_stack((i, j + 20, i + 20))))
    V = np.vstack((low, high))
    atlas = unwrap(V, F, method=method, cones=Cones("auto", angles="quarter", period=1 / 100))
    # no cones, but the two sides of the seam differ by a quarter turn
    assert atlas.good and not len(atlas.report.cones)
    assert atlas.report.seam_mismatch < 1e-8


@pytest.mark.parametrize("asked", [{}, {"at": 4}, {"at": 4, "angles": "quarter", "period": 0.0}])
def test_a_period_needs_quarter_cones(asked: dict[str, object]) -> None:
    V, F = load("pial")
    with pytest.raises(ValueError, match="period is"):
        unwrap(V, F, cones=Cones(**{"period": 0.01, **asked}))


def test_a_period_with_other_angles_is_refused() -> None:
    V, F = load("pial")
    with pytest.raises(MeshError, match="no multiple of 90 degrees"):
        unwrap(V, F, cones=Cones(find_cones(V, F, 6), angles=np.full(6, 4 * np.pi / 3), period=0.01))


@pytest.mark.parametrize("how", [None, "quarter"])
@pytest.mark.parametrize("name", ("pial", "nut", *CLOSED[2:], "closed__igl_3holes.off"))
def test_curvatures_obey_gauss_bonnet(name: str, how: str | None) -> None:
    V, F = load(name)
    atlas = unwrap(V, F, cones=Cones(10, angles=how))
    chi = len(V) - 3 * len(F) // 2 + len(F)
    assert (2 * np.pi - atlas.report.cone_angles).sum() == pytest.approx(2 * np.pi * chi, abs=1e-9)
    assert len(atlas.report.cones) == 10


@pytest.mark.parametrize("name", ("pial", "closed__optcuts_horse_f10000.obj", "stress__optcuts_duck1.obj"))
def test_a_free_boundary_on_the_same_seam_does_not_match(name: str) -> None:
    V, F = load(name)
    atlas = unwrap(V, F, cones=12)
    assert free(V, F, atlas).report.seam_mismatch > 0.01


@pytest.mark.parametrize("name", ("pial", "closed__igl_cow.off", "closed__optcuts_horse_f10000.obj"))
def test_more_cones_save_stretch(name: str) -> None:
    V, F = load(name)
    dear, cheap = (find_cones(V, F, cones_per_stretch=number) for number in (5, 50))
    assert 3 <= len(dear) < len(cheap)
    assert cheap[: len(dear)].tolist() == dear.tolist()
    few, many = (unwrap(V, F, cones=cones).quality.stretch_l2 for cones in (dear, cheap))
    assert 1 < many < few
    assert many < 1.6


def test_a_box_becomes_its_net() -> None:
    V, F = cube(6, (1, 2, 3))
    atlas = unwrap(V, F, cones=Cones(corners_of(V), angles="quarter"))
    assert np.allclose(atlas.report.cone_angles, 3 * np.pi / 2)
    assert atlas.quality.angle_distortion <= 1e-16
    assert atlas.quality.stretch_l2 == pytest.approx(1, abs=1e-9)


def test_a_sphere_with_the_cones_of_a_cube_keeps_its_symmetry() -> None:
    V, F = cube(8)
    corners = corners_of(V)
    V /= np.linalg.norm(V, axis=1)[:, None]
    assert np.allclose(unwrap(V, F, cones=corners).report.cone_angles, 3 * np.pi / 2)
    exact = unwrap(V, F, method=LinABF(rtol=1e-12), cones=Cones(corners, angles=np.full(8, 1.5 * np.pi)))
    angles, middle, corner = collect_angles(exact), V[F].mean(axis=1), V[F]
    turns = [
        np.eye(3)[list(order)] * signs
        for order in permutations(range(3))
        for signs in product((-1, 1), repeat=3)
    ]
    turns = [turn for turn in turns if np.linalg.det(turn) > 0]
    assert len(turns) == 24
    for turn in turns:
        image = cKDTree(middle).query(middle @ turn.T)[1]
        gap = np.linalg.norm((corner @ turn.T)[:, :, None] - corner[image][:, None], axis=3)
        assert gap.min(axis=2).max() <= 1e-9
        turned = np.take_along_axis(angles[image], gap.argmin(axis=2), axis=1)
        assert np.abs(turned - angles).max() <= 1e-8


def test_a_tube_closed_by_cones_keeps_its_length() -> None:
    """A flattened cylinder that is sewn up at both ends has two cones of 180 degrees at each end."""
    around, rows = 32, 50
    side = 2 * np.pi / around
    i, k = np.arange(rows + 1)[:, None], np.arange(around)
    V = np.stack(np.broadcast_arrays(np.cos(side * k), np.sin(side * k), side * i), axis=2).reshape(-1, 3)
    a, b = (around * i[:-1] + k).ravel(), (around * i[:-1] + (k + 1) % around).ravel()
    F = np.concatenate((np.column_stack((a, b, b + around)), np.column_stack((a, b + around, a + around))))
    same = np.arange(len(V))
    for first in (0, around * rows):
        same[first + k] = first + np.minimum(k, -k % around)
        V[first + k, 1] = 0
    cones = [first + half for first in (0, around * rows) for half in (0, around // 2)]
    atlas = unwrap(V, same[F], cones=Cones(cones, angles=np.full(4, np.pi)))
    assert atlas.report.seam_mismatch <= 1e-6
    row, z = F // around, atlas.TC[atlas.FTC] @ [1, 1j]
    length = np.abs(np.roll(z, -1, axis=1) - z)
    along = (row != np.roll(row, -1, axis=1)) & (F % around == np.roll(F, -1, axis=1) % around)
    far = ((row > 12) & (row < rows - 12)).all(axis=1)[:, None]  # edges farther than two radii from both ends
    assert length[far & along].mean() * around == pytest.approx(
        length[far & (row == np.roll(row, -1, axis=1))].mean() * around, rel=5e-3
    )


@pytest.mark.parametrize("name", ("pial", "nut", "stress__optcuts_duck1.obj"))
def test_maps_with_cones_do_not_depend_on_position_scale_or_numbering(name: str) -> None:
    V, F = load(name)
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    new, order = rng.permutation(len(V)), rng.permutation(len(F))
    moved = np.empty_like(V)
    moved[new] = 1e3 * V @ (turn * np.linalg.det(turn)).T + 7
    cones = find_cones(V, F)
    assert np.sort(find_cones(moved, new[F][order])).tolist() == np.sort(new[cones]).tolist()
    exact = LinABF(rtol=1e-11)
    a = unwrap(V, F, method=exact, cones=cones)
    b = unwrap(moved, new[F][order], method=exact, cones=new[cones])
    assert np.abs(a.report.cone_angles - b.report.cone_angles).max(initial=0) <= 1e-8
    assert np.abs(collect_angles(b) - collect_angles(a)[order]).max() <= 1e-7


@pytest.mark.parametrize("name", ["pial", "double_torus", "closed__igl_3holes.off", "crown"])
def test_reusing_the_factor_of_the_cones_does_not_change_the_map(name: str) -> None:
    V, F = load(name)
    cones = find_cones(V, F, 8)
    known = unwrap(V, F, cones=cones)
    anew = unwrap(V, F, cones=Cones(cones, angles=known.report.cone_angles))
    assert known.quality.angle_distortion == pytest.approx(anew.quality.angle_distortion, rel=5e-3)
    assert known.report.seam_mismatch <= 1e-6


def test_converged_abf_supports_cones() -> None:
    V, F = load("pial")
    cones = find_cones(V, F, 12)
    linear, converged = (unwrap(V, F, method=method, cones=cones) for method in ("linabf", ABF()))
    assert converged.report.seam_mismatch <= 1e-6
    assert converged.quality.angle_distortion < linear.quality.angle_distortion


def test_a_long_horn_gets_a_cone_despite_its_narrow_angle() -> None:
    horn = pv.ParametricConicSpiral(u_res=40, v_res=40, w_res=40).triangulate().clean()
    V, F = np.asarray(horn.points, dtype=float), horn.regular_faces
    atlas = unwrap(V, F, cones="auto")  # without a cone, the L2 stretch is above 1e5
    assert atlas.good and 0 < len(atlas.report.cones) < 5
    assert atlas.quality.stretch_l2 < 1.5


def test_overlapping_charts_are_split_and_still_match() -> None:
    V, F = load("closed__igl_3holes.off")
    atlas = unwrap(V, F, cones=6)
    assert len(atlas.charts) > 1
    assert not any(chart.overlapping for chart in atlas.charts)
    assert atlas.report.seam_mismatch <= 1e-6


@pytest.mark.parametrize("name", ("nut", "double_torus", "closed__igl_3holes.off"))
def test_turning_handles_by_quarters_costs_little(name: str) -> None:
    V, F = load(name)
    cones = find_cones(V, F, 16)
    free, quarter = (unwrap(V, F, cones=Cones(cones, angles=how)).quality for how in (None, "quarter"))
    # the ratio is 14 on 3holes if the angles of the cones are chosen only for little stretch
    assert quarter.angle_distortion < 5 * free.angle_distortion
    assert quarter.stretch_l2 < 1.1 * free.stretch_l2


def test_scaled_triangles_close_around_vertices_and_along_handles() -> None:
    surface = Submesh.manifold_from_input(*load("nut"))
    piece = ClosedSurface.from_submesh(surface)
    paths = find_closed_paths(surface, piece.graph, find_seam(piece, np.zeros(0, dtype=np.int64)))
    corners = surface.V[surface.F.T]
    length = np.linalg.norm(np.roll(corners, -1, axis=0) - np.roll(corners, -2, axis=0), axis=2)
    u = 0.3 * np.sin(3 * surface.V / np.ptp(surface.V)).sum(axis=1)
    alpha, impossible = compute_rescaled_angles(surface.topology, length, u)
    assert len(paths) == 2 and not impossible.any()
    missing = residual(build_constraints(surface.topology, paths=paths), alpha)
    assert max(np.abs(missing.wheel).max(), np.abs(missing.holonomy.gap.real).max()) < 1e-10
    # the angles are far from flat, and far from the angles of the surface
    assert np.abs(missing.vertex).max() > 0.01
    assert np.abs(alpha - compute_rescaled_angles(surface.topology, length, 0 * u)[0]).max() > 0.01


@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning")  # warns that a one-sided surface is cut open
@pytest.mark.parametrize("asked", [{}, {"angles": "quarter"}, {"angles": "quarter", "period": 0.01}])
@pytest.mark.parametrize("name", ["a one sided band", "a bottle without an inside", "a projective plane"])
def test_one_sided_surfaces_can_have_cones(name: str, asked: dict[str, object]) -> None:
    for cones in ("auto", 3):
        atlas = unwrap(*NASTY[name](), cones=Cones(cones, **asked))
        assert atlas.good and not atlas.quality.flips
        assert atlas.report.seam_mismatch <= 1e-6


def test_mismatched_seams_of_cones_are_reported() -> None:
    atlas = unwrap(*cube(3), cones=8)
    assert atlas.good
    report = replace(atlas.report, seam_mismatch=np.log(1.5))
    assert "a factor of up to 1.5" in " ".join(replace(atlas, report=report).troubles)


def test_mismatched_seams_are_reported_without_cones() -> None:
    V, F = load("nut")
    with pytest.warns(OutcomeWarning, match="sides of seams do not match.*: give more cones"):
        atlas = unwrap(V, F, method=LinABF(iterations=1), cones=0)
    assert not len(atlas.report.cones) and not atlas.quality.flips
    assert not unwrap(V, F, atlas.seams).troubles  # without cones, sides need not match


def test_a_torus_needs_no_cone() -> None:
    V, F = load("nut")
    atlas = unwrap(V, F, cones=0)
    assert len(atlas.report.cones) == 0 and atlas.report.seam_mismatch <= 1e-6
    assert "converged" in str(atlas.charts[0].result)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::igl_linabf.OutcomeWarning")  # some spikes shrink in the map
def test_all_of_many_limbs_get_cones() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 5)
    V /= np.linalg.norm(V, axis=1)[:, None]
    k = np.arange(120) + 0.5
    polar, around = np.arccos(1 - k / 60), np.pi * (1 + np.sqrt(5)) * k
    tips = np.column_stack((np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)))
    away = np.arccos(np.clip(V @ tips.T, -1, 1))
    V *= 1 + 1.5 * np.exp(-360 * away.min(axis=1, keepdims=True) ** 2)
    cones = find_cones(V, F)
    assert 120 < len(cones) < 400
    assert (away[cones].min(axis=0) < 0.1).all()  # each tip has a cone nearby
    assert unwrap(V, F, cones=cones).quality.stretch_l2 < 10


def sieve() -> Surface:
    """Return a closed square plate with 4 x 4 square holes, of genus 16."""
    full = np.ones((9, 9, 1), dtype=bool)
    full[1::2, 1::2] = False
    return igl.upsample(*voxels(full), 1)


def test_few_quarter_cones_share_the_curvature_of_many_handles() -> None:
    atlas = unwrap(*sieve(), cones=Cones(30, angles="quarter"))
    assert not atlas.quality.flips and atlas.report.seam_mismatch <= 1e-8
    assert atlas.quality.stretch_l2 < 3


@pytest.mark.filterwarnings("ignore::igl_linabf.FallbackWarning")  # intermediate steps use fallbacks
def test_infeasible_cones_are_refused_with_advice() -> None:
    with pytest.raises(MeshError, match=r"no map with the 16 cones .* was found: give more cones"):
        unwrap(*plate_with_holes(12), cones=Cones(16, angles="quarter"))


@pytest.mark.filterwarnings("ignore::igl_linabf.FallbackWarning")
def test_diverging_quarter_cones_are_refused_before_other_steps_are_tried() -> None:
    with pytest.raises(MeshError, match=r"no map with the 20 cones .* \(steps lead to angle sums \d+ away"):
        unwrap(*plate_with_holes(20), cones=Cones(20, angles="quarter"))


# maps with the fewest cones may cause warnings
@pytest.mark.filterwarnings("ignore::igl_linabf.OutcomeWarning")
def test_cones_that_are_found_have_feasible_angles() -> None:
    V, F = sieve()
    assert igl.euler_characteristic(F) == 2 - 2 * 16
    cones = find_cones(V, F)
    for how in (None, "quarter"):
        assert unwrap(V, F, cones=Cones(cones, angles=how)).quality.stretch_l2 < 10
    with pytest.raises(MeshError, match=r"too few.*give at least \d+$") as error:
        find_cones(V, F, 4)
    enough = int(str(error.value).split()[-1])
    assert len(unwrap(V, F, cones=enough).report.cones) == enough <= len(cones)


def test_excess_quarter_turns_are_spread_over_all_cones() -> None:
    V, F = load("closed__igl_3holes.off")
    cones = find_cones(V, F)[:2]
    with pytest.raises(MeshError, match=r"give more cones near vertices .*, or other angles$"):
        unwrap(V, F, cones=Cones(cones, angles="quarter"))


def test_cones_of_a_repaired_mesh_are_the_given_vertices() -> None:
    V, F = cube(3)
    soup = V[F].reshape(-1, 3)
    corners = corners_of(V)
    given = np.array([np.flatnonzero((soup == V[i]).all(axis=1))[-1] for i in corners])
    with pytest.warns(UserWarning, match="welded"):
        atlas = unwrap(soup, np.arange(len(soup)).reshape(-1, 3), cones=Cones(given, angles="quarter"))
    assert (np.sort(soup[atlas.report.cones], axis=0) == np.sort(V[corners], axis=0)).all()
    assert atlas.quality.stretch_l2 == pytest.approx(1, abs=1e-9)


def test_invalid_cones_are_refused_with_valid_numbers() -> None:
    V, F = cube(3)
    corners = corners_of(V)
    with pytest.raises(MeshError, match=r"have to sum to 37\.69.*change them by \+12\.56"):
        unwrap(V, F, cones=Cones(corners, angles=np.full(8, np.pi)))
    with pytest.raises(MeshError, match=r"sum to 2160 rad.*from degrees to radians"):
        unwrap(V, F, cones=Cones(corners, angles=np.full(8, 270)))
    with pytest.raises(MeshError, match=r"no cones are too few .* give at least 3"):
        unwrap(*concatenate_surfaces((V, F), (V + 5, F)), cones=corners)
    with pytest.raises(ValueError, match="at most a half"):
        unwrap(V, F, cones=Cones(8, angles="quarter", period=0.9))
    with pytest.raises(ValueError, match="not positive"):
        unwrap(V, F, cones=Cones(corners[:3], angles=[0.0, np.pi, np.pi]))
    with pytest.raises(MeshError, match=r"too few.*give at least 3"):
        unwrap(V, F, cones=corners[:2])
    with pytest.raises(MeshError, match="give at least 3"):
        find_cones(V, F, 2)
    with pytest.raises(MeshError, match="on the boundary"):
        unwrap(V, F[1:], cones=F[0, :1])
    with pytest.raises(MeshError, match="not within"):
        unwrap(V, F, cones=[len(V)])
    with pytest.raises(MeshError, match="each once"):
        unwrap(V, F, cones=[0, 0, 1, 2])
    with pytest.raises(MeshError, match="within 0 and 6 pi"):
        middle = next(i for i in range(len(V)) if np.count_nonzero(i == F) == 6)
        unwrap(V, F, cones=Cones([middle, *corners[1:6]], angles=[7 * np.pi, *np.full(5, np.pi / 5)]))
    with pytest.raises(ValueError, match="cones= and seams= do not go together"):
        unwrap(V, F, find_seams(V, F), cones=corners)
    with pytest.raises(ValueError, match="cones= and trade= do not go together"):
        unwrap(V, F, charts=ChartOptions(trade=1), cones=corners)
    with pytest.raises(ValueError, match="yet to be found"):
        Cones(8, angles=np.full(8, 1.5 * np.pi))
    with pytest.raises(ValueError, match="'linabf' or 'abf'"):
        unwrap(V, F, method="lscm", cones=corners)


def test_the_command_takes_cones(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    V, F = cube(3)
    mesh, out, cones, angles = (
        tmp_path / name for name in ("cube.obj", "out.obj", "cones.txt", "angles.txt")
    )
    igl.writeOBJ(str(mesh), V, F)
    np.savetxt(cones, corners_of(V), fmt="%d")
    np.savetxt(angles, np.full(8, 270.0))
    for given in (
        ["8"],
        ["auto"],
        [str(cones), "--cone-angles", "quarter"],
        [str(cones), "--cone-angles", str(angles)],
    ):
        assert main(["unwrap", str(mesh), "-o", str(out), "--cones", *given]) == 0
        assert "the sides of seams are equally long to" in capsys.readouterr().out
    TC, FTC = read_texture(out)
    cut = unwrap(V, F, texture_seams(F, FTC))
    assert quality(V[cut.origin], cut.FTC, cut.TC).stretch_l2 == pytest.approx(1, abs=1e-6)
    assert np.isfinite(TC).all()
