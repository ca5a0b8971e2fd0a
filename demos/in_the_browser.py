"""A flat cortex in the browser
============================

Write the flattened cortex as an HTML page. Any browser can open it without a server, and both views turn with
the mouse::

    python demos/in_the_browser.py [MESH]

The page is the HTML export of pyvista. It includes the viewer and is about 2 MB in size.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from pathlib import Path

import pyvista as pv
from cortex import cortex

from igl_linabf import linabf
from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import plot_checkerboard, plot_uv

if __name__ == "__main__":
    if len(sys.argv) > 1:
        V, F = read_mesh(sys.argv[1])
        name = Path(sys.argv[1]).stem
    else:
        V, F, _ = cortex()
        name = "cortex"
    uv = linabf(V, F)
    plotter = pv.Plotter(off_screen=True, shape=(1, 2), border=False, window_size=[1400, 700])
    plotter.subplot(0, 0)
    plot_checkerboard(V, F, uv, plotter=plotter)
    plotter.view_yz(negative=True)
    plotter.subplot(0, 1)
    plot_uv(uv, F, plotter=plotter)
    for view in plotter.renderers:  # the viewer of the page supports only perspective projection
        view.disable_parallel_projection()
        view.reset_camera()
    plotter.background_color = "white"
    Path("out").mkdir(exist_ok=True)
    page = Path("out") / f"{name}.html"
    with tempfile.TemporaryDirectory() as empty, contextlib.redirect_stdout(sys.stderr):
        # unless this variable names a folder, trame downloads another viewer
        os.environ.setdefault("VTK_WASM_DIR_OVERRIDE", empty)
        with replacing(page) as temporary:
            plotter.trame.export_html(temporary)
    plotter.show()
    print(f"wrote {page}")
