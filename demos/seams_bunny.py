"""Unwrapping the bunny
====================

Unwrap the Stanford bunny or any other surface: find seams, flatten the charts, pack them, and write OBJ and
GLB files::

    python demos/seams_bunny.py [MESH]

Three values of `trade` show how longer seams reduce the stretch.

The command `igl-linabf unwrap MESH -o OUT.obj` does the same for one file.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from stretch import bunny

from igl_linabf import find_seams, quality, unwrap
from igl_linabf.io import read_mesh, replacing, write_mesh
from igl_linabf.plot import plot_compare

if __name__ == "__main__":
    if len(sys.argv) > 1:
        V, F = read_mesh(sys.argv[1])
        name = Path(sys.argv[1]).stem
    else:
        V, F = bunny()
        name = "seams_bunny"
    diagonal = np.linalg.norm(np.ptp(V, axis=0))
    maps = {}
    for trade in (2.0, 6.0, 30.0):
        seams = find_seams(V, F, method="linabf", trade=trade)
        atlas = unwrap(V, F, seams, method="linabf")
        print(f"\ntrade {trade:g}: seams {atlas.seam_length / diagonal:.2f} of the bounding box's diagonal")
        print(atlas)
        if len(sys.argv) == 1:
            assert atlas.good
            assert atlas.quality.angle_distortion < 1.5e-4
            assert atlas.quality.stretch_l2 < 1.5
            assert quality(V[atlas.origin], atlas.FTC, atlas.TC).overlaps == 0
        maps[trade] = atlas
    Path("out").mkdir(exist_ok=True)
    chosen = maps[6.0]
    for suffix in (".obj", ".glb"):
        write_mesh(f"out/{name}{suffix}", V, F, chosen.TC, chosen.FTC)
    with replacing(f"out/{name}.png") as temporary:
        plotter = plot_compare(
            V[chosen.origin], chosen.FTC, {"linABF": chosen.TC}, off_screen=True, show=False
        )
        plotter.subplot(0, 0)
        plotter.view_vector((0.35, -1.0, 0.25), viewup=(0, 0, 1))  # upright
        plotter.show(screenshot=temporary)
        plotter.close()
    print(f"\nwrote out/{name}.obj, .glb and .png")
