"""The cortex, flattened along given cuts
======================================

Flatten the left cortical hemisphere of fsaverage5 along the cuts that the experts of FreeSurfer made.

The mesh is part of the nilearn package. `pial_left` is the surface in 3-D. `flat_left` contains the faces
that remain after the cuts, and a flat map of them, which is shown for comparison. FreeSurfer computed that
map to preserve distances, which takes many minutes.

Two methods of this package are shown beside it. Linear ABF preserves angles: shapes are right, but sizes
vary. The isometric map preserves lengths and areas as well as possible. It takes a second, and distorts both
less than the map of FreeSurfer.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import igl
import numpy as np
from compare_lscm import show

from igl_linabf import read_mesh

# only the files of the package are read, because its import needs further packages
FSAVERAGE = Path(find_spec("nilearn").origin).parent / "datasets" / "data" / "fsaverage5"


def cortex() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the surface (#V, 3), its faces (#F, 3) and the flat map of FreeSurfer (#V, 2), in mm."""
    (flat, F), (pial, _) = (read_mesh(FSAVERAGE / f"{name}_left.gii.gz") for name in ("flat", "pial"))
    V, F, _, used = igl.remove_unreferenced(pial, F)
    return V, F, flat[used, :2]


if __name__ == "__main__":
    V, F, shipped = cortex()
    measured = show(V, F, Path("out/cortex"), {"shipped": shipped}, methods=("lscm", "linabf", "isometric"))
    linear, isometric, freesurfer = (measured[name] for name in ("linABF", "isometric", "shipped"))
    assert linear.flips == isometric.flips == isometric.overlaps == 0
    assert linear.angle_distortion < measured["igl.lscm"].angle_distortion
    assert isometric.report.edge_change_99 < freesurfer.report.edge_change_99
    for figure in ("area_distortion", "edge_change", "stretch_l2", "angle_distortion"):
        assert getattr(isometric, figure) < getattr(freesurfer, figure)
