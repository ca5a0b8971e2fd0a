"""Atlases of other programs are read with the faces, corners and figures that the programs wrote."""

from __future__ import annotations

import sys

import beside
import igl
import numpy as np
import partuv_peer
from peers import RESOLUTION, make_charts, run_script

SCRIPT = """
import numpy as np, sys
data = np.load(sys.argv[1])
corner = data["F"].ravel()
uv = data["V"][corner, :2] + 9 * np.repeat(data["chart"], 3)[:, None]
np.savez(sys.argv[2], uv=uv, corner=corner, seconds=3.5)
"""


def test_a_script_in_another_python_keeps_the_faces_and_joins_corners_within_charts() -> None:
    V, F = igl.icosahedron()
    chart = (np.arange(len(F)) >= 7).astype(int)
    atlas = run_script(sys.executable, SCRIPT, V, F, chart=chart)
    assert atlas.seconds == 3.5
    np.testing.assert_array_equal(atlas.origin[atlas.FTC], F)
    np.testing.assert_array_equal(
        atlas.TC[atlas.FTC], RESOLUTION * (V[F][..., :2] + 9 * chart[:, None, None])
    )
    joined = [len(np.unique(F[chart == c])) for c in (0, 1)]
    assert len(atlas.TC) == sum(joined)
    assert not set(make_charts(atlas.FTC)[chart == 0]) & set(make_charts(atlas.FTC)[chart == 1])


def test_the_tree_for_partuv_has_every_face_as_a_leaf_and_one_root() -> None:
    V, F = igl.icosahedron()
    children = partuv_peer.make_tree(V, F)
    nodes = 2 * len(F) - 1
    np.testing.assert_array_equal(np.sort(children.ravel()), np.arange(nodes - 1))


def test_the_conclusion_gives_ratios_of_seams_and_what_the_other_program_does_better() -> None:
    theirs = dict.fromkeys(beside.HEADS, 2.0)
    mine = theirs | {"charts": 3.0, "CPU s": 0.5}
    pairs = [(theirs, mine | {"seams": seams}) for seams in (1.0, 1.5, 3.0)]
    text = " ".join(beside.conclude("Rival", pairs).split())
    assert "on 3 meshes, the seams of `unwrap` are 0.75 times as long in the median (0.50 to 1.50)" in text
    assert "Rival is better in: charts." in text
