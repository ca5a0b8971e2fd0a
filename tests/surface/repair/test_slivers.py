"""Nearly degenerate triangles are flattened as they are, repaired with a warning, or rejected by name."""

from __future__ import annotations

import warnings
from fractions import Fraction
from typing import Any

import igl
import numpy as np
import pytest
import pyvista
from conftest import Surface, load

from igl_linabf import ChartOptions, MeshError, MeshWarning, flatten, quality, unwrap
from igl_linabf.angles import CAP_ANGLE, System, build_constraints
from igl_linabf.flattening import Outcome
from igl_linabf.surface import build_planar_topology


def insert_points(kind: str, eps: float, count: int) -> Surface:
    """Split random faces at a point that is `eps` from an edge ("caps") or from a corner ("needles")."""
    V, F = load("bumps")
    chosen = np.random.default_rng(0).choice(len(F), count, replace=False)
    a, b, c = F[chosen].T
    near = (V[a] + V[b]) / 2 if kind == "caps" else V[a]
    towards = V[c] if kind == "caps" else (V[b] + V[c]) / 2
    new = len(V) + np.arange(count)
    split = np.concatenate([np.column_stack(s) for s in ((a, b, new), (b, c, new), (c, a, new))])
    return np.vstack((V, near + eps * (towards - near))), np.vstack((np.delete(F, chosen, axis=0), split))


@pytest.mark.parametrize("method", ["linabf", "abf"])
@pytest.mark.parametrize("kind", ["caps", "needles"])
@pytest.mark.parametrize("count", [5, 300])
@pytest.mark.parametrize("eps", [1e-3, 1e-5, 1e-6])
def test_thin_triangles_are_flattened_as_well_as_others(
    kind: str, eps: float, count: int, method: str
) -> None:
    plain = flatten(*load("bumps"), method=method)
    V, F = insert_points(kind, eps, count)
    assert igl.internal_angles(V, F).min() < eps
    result = flatten(V, F, method=method)
    assert result.outcome.good
    assert not len(result.report.repaired)
    measured, before = (quality(*m).angle_distortion for m in ((V, F, result.uv), (*load("bumps"), plain.uv)))
    assert measured < 1.05 * before


@pytest.mark.parametrize("method", ["linabf", "abf"])
@pytest.mark.parametrize("eps", [1e-8, 1e-10, 1e-12])
def test_angles_too_near_pi_are_repaired_and_named(eps: float, method: str) -> None:
    V, F = insert_points("caps", eps, 40)
    with pytest.warns(MeshWarning, match="rad of pi"):
        result = flatten(V, F, method=method)
    assert result.outcome.good
    assert quality(V, F, result.uv).flips == 0
    edge = np.linalg.norm(V[F] - V[np.roll(F, 1, axis=1)], axis=2)
    # sine of the largest angle of each face
    rest = igl.doublearea(V, F) / edge.min(axis=1) / np.sort(edge, axis=1)[:, 1]
    thin = np.flatnonzero((rest < CAP_ANGLE) & (igl.internal_angles(V, F).max(axis=1) > 2))
    assert np.array_equal(result.report.repaired, thin)
    assert "repaired faces" in str(result)
    # faces away from the caps are as good as without caps
    uv = np.insert(result.uv, 2, 0.0, axis=1)
    error = igl.internal_angles(uv, F) / igl.internal_angles(V, F) - 1
    around = np.isin(F, F[thin]).any(axis=1)
    plain = quality(*load("bumps"), flatten(*load("bumps"), method=method).uv).angle_distortion
    assert (error[~around] ** 2).mean() < 1.5 * plain


@pytest.mark.parametrize("eps", [1e-12, 1e-9])
def test_needles_of_any_length_are_flattened(eps: float) -> None:
    V, F = insert_points("needles", eps, 40)
    for method in ("linabf", "abf"):
        result = flatten(V, F, method=method)
        assert result.outcome.good
        assert quality(V, F, result.uv).flips == 0


def test_the_system_keeps_its_digits_beside_angles_near_pi() -> None:
    """The diagonal of S is compared with rational arithmetic, where P = diag(w) - w w^T / d."""
    V, F = insert_points("caps", 1e-7, 40)
    topology = build_planar_topology(F, np.arange(len(V)))
    alpha = igl.internal_angles(V, F).T
    constraints = build_constraints(topology)
    ours = System(constraints, alpha).build_matrix().to_sparse().diagonal().reshape(-1, 2)
    wanted = [[Fraction(0), Fraction(0)] for _ in constraints.target]
    cot = 1 / np.tan(alpha)
    for t, corners in enumerate(F):
        w = [Fraction(x) ** 2 for x in alpha[:, t].tolist()]
        c = [Fraction(x) for x in cot[:, t].tolist()]
        for k, row in enumerate(constraints.row[corners]):
            if row >= 0:
                n, p = (k + 1) % 3, (k + 2) % 3
                wanted[row][0] += w[k] - w[k] ** 2 / sum(w)
                wanted[row][1] += w[n] * c[n] ** 2 + w[p] * c[p] ** 2
                wanted[row][1] -= (w[n] * c[n] - w[p] * c[p]) ** 2 / sum(w)
    assert np.abs(ours / np.array(wanted, dtype=float) - 1).max() < 1e-12


