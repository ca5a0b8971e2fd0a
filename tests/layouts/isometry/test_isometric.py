"""The isometric map has no flips, has less energy than SLIM, and does not depend on position."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import best_fit_distance, bumps, load
from own_measures import count_flipped_exactly

from igl_linabf import ChartOptions, Isometric, flatten, flatten_many, isometric, quality, unwrap
from igl_linabf.cli import main
from igl_linabf.layouts import embed_in_circle, make_isometric
from igl_linabf.linalg import Solvers
from igl_linabf.surface import Mesh, complex_positions, planar_mesh, real_coordinates

DISKS = ("bumps", "ball", "disk__igl_camel_b.obj", "stress__optcuts_duck1.obj")
UNCUT = ("crown", "limb", "holes__igl_halftunnel.off", "stress__optcuts_golf.obj")


def symmetric_dirichlet(V: np.ndarray, F: np.ndarray, uv: np.ndarray) -> float:
    """Return a quarter of the mean of s1^2 + s2^2 + s1^-2 + s2^-2 at the best scale, computed with igl."""
    e1, e2, _ = igl.local_basis(V, F)
    gradient = (igl.grad(V, F) @ uv).reshape(3, len(F), 2)
    jacobian = np.stack([np.einsum("kfi,fk->fi", gradient, e) for e in (e1, e2)], axis=1)
    s = np.linalg.svd(jacobian, compute_uv=False)
    large, small = (np.average((s**k).sum(axis=1), weights=igl.doublearea(V, F)) for k in (2, -2))
    return float(np.sqrt(large * small) / 2)


def flatten_with_slim(V: np.ndarray, F: np.ndarray, start: np.ndarray, iterations: int) -> np.ndarray:
    """Return the map of igl's SLIM for the symmetric Dirichlet energy."""
    arrays = [np.asfortranarray(a) for a in (V, F.astype(np.int32), start)]
    nothing = np.zeros(0, dtype=np.int32), np.zeros((0, 2), order="F")
    energy = igl.MappingEnergyType.SYMMETRIC_DIRICHLET
    return igl.slim_solve(igl.slim_precompute(*arrays, energy, *nothing, 0.0), iterations)


def edge_lengths(V: np.ndarray, F: np.ndarray) -> np.ndarray:
    a, b = igl.edges(F).T
    return np.linalg.norm(V[a] - V[b], axis=1)


def embed_mesh_in_circle(mesh: Mesh) -> np.ndarray:
    """Return an embedding in a circle, a valid start far from an isometry."""
    return next(embed_in_circle(mesh.topology, Solvers()))


@pytest.mark.parametrize("name", DISKS + UNCUT)
def test_isometric_maps_have_no_flips_and_less_stretch(name: str) -> None:
    V, F = load(name)
    result, angles = flatten(V, F, method="isometric"), flatten(V, F)
    assert not len(result.flipped), result.message
    assert result.report.layout == "isometric"
    assert str(result.report.attempts[-1]) == "isometric (no flips)"
    assert len(result.flipped) == count_flipped_exactly(result.uv, F) == 0
    ours, theirs = quality(V, F, result.uv), quality(V, F, angles.uv)
    assert ours.stretch_l2 < theirs.stretch_l2
    assert ours.area_distortion < theirs.area_distortion
    assert igl.doublearea(result.uv, F).sum() == pytest.approx(igl.doublearea(V, F).sum())


@pytest.mark.parametrize("name", DISKS)
def test_the_symmetric_dirichlet_energy_is_below_that_of_slim(name: str) -> None:
    V, F = load(name)
    mesh = planar_mesh(V, F)
    start = complex_positions(flatten(V, F).uv)
    made = make_isometric(mesh, start, 1.0, None, Solvers())
    energy = symmetric_dirichlet(V, F, real_coordinates(made.z))
    assert made.stalled
    assert energy == pytest.approx(made.energy, rel=1e-6)
    assert energy <= symmetric_dirichlet(V, F, flatten_with_slim(V, F, real_coordinates(start), 30)) * (
        1 + 1e-5
    )


@pytest.mark.parametrize("weight", [0.5, 1, 1.5, 4])
def test_a_flat_mesh_is_reproduced_from_a_distant_start(weight: float) -> None:
    V, F = load("bumps")
    V = V * [1, 1, 0]
    assert best_fit_distance(flatten(V, F, method=Isometric(weight=weight)).uv, V[:, :2]) < 1e-9
    mesh = planar_mesh(V, F)
    made = make_isometric(mesh, embed_mesh_in_circle(mesh), weight, None, Solvers())
    assert best_fit_distance(real_coordinates(made.z), V[:, :2]) < 1e-4


def test_a_developable_surface_is_mapped_isometrically_from_a_distant_start() -> None:
    x, y = np.meshgrid(np.linspace(0, 4, 41), np.linspace(0, 1, 11))
    _, F = igl.triangulated_grid(41, 11)
    V = np.column_stack((np.cos(x.ravel()), np.sin(x.ravel()), y.ravel()))
    mesh = planar_mesh(V, F)
    made = make_isometric(mesh, embed_mesh_in_circle(mesh), 1.0, None, Solvers())
    assert np.allclose(edge_lengths(real_coordinates(made.z), F), edge_lengths(V, F), rtol=1e-4)


@pytest.mark.parametrize("name", ["bumps", "stress__optcuts_duck1.obj"])
def test_position_scale_and_numbering_do_not_matter(name: str) -> None:
    V, F = load(name)
    rng = np.random.default_rng(0)
    new = rng.permutation(len(V))
    moved = np.empty_like(V)
    moved[new] = 1e6 * (V[:, [1, 2, 0]] + np.ptp(V))
    uv = flatten(V, F, method="isometric").uv
    other = flatten(moved, new[F][rng.permutation(len(F))], method="isometric").uv[new] / 1e6
    assert np.abs(other - uv).max() <= 1e-3 * np.ptp(uv)


