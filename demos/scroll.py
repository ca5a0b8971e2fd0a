"""Flattening a scroll segment
===========================

Flatten a sheet of papyrus, a grid of points in the volume of a scan, to a grid at true scale.

The segment is made up: a spiral with noise, holes, coincident points, and a part that hangs on a thin
bridge. The squares are 500 voxels wide in the flat segment, and the isometric map keeps their size on the
spiral.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista as pv

from igl_linabf.io import read_tifxyz, write_tifxyz
from igl_linabf.scrolls import flatten_segment, synthetic_segment

OUT = Path("out/scroll")
SQUARE = 500.0  # width of the squares, in voxels

if __name__ == "__main__":
    OUT.mkdir(parents=True, exist_ok=True)
    write_tifxyz(OUT / "segment", synthetic_segment(150, 900), force=True)
    flat = flatten_segment(OUT / "segment")
    write_tifxyz(OUT / "flat", flat.segment, force=True)
    print(flat.report)

    square = np.floor(flat.uv / SQUARE).sum(axis=1) % 2
    corners = np.column_stack((np.full(len(flat.F), 3), flat.F))
    spread = np.column_stack((flat.uv, np.zeros(len(flat.uv))))
    style = {"scalars": square, "cmap": ["#d8b27a", "#7a5430"], "show_scalar_bar": False}
    plotter = pv.Plotter(shape=(2, 1), off_screen=True, window_size=[1400, 900], border=False)
    plotter.subplot(0, 0)
    plotter.add_mesh(pv.PolyData(flat.V, corners), ambient=0.6, **style)
    plotter.add_text("the segment in the scan", font_size=12)
    plotter.view_vector((0.6, -0.8, 0.7), viewup=(0, 0, 1))
    plotter.camera.zoom(1.2)
    plotter.subplot(1, 0)
    plotter.add_mesh(pv.PolyData(spread, corners), lighting=False, **style)
    plotter.add_text("flat", font_size=12)
    plotter.view_xy()
    plotter.camera.zoom(2.3)
    plotter.show(screenshot=OUT / "scroll.png")

    read = read_tifxyz(OUT / "flat")
    steps = [np.linalg.norm(np.diff(read.points, axis=axis), axis=2) for axis in (0, 1)]
    assert flat.report.flips == flat.report.overlaps == 0
    assert flat.report.stretch_l2 < 1.005
    assert all(
        abs(np.nanmedian(step) * scale - 1) < 0.01 for step, scale in zip(steps, read.scale, strict=True)
    )
