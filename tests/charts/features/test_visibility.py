"""Seams are placed where they are hidden."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from commands import run
from conftest import load
from nasty_meshes import NASTY, sphere
from numpy.testing import assert_allclose

from igl_linabf import ChartOptions, MeshError, MeshWarning, Packing, find_seams, unwrap
from igl_linabf.charts import texture_seams
from igl_linabf.charts.seams import TRADE
from igl_linabf.io import read_texture, write_mesh

FIGURES = ("closed__igl_cow.off", "stress__optcuts_dragon_i_f10000.obj", "pial")


def measure_visible_length(V: np.ndarray, F: np.ndarray, seams: np.ndarray, hide: np.ndarray) -> float:
    """Return the length of the seams on the side that faces away from direction `hide`."""
    a, b = V[seams.T]
    facing = igl.per_vertex_normals(V, F)[seams].mean(axis=1) @ hide
    return float(np.linalg.norm(a - b, axis=1)[facing < 0].sum())


@pytest.mark.parametrize("name", FIGURES)
def test_seams_move_to_the_hidden_side(name: str) -> None:
    V, F = load(name)
    axes = np.eye(3)[np.argsort(np.ptp(V, axis=0))]
    for hide in (axes[0], -axes[0]):
        plain, hidden = (unwrap(V, F, charts=ChartOptions(hide=side)) for side in (None, hide))
        assert hidden.good
        before, after = (measure_visible_length(V, F, atlas.seams, hide) for atlas in (plain, hidden))
        assert after < 0.7 * before
        assert hidden.quality.stretch_l2 < plain.quality.stretch_l2 + 0.15


def test_seams_of_many_small_bodies_lie_on_the_hidden_side() -> None:
    V, F = igl.icosahedron()
    V = np.concatenate([V + np.array([5.0 * i, 0, 0]) for i in range(10)])
    F = np.concatenate([F + 12 * i for i in range(10)])
    above, below = (V[find_seams(V, F, hide=[0, 0, z])][..., 2].mean() for z in (1.0, -1.0))
    assert above > 0.2
    assert below == pytest.approx(-above, rel=0.1)


def test_weights_of_faces_hide_seams_like_a_direction() -> None:
    V, F = load("pial")
    cosine = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])[:, 2] / igl.doublearea(V, F)
    by_direction, by_weight = (
        unwrap(V, F, charts=ChartOptions(hide=h)) for h in ([0, 0, 1.0], 5 + 2 * cosine)
    )
    up = np.array([0, 0, 1.0])
    lengths = [measure_visible_length(V, F, atlas.seams, up) for atlas in (by_direction, by_weight)]
    assert max(lengths) < 0.7 * measure_visible_length(V, F, unwrap(V, F).seams, up)
    same = find_seams(V, F, hide=np.full(len(F), 7.0))
    assert (same == find_seams(V, F)).all()


def bust() -> tuple[np.ndarray, np.ndarray]:
    """Return a ball on an open neck, with features on the side of +x."""
    V, F = sphere(5)
    V = np.column_stack((V[:, :2], np.where(V[:, 2] < -0.75, 2 * V[:, 2] + 0.75, V[:, 2])))
    rng = np.random.default_rng(4)
    for place in rng.normal(size=(12, 3)) * [0, 0.4, 0.4] + [1, 0, 0]:
        near = np.exp(-(np.linalg.norm(V - place / np.linalg.norm(place), axis=1) ** 2) / 0.01)
        V = V + rng.choice([-0.12, 0.12]) * near[:, None] * [1, 0, 0]
    return igl.remove_unreferenced(V, F[V[F][:, :, 2].max(axis=1) > -1.2])[:2]


FACES = {  # the direction that each model looks towards
    "disk__optcuts_david_o_f10000.obj": [1, 0, 1],
    "disk__igl_face.obj": [0, 0, 1],
    "disk__igl_lion.off": [0, 0, -1],
    "stress__optcuts_male_body_i_f10000.obj": [0, -1, 0],
}


@pytest.mark.parametrize("name", ["bust", *FACES])
def test_seams_stay_off_a_face(name: str) -> None:
    V, F = bust() if name == "bust" else load(name)
    away = -np.array(FACES.get(name, [1, 0, 0])) / np.linalg.norm(FACES.get(name, [1, 0, 0]))
    roomy = Packing(resolution=2048, texel_density=1)  # so large that no chart is cut
    anywhere = unwrap(V, F, packing=roomy)
    size = float(np.sqrt(igl.doublearea(V, F).sum() / 2))
    for turn in (np.eye(3), np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]):
        found = unwrap(V @ turn, F, charts=ChartOptions(hide="back"), packing=roomy)
        assert found.good
        seen, before = (measure_visible_length(V, F, atlas.seams, away) for atlas in (found, anywhere))
        assert seen < 0.72 * before
        # add the seam length in units of L2 stretch, because a longer seam may reduce the stretch
        longer = (found.seam_length - anywhere.seam_length) / size / TRADE
        assert found.quality.stretch_l2 - anywhere.quality.stretch_l2 + longer < 0.16
        assert found.seam_length < 1.5 * anywhere.seam_length


def test_the_back_of_a_body_inside_out_is_its_back() -> None:
    V, F = bust()
    for faces in (F, F[:, ::-1]):
        seams = find_seams(V, faces, hide="back")
        side = V[seams].mean(axis=1)[:, 0]
        assert np.linalg.norm(V[seams[:, 0]] - V[seams[:, 1]], axis=1) @ (side > 0) < 0.2


def test_a_body_without_a_front_is_reported_and_cut_anywhere() -> None:
    V, F = sphere(4)
    with pytest.warns(MeshWarning, match="no body has details"):
        found = find_seams(V, F, hide="back")
    assert (found == find_seams(V, F)).all()
    with pytest.raises(MeshError, match="'front'"):
        find_seams(V, F, hide="front")


def test_hiding_does_not_depend_on_the_orientation_of_a_body() -> None:
    V, F = sphere(3)
    V = V * [1, 1.3, 0.8]
    up = np.array([0, 0, 1.0])
    for faces in (F, F[:, ::-1]):
        seams = find_seams(V, faces, hide=up)
        assert measure_visible_length(V, F, seams, up) < 0.5 * measure_visible_length(V, F, seams, -up)


@pytest.mark.parametrize(
    ("hide", "says"),
    [
        ([0, 0, 0], "no length"),
        ([0, 1], r"shape \(2,\)"),
        ([0, np.nan, 1], "NaN or infinite at 1"),
        (["x", 1, 2], "no array of numbers"),
        (np.ones(7), r"weights of the 20 faces"),
    ],
)
def test_invalid_directions_and_weights_are_refused(hide: object, says: str) -> None:
    V, F = igl.icosahedron()
    with pytest.raises(MeshError, match=says):
        find_seams(V, F, hide=hide)
    with pytest.raises(MeshError, match=says):
        unwrap(V, F, charts=ChartOptions(hide=hide))


def test_the_command_hides_seams_and_refuses_invalid_directions(tmp_path) -> None:
    V, F = load("pial")
    mesh = tmp_path / "in.obj"
    igl.write_triangle_mesh(str(mesh), V, F)
    process = run("unwrap", mesh, "-o", tmp_path / "out.obj", "--hide=0,0,-1")
    assert process.returncode == 0, process.stderr
    FTC = read_texture(tmp_path / "out.obj")[1]
    assert (FTC == unwrap(V, F, charts=ChartOptions(hide=[0, 0, -1])).FTC).all()
    process = run("unwrap", mesh, "-o", tmp_path / "out.obj", "--hide=0,1")
    assert process.returncode == 2
    assert "is not a direction" in process.stderr


@pytest.mark.parametrize("name", ["soup of triangles", "three sheets at an edge", "faces turned at random"])
def test_seams_of_a_file_are_used_for_unclean_meshes(name: str, tmp_path) -> None:
    V, F = NASTY[name]()
    with pytest.warns(match="repaired"):
        first = unwrap(V, F)
    write_mesh(tmp_path / "a.obj", V, F, first.TC, first.FTC)
    process = run("unwrap", tmp_path / "a.obj", "-o", tmp_path / "b.obj", "--seams", "uv")
    assert process.returncode == 0, process.stderr
    TC, FTC = read_texture(tmp_path / "b.obj")
    assert FTC.shape == F.shape
    assert_allclose(np.sort(igl.doublearea(TC, FTC)), np.sort(igl.doublearea(first.TC, first.FTC)), rtol=1e-6)
    with pytest.warns(match="repaired"):
        again = unwrap(V, F, texture_seams(F, first.FTC, V, first.TC, sides=True))
    assert_allclose(igl.doublearea(again.TC, again.FTC), igl.doublearea(first.TC, first.FTC), rtol=1e-6)
