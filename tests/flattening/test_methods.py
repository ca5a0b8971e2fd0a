"""Linear ABF on real meshes: distortion, flips, residuals, and messages."""

from __future__ import annotations

from dataclasses import astuple, fields

import numpy as np
import pytest
from conftest import CARRIED_DISKS, DISKS, STRESS, load
from hostile_meshes import find_flipped_exactly

from igl_linabf import FallbackWarning, LinABF, OutcomeWarning, abf, flatten, linabf, quality
from igl_linabf.angles import build_constraints
from igl_linabf.angles.full_system import compute_right_hand_sides
from igl_linabf.flattening import METHODS, MethodOptions, Outcome, Residuals, find_far_pins, linabf_angles
from igl_linabf.surface import planar_mesh

# F/3nt after one iteration, with a tolerance of 2 % (docs/results/maps.md, "The paper's Table 1")
ONE_ITERATION = {
    "disk__igl_camel_b.obj": 7.38e-3,
    "disk__igl_camelhead.off": 2.03e-3,
    "disk__igl_lion.off": 2.46e-3,
    "disk__igl_face.obj": 3.65e-4,
    "disk__igl_lilium.obj": 5.56e-5,
    "cortex": 2.54e-3,
}
HOLDS_FLIPS = "stress__flipfree_deer.obj"  # the map of this mesh exceeds double precision


@pytest.mark.parametrize("name", ONE_ITERATION)
def test_one_iteration_reaches_the_angle_distortion_of_table_1(name: str) -> None:
    V, F = load(name)
    result = flatten(V, F, method=LinABF(iterations=1))
    measured = quality(V, F, result.uv)
    assert result.report.iterations == 1
    assert measured.flips == 0
    assert measured.angle_distortion <= 1.02 * ONE_ITERATION[name]


@pytest.mark.parametrize("name", ["bumps", "cortex", *CARRIED_DISKS, *DISKS, *STRESS])
def test_default_maps_have_no_flips_and_converged_residuals_vanish(name: str) -> None:
    if name == HOLDS_FLIPS:
        pytest.skip("tested below")
    V, F = load(name)
    auto, converged = flatten(V, F), flatten(V, F, method=LinABF(iterations=12))
    for result in (auto, converged):
        assert quality(V, F, result.uv).flips == 0
        assert not len(result.flipped)
        assert result.after.largest < result.before.largest
    assert converged.outcome in (Outcome.CONVERGED, Outcome.OVERLAPPING)
    assert converged.after.largest < 1e-8
    assert converged.report.iterations <= 7
    assert auto.report.gap < 2.5e-3


@pytest.mark.parametrize(
    "name",
    [
        *CARRIED_DISKS,
        "disk__igl_camel_b.obj",
        "disk__optcuts_lion_o_f10000.obj",
        "disk__optcuts_armadillo_i_f10000.obj",
        "stress__optcuts_golf.obj",
        "stress__optcuts_dragon_i_f10000.obj",
        "stress__optcuts_cone2.0_f1500.obj",
    ],
)
def test_linear_abf_has_no_flips_where_igl_lscm_flips(name: str) -> None:
    V, F = load(name)
    lscm = flatten(V, F, method="lscm")
    assert lscm.outcome is Outcome.FLIPPED
    assert len(lscm.flipped) == quality(V, F, lscm.uv).flips > 0
    ours = flatten(V, F)
    assert len(ours.flipped) == 0
    assert quality(V, F, ours.uv).angle_distortion < quality(V, F, lscm.uv).angle_distortion


@pytest.mark.parametrize("name", ["bumps", "disk__igl_camel_b.obj"])
def test_reported_residuals_are_those_of_the_returned_angles(name: str) -> None:
    V, F = load(name)
    result = flatten(V, F, method=LinABF(iterations=1))
    constraints = build_constraints(planar_mesh(V, F).topology)
    at_vertices, triangle = compute_right_hand_sides(constraints, result.angles.T)
    vertex, wheel = np.abs(at_vertices).reshape(-1, 2).max(axis=0)
    expected = Residuals(vertex=vertex, triangle=np.abs(triangle).max(), wheel=wheel)
    assert astuple(result.after) == pytest.approx(astuple(expected), rel=1e-6, abs=1e-13)
    assert expected.triangle < 1e-12 < 1e-6 < min(vertex, wheel)
    assert vertex != pytest.approx(wheel, rel=0.01)  # the two residuals must not be swapped