def test_faces_of_zero_area_are_rejected_and_named() -> None:
    V, F = load("invalid__optcuts_zero_area_48.obj")
    flat = np.flatnonzero(igl.doublearea(V, F) == 0)
    assert len(flat) == 2
    with pytest.raises(MeshError, match=f"faces {flat[0]}, {flat[1]}.* have zero area.*collapse or remove"):
        flatten(V, F)
    kept = np.delete(F, flat, axis=0)
    # both faces are on the boundary, so that removing them makes no hole
    assert flatten(V, kept).outcome.good
    with pytest.raises(MeshError, match=f"faces 0, {len(kept)} are the same triangle"):
        flatten(V, np.vstack((kept, kept[:1])))


@pytest.mark.parametrize("name", ["lscm", "scp"])
def test_other_methods_report_caps_that_they_cannot_flatten(name: str) -> None:
    V, F = insert_points("caps", 1e-10, 40)
    with pytest.raises(MeshError, match="double precision"):
        flatten(V, F, method=name)


@pytest.mark.parametrize("eps", [1e-8, 1e-10, 1e-12, 1e-13])
def test_caps_do_not_hold_the_isometric_map_back(eps: float) -> None:
    V, F = load("bumps")
    expected = quality(V, F, flatten(V, F, method="isometric").uv).stretch_l2
    V, F = insert_points("caps", eps, 40)
    with pytest.warns(MeshWarning, match="rad of pi"):
        result = flatten(V, F, method="isometric")
    assert result.outcome.good
    assert quality(V, F, result.uv).stretch_l2 < expected + 1e-3


def add_thin_triangle(height: float, kind: str, centre: float) -> Surface:
    """Return a disk and a separate thin triangle with a side of length 1, which is rotated at random."""
    V, F = load("bumps")
    foot = 0.4 if kind == "cap" else 0.0
    thin = np.array([[0, 0, 0], [1, 0, 0], [foot, height, 0]])
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    return np.vstack((V, thin @ turn + centre)), np.vstack((F, np.arange(3) + len(V)))


@pytest.mark.parametrize("method", ["linabf", "abf", "isometric", "lscm", "scp"])
@pytest.mark.parametrize("kind", ["cap", "needle"])
def test_a_separate_thin_triangle_becomes_a_chart_of_its_shape(kind: str, method: str) -> None:
    for height in (1e-6, 1e-9, 1e-12, 1e-14, 3e-15):
        for centre in (0.0, 1e5):
            V, F = add_thin_triangle(height, kind, centre)
            with warnings.catch_warnings():
                # warnings of repairs far from the origin, and of the fallback of SCP
                warnings.simplefilter("ignore")
                made = unwrap(V, F, method=method)
            assert not made.troubles, (height, centre)
            assert made.quality.flips == 0
            alone = [chart.quality for chart in made.charts if list(chart.faces) == [len(F) - 1]]
            assert all(own.stretch_l2 < 1.0001 for own in alone)
            # the triangle is repaired if its height is within the rounding error
            assert alone or made.report.repairs


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"method": "isometric"},
        {"method": "abf"},
        {"charts": ChartOptions(repair_overlaps=True)},
        {"cones": "auto"},
    ],
)
@pytest.mark.parametrize("z", [0.05, 1, 5, 20])
def test_a_band_with_a_row_of_needles_is_unwrapped(z: float, options: dict[str, Any]) -> None:
    """The Moebius band of pyvista ends in triangles with one side as short as the rounding error."""
    band = pyvista.ParametricMobius(u_res=40, v_res=10, w_res=10).triangulate().clean()
    V, F = np.asarray(band.points, dtype=np.float64) * [1, 1, z], band.faces.reshape(-1, 4)[:, 1:]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # warnings of repairs, and of cuts in a band that SCAF cannot flatten
        made = unwrap(V, F, **options)
    assert not made.troubles
    assert made.quality.flips == made.quality.overlaps == 0
    assert made.quality.stretch_l2 < 1.03


def test_a_surface_pressed_flat_is_unwrapped() -> None:
    """Some edges have zero length after the faces are projected to their planes."""
    bottle = pyvista.ParametricKlein(u_res=40, v_res=30, w_res=10).triangulate().clean()
    V, F = np.asarray(bottle.points, dtype=np.float64) * [1, 1, 1e-8], bottle.faces.reshape(-1, 4)[:, 1:]
    made = unwrap(V, F, charts=ChartOptions(max_stretch=1.3))
    assert not made.troubles
    assert made.quality.flips == made.quality.overlaps == 0
    assert made.quality.stretch_l2 < 1.001


@pytest.mark.parametrize("seed", [*(pytest.param(k, marks=pytest.mark.slow) for k in (3, 8)), 12])
def test_abf_of_a_rough_surface_pressed_flat_ends_with_an_outcome(seed: int) -> None:
    """The steps stop at bounds of angles that coincide in double precision."""
    random = np.random.default_rng(seed)
    surface = pyvista.ParametricCatalanMinimal(u_res=30, v_res=30, w_res=10).triangulate().clean()
    points, F = np.asarray(surface.points, dtype=np.float64), surface.faces.reshape(-1, 4)[:, 1:]
    V = points * [1, 1, 10.0 ** random.integers(-9, -3)]
    V += random.normal(size=V.shape) * np.ptp(points) * 10.0 ** random.integers(-8, -2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the result may have a warning
        result = flatten(V, F, method="abf")
    assert np.isfinite(result.uv).all()
    assert result.outcome in (Outcome.CONVERGED, Outcome.NOT_CONVERGED, Outcome.OVERLAPPING)
    assert quality(V, F, result.uv).flips == len(result.flipped) == 0
