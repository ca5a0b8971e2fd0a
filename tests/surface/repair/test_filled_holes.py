"""A patch is the largest piece of its kept faces, bordered by loops; all other pieces are reported."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from nasty_meshes import sphere

from igl_linabf import MeshError
from igl_linabf.surface import build_planar_topology, find_patch_faces


def grid(n: int) -> np.ndarray:
    return igl.triangulated_grid(n, n)[1].astype(np.int64)


def test_the_largest_piece_is_kept_and_other_pieces_are_reported_by_size() -> None:
    stays = np.ones(15 * 15, dtype=bool)
    row = np.arange(15 * 15) // 15
    stays[(row == 3) | (row == 12)] = False  # leaves pieces of 3, 8 and 2 rows
    for F in (grid(15), grid(15)[::-1].copy()):
        made = find_patch_faces(F, stays)
        assert np.array_equal(made.vertices, np.flatnonzero((row > 3) & (row < 12)))
        assert np.array_equal(made.rows, np.flatnonzero(np.isin(F, made.vertices).all(axis=1)))
        assert [np.unique(row[piece]).tolist() for piece in made.pieces] == [[0, 1, 2], [13, 14]]
        assert not len(made.pinched) and not len(made.bare)
        assert "2 other pieces of 45, 30 vertices" in made.left_out_descriptions[0]
        build_planar_topology(np.searchsorted(made.vertices, F[made.rows]), made.vertices)


def test_vertices_where_the_border_touches_itself_are_left_out_and_named() -> None:
    F, stays = grid(9), np.ones(81, dtype=bool)
    stays[[31, 49]] = False  # the two neighbours on both sides of vertex 40
    made = find_patch_faces(F, stays)
    assert made.pinched.tolist() == [40]
    assert made.left_out_descriptions == ["vertices 40, at which the border touches itself"]
    assert np.array_equal(made.vertices, np.setdiff1d(np.arange(81), [31, 40, 49]))
    assert len(build_planar_topology(np.searchsorted(made.vertices, F[made.rows]), made.vertices).holes) == 1


def test_pieces_that_meet_in_a_vertex_are_separate_and_have_disjoint_vertices() -> None:
    F = grid(9)
    x, y = np.arange(81) % 9, np.arange(81) // 9
    stays = (x <= 4) & (y <= 4) | (x >= 4) & (y >= 4)
    made = find_patch_faces(F, stays)
    assert len(made.vertices) == 25 and 40 in made.vertices
    assert [len(piece) for piece in made.pieces] == [24]
    kept = np.concatenate((made.vertices, *made.pieces, made.pinched, made.bare))
    assert np.array_equal(np.sort(kept), np.flatnonzero(stays))


def test_vertices_without_a_face_are_reported_and_an_empty_patch_is_rejected() -> None:
    V, F = sphere(1)
    stays = np.zeros(len(V), dtype=bool)
    stays[F[0]] = True
    alone = np.setdiff1d(np.arange(len(V)), F[np.isin(F, F[0]).any(axis=1)])[0]
    stays[alone] = True
    made = find_patch_faces(F, stays)
    assert made.rows.tolist() == [0] and made.bare.tolist() == [alone]
    stays[F[0, 0]] = False
    with pytest.raises(MeshError, match="no face has three vertices that stay"):
        find_patch_faces(F, stays)
