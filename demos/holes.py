"""Holes without cuts
==================

Flatten a crown whose tips are cut off with `igl.lscm`, linear ABF and ABF::

    python demos/holes.py [MESH]

With constraints at the interior vertices only, the map is multivalued around a hole. This package adds
constraints for the boundary loop of each hole. From the first step on, the loop turns by exactly 360 degrees
and ends at its initial scale. From the second step on, the loop closes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
from compare_lscm import show
from high_curvature import crown, rings

from igl_linabf import LinABF, flatten
from igl_linabf.io import read_mesh
from igl_linabf.layouts import layout
from igl_linabf.plot import fit


def crown_without_tips() -> tuple[np.ndarray, np.ndarray]:
    """Return the crown of `high_curvature.py` with its tips cut off; it is a disk with seven holes."""
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
    one, converged = (flatten(V, F, method=LinABF(iterations=iterations)) for iterations in (1, 12))
    print("\nhole of vertex  vertices  rotation    scale  translation: one step, then converged")
    for first, last in zip(one.holes, converged.holes, strict=True):
        print(f"{first.vertex:14}  {first.size:8}", end="")
        for hole in (first, last):
            print(f"  {hole.rotation:8.1e} {hole.scale:8.1e}     {hole.translation:8.1e}", end="")
        print()
    # greedy layout passes each hole on both sides; after convergence, both sides meet
    greedy = fit(layout(F, converged.angles, method="greedy"), converged.uv)
    away = np.linalg.norm(greedy - converged.uv, axis=1).max() / np.ptp(converged.uv, axis=0).max()
    print(f"greedy layout of the converged angles is {away:.1e} of the map's size from least squares")
    if len(sys.argv) == 1:
        assert len(converged.holes) == 7
        assert max(hole.largest for hole in converged.holes) < 1e-8
        assert len(converged.report.steps) <= 12
        assert away < 1e-6
        assert measured["igl.lscm"].flips > 0
        assert measured["linABF"].flips == measured["ABF"].flips == 0
        assert measured["linABF"].angle_distortion < 0.67 * measured["igl.lscm"].angle_distortion
