"""
A window with the surface and its flat map
==========================================

A click on either side marks the same point on both. Keys change the method, the number of iterations, the
checkerboard and the kind of distortion; press h for a list. Without a display, the demo writes a picture of
the window to ``out/``::

    python demos/interactive.py [MESH]

``igl-linabf view MESH`` opens the same window.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pyvista as pv
from cortex import cortex

from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import Viewer, has_display

if __name__ == "__main__":
    V, F = read_mesh(sys.argv[1]) if len(sys.argv) > 1 else cortex()[:2]
    hidden = pv.OFF_SCREEN or not has_display()
    viewer = Viewer(V, F, off_screen=hidden)
    if hidden:
        viewer.pick(350, 350)  # the middle of the left half of the window, which shows the surface
        assert viewer.picked is not None
        print(viewer.caption)
        Path("out").mkdir(exist_ok=True)
        with replacing("out/interactive.png") as temporary:
            viewer.plotter.show(screenshot=temporary)
        print("wrote out/interactive.png")
    else:
        viewer.plotter.show(title="igl_linabf")
