"""Transferred walls and cuts on a synthetic subject for which the exact cut is known."""

from __future__ import annotations

from itertools import pairwise

import igl
import numpy as np
import pytest

pytest.importorskip("nilearn")
from scipy.spatial import cKDTree
from subjects import ball
from test_templates import draw_template

from igl_linabf.cortex.templates import build_template, load_fsaverage_template
from igl_linabf.cortex.transfer import transfer_cuts, transfer_wall
from igl_linabf.surface import find_patch_faces


def turned(subdivisions: int) -> tuple[np.ndarray, np.ndarray]:
    V, F = ball(subdivisions)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    return V @ (turn * np.sign(np.linalg.det(turn))).T, F


@pytest.mark.parametrize("subdivisions", [4, 6])
def test_cuts_are_edge_paths_along_the_template_from_tip_to_wall(subdivisions: int) -> None:
    template = load_fsaverage_template("lh")
    sphere, F = turned(subdivisions)
    wall = transfer_wall(template, sphere)
    cuts = transfer_cuts(template, sphere, F, wall)
    edges = {tuple(edge) for edge in np.sort(igl.edges(F), axis=1).tolist()}
    side = np.mean([np.linalg.norm(sphere[a] - sphere[b]) for a, b in edges])
    assert len(cuts.paths) == len(template.cuts) == 5
    ends = set(np.flatnonzero(wall).tolist())
    for path, line in zip(cuts.paths, template.cuts, strict=True):
        steps = np.sort(np.column_stack((path[:-1], path[1:])), axis=1).tolist()
        assert all(tuple(step) in edges for step in steps)
        assert len(set(path.tolist())) == len(path)
        fine = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(line)])
        assert cKDTree(fine).query(sphere[path])[0].max() < 3 * side
        assert np.linalg.norm(sphere[path[0]] - line[0]) < side
        assert path[-1] in ends
        assert ends.isdisjoint(path[:-1].tolist())
        ends.update(path.tolist())
    patch = find_patch_faces(F, cuts.is_kept)
    assert igl.euler_characteristic(np.unique(F[patch.rows], return_inverse=True)[1].reshape(-1, 3)) == 1
    assert sum(map(len, patch.pieces)) < 0.002 * len(sphere)


def test_the_wall_is_the_templates_region() -> None:
    V, F, out = draw_template([(0.0, 1.5)])
    template = build_template(V, F, F[~out[F].any(axis=1)])
    sphere, _ = turned(5)
    wall = transfer_wall(template, sphere)
    down = np.arccos(np.clip(sphere[:, 2], -1, 1))
    assert wall[down < 0.35].all()
    assert not wall[down > 0.6].any()
