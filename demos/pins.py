"""
Pins
====

Pins are vertices with given places, as `igl.lscm` takes them: `b` and `bc`. Two place the map and do not
bend it. More bend it. Here 14 vertices of a cortex's boundary are pinned, in turn farther out and farther
in than they lie.

Least squares puts all pins exactly there. Beside some of them the map comes to lie over itself, and a few
small triangles turn over. `method="isometric"` takes the same pins, and lets no triangle turn over. The
picture shows the free map, then both pinned ones, with the pins as dots::

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
AMPLITUDE = 0.12  # of the distance from the middle

if __name__ == "__main__":
    V, F, _ = cortex()
    free = flatten(V, F, "isometric").uv
    loop = igl.boundary_loop(F)
    b = loop[:: len(loop) // PINS][:PINS]
    bc = free[b] * (1 + AMPLITUDE * (-1.0) ** np.arange(PINS))[:, None]  # in turn out and in
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(1, 3), off_screen=True, window_size=[2100, 700], border=False)
    maps = {
        "free": free,
        "least squares": flatten(V, F, "linabf", b, bc).uv,
        "isometric": flatten(V, F, "isometric", b, bc).uv,
    }
    for column, (name, uv) in enumerate(maps.items()):
        measured = quality(V, F, uv)
        off = np.abs(uv[b] - bc).max()
        said = f"{name}: {measured.flips} flipped, pins at most {off:.1e} mm away"
        print(f"{said}, L2 stretch {measured.stretch_l2:.3f}")
        plotter.subplot(0, column)
        plot_uv(uv, F, plotter=plotter)
        dots = np.column_stack((bc, np.full(PINS, 1.0)))
        plotter.add_points(dots, color=MARK, point_size=10, render_points_as_spheres=True)
        plotter.add_text(said, font_size=11)
        assert name == "free" or off < 1e-6 * np.ptp(uv)
        assert name == "least squares" or measured.flips == 0
    Path("out").mkdir(exist_ok=True)
    with replacing("out/pins.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/pins.png")
