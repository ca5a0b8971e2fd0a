"""
Where the angle error is, before and after
==========================================

The upper row shows how far the angles are from those of a flat mesh: at each interior vertex the
larger residual of the vertex constraint (equation 5) and the wheel constraint (equation 10). On the
left the angles are the surface's own, on the right those after linear ABF's default two solves.

The lower row shows the squared relative angle change of each triangle, in the map of igl.lscm and in
that of linear ABF. Both pictures of a row have the same scale.
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
    """The larger residual of the vertex and the wheel constraint at each vertex, for angles (#F, 3)."""
    corner, log_sin = F.ravel(), np.log(np.sin(angles))
    around = np.bincount(corner, angles.ravel(), len(V)) - 2 * np.pi
    wheel = np.bincount(corner, (np.roll(log_sin, -1, 1) - np.roll(log_sin, 1, 1)).ravel(), len(V))
    missed = np.maximum(np.abs(around), np.abs(wheel))
    missed[igl.boundary_facets(F)[0]] = 0  # nothing is asked for there
    return missed


if __name__ == "__main__":
    V, F = cortex()[:2]
    ours, lscm = flatten(V, F), flatten(V, F, "lscm")
    uv = {"igl.lscm": fit(lscm.uv, ours.uv), "linABF": ours.uv}
    missed = {
        "surface's angles": residuals(V, F, igl.internal_angles(V, F)),
        "linABF's angles": residuals(V, F, ours.angles),
    }
    change = {name: distortion(V, F, map_) for name, map_ in uv.items()}
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(2, 2), off_screen=True, window_size=[1400, 1400], border=False)
    bar = colour_scale(change.values(), "angle")["scalar_bar_args"]
    scale = {"log_scale": True, "clim": (1e-5, 1.0), "cmap": "viridis"}
    for column, (name, values) in enumerate(missed.items()):
        inside = values > 0
        said = f"{name}: residual up to {values.max():.1e}, median {np.median(values[inside]):.1e}"
        print(said)
        plotter.subplot(0, column)
        titled = bar | {"title": "residual of the constraints\n"}
        plot_uv(ours.uv, F, scalars=values, plotter=plotter, scalar_bar_args=titled, **scale)
        plotter.add_text(said, font_size=14)
    for column, (name, values) in enumerate(change.items()):
        measured = quality(V, F, uv[name])
        said = f"{name}: F/3nt {measured.angle_distortion:.3g}, {measured.flips} flipped"
        print(said)
        plotter.subplot(1, column)
        plot_uv(uv[name], F, scalars=values, plotter=plotter, **colour_scale(change.values(), "angle"))
        plotter.add_text(said, font_size=14)
    before, after = missed.values()
    assert np.median(after[after > 0]) < 0.05 * np.median(before[before > 0])
    assert change["linABF"].mean() < change["igl.lscm"].mean()
    Path("out").mkdir(exist_ok=True)
    with replacing("out/angle_error.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/angle_error.png")
