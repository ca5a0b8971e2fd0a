"""Surfaces with creases: seams follow them, and what can be developed is laid flat exactly."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import load
from hard_surfaces import DEVELOPABLE, box

from igl_linabf import cut, find_seams, unwrap


@pytest.mark.parametrize("name", DEVELOPABLE)
def test_what_has_a_net_is_laid_flat_without_distortion(name: str) -> None:
    V, F = DEVELOPABLE[name]()
    atlas = unwrap(V, F)
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.01
    assert atlas.quality.conformal_distortion < 1.01
    assert atlas.quality.area_distortion < 0.01


def test_planes_and_cylinders_of_a_machine_part_come_out_isometric() -> None:
    V, F = load("closed__igl_fandisk.off")
    atlas = unwrap(V, F)
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.005
    assert atlas.quality.conformal_distortion < 1.005


def test_a_net_does_not_depend_on_position_size_or_numbering() -> None:
    V, F = box(1, 1.3, 2, 2)
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    order = rng.permutation(len(V))
    place = np.argsort(order)
    length = unwrap(V, F).seam_length
    for V_other, F_other, scale in (
        (1e3 * V @ turn + 50, F, 1e3),
        (V[order], place[F][rng.permutation(len(F))][:, [1, 2, 0]], 1),
        (V.astype(np.float32), F, 1),
    ):
        atlas = unwrap(V_other, F_other)
        assert atlas.quality.stretch_l2 < 1.001
        assert atlas.seam_length == pytest.approx(scale * length, rel=1e-5)


def test_a_net_is_the_shortest_tree_through_the_corners() -> None:
    V, F = box(1, 1, 2, 2)
    a, b = V[find_seams(V, F).T]
    assert np.linalg.norm(a - b, axis=1).sum() == pytest.approx(8)  # six short edges and a long one
    assert len(igl.boundary_loop_all(cut(V, F, find_seams(V, F))[1])) == 1