def test_two_pins_are_not_blamed_for_flips_but_three_are() -> None:
    V, F = load("limb")
    two = flatten(V, F, *find_far_pins(planar_mesh(V, F)))
    assert two.outcome is Outcome.FLIPPED
    assert "pin" not in two.message
    V, F = load("bumps")
    three = flatten(V, F, [0, 1, 2], [[0, 0], [1, 0], [1e-3, 0]], method="linabf")
    assert three.outcome is Outcome.FLIPPED
    assert "which 3 pins may require: pin fewer vertices" in three.message


@pytest.mark.parametrize("name", [HOLDS_FLIPS, "limb"])
def test_maps_beyond_double_precision_are_reported(name: str) -> None:
    V, F = load(name)
    result = flatten(V, F)
    assert result.outcome is Outcome.FLIPPED
    assert result.after.largest < 1e-8
    assert "double precision" in result.message
    assert "cut" in result.message
    assert np.isfinite(result.uv).all()
    with pytest.warns(OutcomeWarning, match=f"face.*{result.flipped[0]}"):
        linabf(V, F)
    for function in (linabf_angles, abf)[: 2 if name == HOLDS_FLIPS else 1]:  # abf takes a minute for limb
        with pytest.warns(OutcomeWarning, match="faces .* flipped or collapsed"):
            function(V, F)


@pytest.mark.parametrize("method", ["linabf", "abf", "lscm", "dncp"])
def test_faces_without_positive_area_count_as_flipped(method: str) -> None:
    V, F = load("bumps")
    # three collinear pins collapse a face, which igl does not count
    result = flatten(V, F, F[7], [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], method=method)
    assert 7 in result.flipped
    assert np.array_equal(result.flipped, find_flipped_exactly(result.uv, F))
    assert result.outcome is Outcome.FLIPPED


@pytest.mark.parametrize("name", ["stress__optcuts_golf.obj", "ball"])
def test_auto_continues_beyond_step_and_chord_only_where_needed(name: str) -> None:
    V, F = load("cortex")
    easy = flatten(V, F)
    assert [step.kind for step in easy.report.steps] == ["step", "chord"]
    V, F = load(name)
    hard = flatten(V, F)
    assert [step.kind for step in hard.report.steps][:2] == ["step", "step"]
    assert hard.report.steps[0].limited > 0
    assert hard.outcome is Outcome.CONVERGED


@pytest.mark.parametrize("name", ["stress__optcuts_male_body_i_f10000.obj", "ball"])
def test_angles_become_invalid_without_the_safeguard_and_stay_valid_with_it(name: str) -> None:
    V, F = load(name)
    with pytest.warns(FallbackWarning, match="not within|factored"):
        bare = flatten(V, F, method=LinABF(iterations=1, safeguard=False))
    assert bare.outcome is Outcome.ANGLES_INVALID
    assert (bare.angles <= 0).any()
    safe = flatten(V, F, method=LinABF(iterations=1))
    assert safe.outcome is Outcome.VALID
    assert (safe.angles > 0).all()
    V, F = load("cortex")
    assert flatten(V, F, method=LinABF(iterations=1, safeguard=False)).outcome is Outcome.VALID


@pytest.mark.parametrize("options", [{"iterations": 0}, {"iterations": 1.5}, {"rtol": 0}, {"layout": "x"}])
def test_invalid_options_of_methods_are_refused(options: dict) -> None:
    V, F = load("bumps")
    with pytest.raises(ValueError, match="use"):
        flatten(V, F, method=LinABF(**options))
    with pytest.raises(ValueError, match="use one of"):
        flatten(V, F, method="nonesuch")


def test_keywords_set_the_options_of_a_method() -> None:
    V, F = load("bumps")
    for method, given, whole in (
        ("linabf", {"iterations": 1}, LinABF(iterations=1)),
        (LinABF(layout="greedy"), {"iterations": 3}, LinABF(iterations=3, layout="greedy")),
    ):
        of_keywords = flatten(V, F, method=method, **given)
        assert (of_keywords.uv == flatten(V, F, method=whole).uv).all()
        assert (of_keywords.uv != flatten(V, F, method=method).uv).any()
    options = {field.name: field.type for method in METHODS.values() for field in fields(method)}
    assert {name: of.__forward_arg__ for name, of in MethodOptions.__annotations__.items()} == options
