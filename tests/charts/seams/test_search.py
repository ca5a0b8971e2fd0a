"""Seams: topology after the cut, length and cost, and errors."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import CLOSED, load
from nasty_meshes import sphere

from igl_linabf import MeshError, flatten, quality
from igl_linabf.charts import cut, find_seams, texture_seams

OTHERS = (
    "punctured_nut",
    "pial_with_holes",
    "ant",
    "handles__bff_punctured-torus.obj",
    "handles__optcuts_torus_with_hole.obj",
    "holes__igl_beetle.off",
    "holes__igl_halftunnel.off",
    "multi__bff_teapot.obj",
    "multi__optcuts_double_triangles.obj",
)
TETRAHEDRON = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)


def pieces(F: np.ndarray) -> list[np.ndarray]:
    number, label = igl.facet_components(F)
    return [F[label == i] for i in range(number)]


def chi_and_loops(F: np.ndarray) -> tuple[int, int]:
    return len(np.unique(F)) - len(igl.edges(F)) + len(F), len(igl.boundary_loop_all(F))


def length(V: np.ndarray, seams: np.ndarray) -> float:
    return float(np.linalg.norm(V[seams[:, 0]] - V[seams[:, 1]], axis=1).sum())


def cube() -> tuple[np.ndarray, np.ndarray]:
    V = np.array([[x, y, z] for x in (0.0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return V, np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])


@pytest.mark.parametrize("trade", [0, 6])
@pytest.mark.parametrize("name", [*CLOSED, *OTHERS])
def test_every_component_becomes_one_disk(name: str, trade: float) -> None:
    V, F = load(name)
    V_cut, F_cut, origin = cut(V, F, find_seams(V, F, method="linabf", trade=trade))
    assert (V_cut == V[origin]).all()
    assert (origin[F_cut] == F).all()
    assert (origin[: len(V)] == np.arange(len(V))).all()
    parts = pieces(F_cut)
    in_panels = trade > 0 and name.endswith("nut")  # the nut consists of planes and cylinders
    assert len(parts) == len(pieces(F)) or (in_panels and len(parts) == 2)
    for part in parts:
        assert chi_and_loops(part) == (1, 1) or in_panels
        used = np.unique(part)
        assert len(flatten(V_cut[used], np.searchsorted(used, part)).flipped) == 0 or trade == 0


@pytest.mark.parametrize("name", [*CLOSED, *OTHERS])
def test_holes_stay_uncut_on_request(name: str) -> None:
    V, F = load(name)
    loops = sorted(max(chi_and_loops(part)[1], 1) for part in pieces(F))
    _, F_cut, _ = cut(V, F, find_seams(V, F, trade=0, keep_holes=True))
    for part in pieces(F_cut):
        chi, number = chi_and_loops(part)
        assert chi == 2 - number  # all handles are cut open
        assert number <= loops[-1] + 1
    if name.startswith("holes"):
        assert len(find_seams(V, F, keep_holes=True)) == 0


@pytest.mark.parametrize("surface", [TETRAHEDRON, cube(), igl.icosahedron()], ids=["4", "12", "20"])
@pytest.mark.parametrize("trade", [0, 1, 6, 1000])
def test_small_closed_surfaces_are_cut_to_disks_without_flips(
    surface: tuple[np.ndarray, np.ndarray], trade: float
) -> None:
    V, F = surface
    V_cut, F_cut, _ = cut(V, F, find_seams(V, F, trade=trade))
    for part in pieces(F_cut):  # if seams cost nothing, the sides of a cube become separate pieces
        assert chi_and_loops(part) == (1, 1)
        used = np.unique(part)
        assert len(flatten(V_cut[used], np.searchsorted(used, part)).flipped) == 0


@pytest.mark.parametrize("name", ["closed__optcuts_horse_f10000.obj"])
def test_a_larger_trade_gives_longer_seams_and_less_stretch(name: str) -> None:
    V, F = load(name)
    seams = [find_seams(V, F, method="linabf", trade=trade) for trade in (1, 6, 30)]
    lengths = [length(V, s) for s in seams]
    maps = []
    for s in seams:
        V_cut, F_cut, _ = cut(V, F, s)
        maps.append(quality(V_cut, F_cut, flatten(V_cut, F_cut).uv))
    assert lengths == sorted(lengths)
    stretch = [m.stretch_l2 for m in maps]
    assert stretch == sorted(stretch, reverse=True)
    assert stretch[1] <= 1.2


def test_seams_of_the_bunny_are_short_and_keep_its_distortion_low() -> None:
    from stretch import models

    V, F = next(model[1:] for model in models() if model[0] == "bunny")
    seams = find_seams(V, F, method="linabf")
    V_cut, F_cut, _ = cut(V, F, seams)
    assert chi_and_loops(F_cut) == (1, 1)
    measured = quality(V_cut, F_cut, flatten(V_cut, F_cut).uv)
    assert measured.flips == 0
    # seams along a tree between six distant points give 1.16e-4, 1.14, and a length of 2.58 diagonals
    assert measured.angle_distortion <= 1.15e-4
    assert measured.stretch_l2 <= 1.155
    assert length(V, seams) <= 2.05 * np.linalg.norm(np.ptp(V, axis=0))


@pytest.mark.parametrize("name", ["closed__igl_cow.off", "handles__bff_punctured-torus.obj"])
def test_seams_do_not_depend_on_numbering_or_position(name: str) -> None:
    V, F = load(name)
    rng = np.random.default_rng(1)
    order = rng.permutation(len(V))
    rank = np.argsort(order)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    moved, renumbered = V[order] @ turn * 3 + 1, rank[F][rng.permutation(len(F))]
    here, there = find_seams(V, F), find_seams(moved, renumbered)
    assert np.isclose(length(moved, there), 3 * length(V, here), rtol=1e-2)


def test_disks_are_not_cut_unless_requested() -> None:
    V, F = load("bumps")
    assert find_seams(V, F).shape == (0, 2)
    seams = find_seams(V, F, trade=1000, disks=True)
    assert len(seams)
    assert chi_and_loops(cut(V, F, seams)[1]) == (1, 1)
    flat = V * [1, 1, 0]
    assert len(find_seams(flat, F, disks=True)) == 0


def test_seams_do_not_depend_on_how_thin_a_spike_is() -> None:
    V, F = sphere(3)
    spike = V[:, 2] > 0.8

    def length(thickness: float) -> float:
        thin = np.where(spike[:, None], V * [thickness, thickness, 1], V)
        start, end = thin[find_seams(thin, F, method="linabf").T]
        return float(np.linalg.norm(end - start, axis=1).sum())

    expected = length(1e-6)
    for thickness in (1e-9, 1e-12, 1e-13, 1e-14):  # cotangents of up to 1e14
        assert length(thickness) == pytest.approx(expected, rel=1e-4)


def test_unreferenced_vertices_are_kept() -> None:
    V, F = igl.icosahedron()
    V, F = np.vstack((V[:1], V, V[:1])), F + 1
    _, F_cut, origin = cut(V, F, find_seams(V, F))
    assert (origin[: len(V)] == np.arange(len(V))).all()
    assert chi_and_loops(F_cut) == (1, 1)


@pytest.mark.parametrize("name", [CLOSED[0], OTHERS[0]])
def test_pairs_masks_and_textures_are_equivalent(name: str) -> None:
    V, F = load(name)
    seams = find_seams(V, F)
    V_cut, F_cut, _ = cut(V, F, seams)
    on_seam = set(map(frozenset, seams.tolist()))
    mask = np.array([[frozenset((f[k], f[(k + 1) % 3])) in on_seam for k in range(3)] for f in F.tolist()])
    for other in (mask, mask.astype(int), seams[::-1, ::-1]):
        V_other, F_other, _ = cut(V, F, other)
        assert (V_other == V_cut).all()
        assert (F_other == F_cut).all()
    assert set(map(frozenset, texture_seams(F, F_cut).tolist())) == on_seam
    assert len(texture_seams(F, F)) == 0


def test_a_single_edge_and_the_boundary_open_nothing() -> None:
    V, F = igl.icosahedron()
    assert len(cut(V, F, F[:1, :2])[0]) == 12
    assert len(cut(V, F[1:], F[0][[[0, 1], [1, 2]]])[0]) == 12
    assert len(cut(V, F, [])[0]) == 12


@pytest.mark.parametrize(
    ("seams", "says"),
    [
        ([[0, 12]], r"edges 0 refer to vertices outside 0\.\.11"),
        ([[0, 1], [-1, 0]], "edges 1 refer"),
        ([[0, 1], [0, 0]], r"edges 1 are not edges of the mesh \(edge 1 is \[0, 0\]\)"),
        ([[0.0, 1.0]], "float64"),
        ([0, 1], r"shape \(2,\)"),
        ([[0, 1, 2]], r"shape \(1, 3\)"),
        (np.full((20, 3), 2), "not a mask"),
        ([[0, 1], [2]], "not an array"),
    ],
)
def test_invalid_seams_are_refused(seams: object, says: str) -> None:
    V, F = igl.icosahedron()
    with pytest.raises(MeshError, match=says):
        cut(V, F, seams)


def test_non_manifold_surfaces_are_refused() -> None:
    V, F = igl.icosahedron()
    for spoiled, says in (
        (np.vstack((F, F[:1])), "same triangle"),
        (np.vstack((F[1:], F[:1, ::-1])), "opposite orientation"),
        (np.vstack((F, np.where(F == 0, 0, F + 12))), "bowtie"),
    ):
        points = np.vstack((V, V + 5))
        for call in (lambda F=spoiled, V=points: find_seams(V, F), lambda F=spoiled, V=points: cut(V, F, [])):
            with pytest.raises(MeshError, match=says):
                call()
    with pytest.raises(MeshError, match="rows for"):
        texture_seams(F, F[1:])
    with pytest.raises(MeshError, match="without texture"):
        texture_seams(F, F - 1)
    with pytest.raises(ValueError, match="trade"):
        find_seams(V, F, trade=-1)
