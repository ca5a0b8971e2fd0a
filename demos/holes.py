"""Holes, uncut
============

A crown whose tips are cut off, flattened by igl.lscm, linear ABF and ABF::

    python demos/holes.py [MESH]

The constraints at interior vertices alone leave the map multivalued around a hole. igl_linabf adds
constraints for each hole: from the first step on, its loop turns once and ends at the scale with which
it began; from the second step on, it closes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
from compare_lscm import show
from high_curvature import crown, rings

from igl_linabf import LinABF, flatten, layout
from igl_linabf.io import read_mesh
from igl_linabf.plot import fit


def crown_without_tips() -> tuple[np.ndarray, np.ndarray]:
    """The crown of `high_curvature.py`, cut off at a height: a disk with seven holes."""
    V, F = rings(40, crown)
    V, F, *_ = igl.remove_unreferenced(V, F[V[F][..., 2].max(axis=1) < 0.45])
    return V, F


if __name__ == "__main__":
    if len(sys.argv) > 1:
        V, F = read_mesh(sys.argv[1])
        name = Path(sys.argv[1]).stem
    else:
        V, F = crown_without_tips()
        name = "holes"
    measured = show(V, F, Path("out") / name)
    one, converged = (flatten(V, F, LinABF(iterations=iterations)) for iterations in (1, 12))
    print("\nhole of vertex  vertices  rotation    scale  translation: one step, then converged")
    for first, last in zip(one.holes, converged.holes, strict=True):
        print(f"{first.vertex:14}  {first.size:8}", end="")
        for hole in (first, last):
            print(f"  {hole.rotation:8.1e} {hole.scale:8.1e}     {hole.translation:8.1e}", end="")
        print()
    # laid out triangle after triangle, on either side of every hole, the map is single-valued now
    greedy = fit(layout(F, converged.angles, method="greedy"), converged.uv)
    away = np.linalg.norm(greedy - converged.uv, axis=1).max() / np.ptp(converged.uv, axis=0).max()
    print(f"greedy layout of the converged angles is {away:.1e} of the map's size from least squares")
    if len(sys.argv) == 1:
        assert len(converged.holes) == 7
        assert max(hole.largest for hole in converged.holes) < 1e-8
        assert len(converged.steps) <= 12
        assert away < 1e-6
        assert measured["igl.lscm"].flips > 0
        assert measured["linABF"].flips == measured["ABF"].flips == 0
        assert measured["linABF"].angle_distortion < 0.67 * measured["igl.lscm"].angle_distortion
