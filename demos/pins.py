"""
Pins: vertices at given places
==============================

Pins are vertices with prescribed positions. They are passed as `b` and `bc`, the arguments of `igl.lscm`. Two
pins determine the position, rotation and scale of the map; further pins deform it. Here, 14 vertices at the
boundary of a cortex are pinned, alternately farther out and farther in than in the free map.

The least-squares map meets all pins exactly. Near some of them it overlaps itself, and a few small triangles
flip. `method="isometric"` meets the same pins, and no triangle flips. The picture shows the free map and the
two pinned maps, with the pins as dots::

    python demos/pins.py
"""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from cortex import cortex

from igl_linabf import flatten, quality
from igl_linabf.io import replacing
from igl_linabf.plot import MARK, plot_uv

PINS = 14
AMPLITUDE = 0.12  # displacement of the pins, as a share of the distance from the middle

if __name__ == "__main__":
    V, F, _ = cortex()
    free = flatten(V, F, method="isometric").uv
    loop = igl.boundary_loop(F)
    b = loop[:: len(loop) // PINS][:PINS]
    bc = free[b] * (1 + AMPLITUDE * (-1.0) ** np.arange(PINS))[:, None]  # outward and inward alternately
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(1, 3), off_screen=True, window_size=[2100, 700], border=False)
    maps = {
        "free": free,
        "least squares": flatten(V, F, b, bc, method="linabf").uv,
        "isometric": flatten(V, F, b, bc, method="isometric").uv,
    }
    for column, (name, uv) in enumerate(maps.items()):
        measured = quality(V, F, uv)
        error = np.abs(uv[b] - bc).max()
        caption = f"{name}: {measured.flips} flipped, pins at most {error:.1e} mm away"
        print(f"{caption}, L2 stretch {measured.stretch_l2:.3f}")
        plotter.subplot(0, column)
        plot_uv(uv, F, plotter=plotter)
        dots = np.column_stack((bc, np.full(PINS, 1.0)))
        plotter.add_points(dots, color=MARK, point_size=10, render_points_as_spheres=True)
        plotter.add_text(caption, font_size=11)
        assert name == "free" or error < 1e-6 * np.ptp(uv)
        assert name == "least squares" or measured.flips == 0
    Path("out").mkdir(exist_ok=True)
    with replacing("out/pins.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/pins.png")