@pytest.mark.parametrize("name", ["bumps", "stress__optcuts_duck1.obj"])
def test_a_larger_weight_preserves_areas_better_and_angles_worse(name: str) -> None:
    V, F = load(name)
    measured = [quality(V, F, flatten(V, F, method=Isometric(weight=w)).uv) for w in (0, 0.5, 1, 2, 4, 8)]
    areas, angles = ([getattr(q, of) for q in measured] for of in ("area_distortion", "conformal_distortion"))
    assert areas == sorted(areas, reverse=True)
    assert angles == sorted(angles)


def test_the_cortex_is_flatter_than_the_map_that_ships_with_it() -> None:
    pytest.importorskip("nilearn")
    from cortex import cortex

    V, F, shipped = cortex()
    ours, theirs = quality(V, F, flatten(V, F, method="isometric").uv), quality(V, F, shipped)
    assert ours.area_distortion < theirs.area_distortion == pytest.approx(0.206, abs=5e-4)
    assert ours.edge_change < theirs.edge_change
    assert ours.stretch_l2 < theirs.stretch_l2


@pytest.mark.parametrize("name", ["pial", "nut", "ant", "closed__igl_cow.off"])
def test_atlases_have_even_texels_and_no_overlaps(name: str) -> None:
    V, F = load(name)
    atlas = unwrap(V, F, method="isometric")
    assert atlas.good
    assert atlas.quality.flips == sum(chart.overlapping for chart in atlas.charts) == 0
    assert atlas.quality.stretch_l2 < 1.04
    assert atlas.quality.texel_spread < 2.5


def test_the_stretch_of_the_isometric_map_decides_where_charts_are_cut() -> None:
    V, F = load("pial")
    even, angles = (
        unwrap(V, F, charts=ChartOptions(max_stretch=1.02), method=method)
        for method in ("isometric", "linabf")
    )
    assert max(chart.quality.stretch_l2 for chart in even.charts) <= 1.02 * (1 + 1e-9)
    assert even.good
    assert even.seam_length < angles.seam_length


def test_the_command_takes_the_method_and_its_weight(tmp_path, capsys) -> None:
    V, F = load("bumps")
    mesh, out = tmp_path / "bumps.obj", tmp_path / "flat.obj"
    igl.write_triangle_mesh(str(mesh), V, F)
    assert main(["flatten", str(mesh), "-o", str(out), "--method", "isometric", "--weight", "3"]) == 0
    expected = quality(V, F, flatten(V, F, method=Isometric(weight=3)).uv)
    assert f"{expected.stretch_l2:.4g}" in capsys.readouterr().out
    assert main(["unwrap", str(mesh), "-o", str(out), "--method", "isometric", "--weight", "3"]) == 0
    assert f"{expected.stretch_l2:.4g}" in capsys.readouterr().out
    assert main(["unwrap", str(mesh), "-o", str(out), "--weight", "3"]) == 0
    assert f"{expected.stretch_l2:.4g}" in capsys.readouterr().out
    assert main(["unwrap", str(mesh), "-o", str(out), "--method", "linabf", "--weight", "3"]) == 2
    assert "--weight is not an option of the method linabf" in capsys.readouterr().err


@pytest.mark.parametrize("name", DISKS)
@pytest.mark.parametrize("weight", [1.0, 1.5])
def test_the_energy_is_within_the_tolerance_of_its_minimum(name: str, weight: float) -> None:
    V, F = load(name)
    mesh = planar_mesh(V, F)
    for start in (complex_positions(flatten(V, F).uv), embed_mesh_in_circle(mesh)):
        least = make_isometric(mesh, start, weight, None, Solvers()).energy
        for tol in (0.02, 0.005, 0.001):
            made = make_isometric(mesh, start, weight, None, Solvers(), tol)
            assert made.stalled
            assert least * (1 - 1e-6) <= made.energy <= least * (1 + tol)


def test_a_tolerance_out_of_its_range_is_refused() -> None:
    for tol in (-1e-3, np.nan):
        with pytest.raises(ValueError, match="tol is"):
            Isometric(tol=tol)


def test_a_weight_out_of_its_range_is_refused() -> None:
    for weight in (-1, 9, np.nan):
        with pytest.raises(ValueError, match="weight is"):
            Isometric(weight=weight)


def test_the_function_returns_the_map_of_the_method() -> None:
    V, F = bumps(80)
    b, bc = F[0, :2], [[0, 0], [1, 0]]
    made = flatten(V, F, b, bc, method=Isometric(weight=3.0, tol=0.01))
    assert (isometric(V, F, b, bc, weight=3.0, tol=0.01) == made.uv).all()


def test_many_isometric_maps_at_once_equal_single_maps() -> None:
    meshes = [bumps(n, seed) for seed, n in enumerate((60, 200, 120, 400, 80))]
    for together, (V, F) in zip(flatten_many(meshes, method="isometric"), meshes, strict=True):
        alone = flatten(V, F, method="isometric")
        assert together.message == alone.message
        assert together.report.attempts[-1].name == alone.report.attempts[-1].name == "isometric"
        assert together.outcome is alone.outcome
        assert np.abs(together.uv - alone.uv).max() <= 1e-9 * np.ptp(alone.uv)
        assert np.abs(together.angles - alone.angles).max() <= 1e-9
        assert np.isclose(together.after.largest, alone.after.largest, atol=1e-12)
        assert together.seconds["total"] >= together.seconds["isometric"] > 0
