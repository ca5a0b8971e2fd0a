"""
The angle error before and after flattening
===========================================

The upper row shows how much the angles deviate from the angles of a flat mesh. The colour of each interior
vertex is the larger residual of the vertex constraint (equation 5) and the wheel constraint (equation 10).
The left picture shows the angles of the surface, and the right one the angles after the two solves of linear
ABF.

The lower row shows the squared relative change of the angles of each triangle, for `igl.lscm` on the left and
for linear ABF on the right. Both pictures of a row have the same colour scale.
"""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from cortex import cortex

from igl_linabf import distortion, flatten, quality
from igl_linabf.io import replacing
from igl_linabf.plot import colour_scale, fit, plot_uv


def residuals(V: np.ndarray, F: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the larger of the vertex and wheel residuals at each vertex, for angles (#F, 3)."""
    corner, log_sin = F.ravel(), np.log(np.sin(angles))
    around = np.bincount(corner, angles.ravel(), len(V)) - 2 * np.pi
    wheel = np.bincount(corner, (np.roll(log_sin, -1, 1) - np.roll(log_sin, 1, 1)).ravel(), len(V))
    residual = np.maximum(np.abs(around), np.abs(wheel))
    residual[igl.boundary_facets(F)[0]] = 0  # the boundary has no constraints
    return residual


if __name__ == "__main__":
    V, F = cortex()[:2]
    linear, lscm = flatten(V, F), flatten(V, F, method="lscm")
    uv = {"igl.lscm": fit(lscm.uv, linear.uv), "linABF": linear.uv}
    residual = {
        "angles of the surface": residuals(V, F, igl.internal_angles(V, F)),
        "angles of linABF": residuals(V, F, linear.angles),
    }
    change = {name: distortion(V, F, map_) for name, map_ in uv.items()}
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(2, 2), off_screen=True, window_size=[1400, 1400], border=False)
    bar = colour_scale(change.values(), "angle")["scalar_bar_args"]
    scale = {"log_scale": True, "clim": (1e-5, 1.0), "cmap": "viridis"}
    for column, (name, values) in enumerate(residual.items()):
        inside = values > 0
        caption = f"{name}: residual up to {values.max():.1e}, median {np.median(values[inside]):.1e}"
        print(caption)
        plotter.subplot(0, column)
        bar_options = bar | {"title": "residual of the constraints\n"}
        plot_uv(linear.uv, F, scalars=values, plotter=plotter, scalar_bar_args=bar_options, **scale)
        plotter.add_text(caption, font_size=14)
    for column, (name, values) in enumerate(change.items()):
        measured = quality(V, F, uv[name])
        caption = f"{name}: F/3nt {measured.angle_distortion:.3g}, {measured.flips} flipped"
        print(caption)
        plotter.subplot(1, column)
        plot_uv(uv[name], F, scalars=values, plotter=plotter, **colour_scale(change.values(), "angle"))
        plotter.add_text(caption, font_size=14)
    before, after = residual.values()
    assert np.median(after[after > 0]) < 0.05 * np.median(before[before > 0])
    assert change["linABF"].mean() < change["igl.lscm"].mean()
    Path("out").mkdir(exist_ok=True)
    with replacing("out/angle_error.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/angle_error.png")
