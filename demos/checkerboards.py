"""
Checkerboards on six surfaces
=============================

A checkerboard on a surface shows the distortion of its flat map. Angles are preserved where the squares
remain squares, and the size of the squares shows how areas change. The surfaces are three disks, a disk with
holes, and two closed surfaces, whose seams are drawn. All of them are flattened by linear ABF.
"""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from cortex import cortex
from high_curvature import crown, rings, spiky
from holes import crown_without_tips
from stretch import bunny

from igl_linabf import Atlas, flatten, quality, unwrap
from igl_linabf.io import replacing
from igl_linabf.plot import plot_checkerboard


def double_torus() -> tuple[np.ndarray, np.ndarray]:
    """Return a closed surface with two handles, the level set of a polynomial."""
    grid = pv.ImageData(dimensions=(97, 65, 33), spacing=(1 / 32,) * 3, origin=(-1.5, -1.0, -0.5))
    x, y, z = grid.points.T
    level = (x**2 * (1 - x**2 / 1.6) - y**2) ** 2 + 0.5 * z**2 - 0.025
    surface = grid.contour([0.0], level).clean()
    F = surface.regular_faces.astype(np.int64)
    V, F, *_ = igl.remove_unreferenced(surface.points.astype(float), F)
    return V, F


Y, Z = (0, 1, 0), (0, 0, 1)
SURFACES = {  # name: (mesh, number of squares along the map, view direction, up direction)
    "cortex": (lambda: cortex()[:2], 30, (-1, 0, 0), Z),
    "spiky": (lambda: rings(40, spiky), 20, (0.3, -1, 0.9), Z),
    "crown": (lambda: rings(40, crown), 40, (0.3, -1, 1.2), Z),
    "seven holes": (crown_without_tips, 40, (0.3, -1, 1.2), Z),
    "Stanford bunny": (bunny, 60, (0.2, 1, 0.2), Z),
    "double torus": (double_torus, 60, (0.5, -0.8, 1), Y),
}

if __name__ == "__main__":
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(2, 3), off_screen=True, window_size=[1500, 1000], border=False)
    for i, (name, (surface, frequency, view, up)) in enumerate(SURFACES.items()):
        V, F = surface()
        closed = len(igl.boundary_facets(F)[0]) == 0
        uv = unwrap(V, F) if closed else flatten(V, F).uv
        measured = uv.quality if isinstance(uv, Atlas) else quality(V, F, uv)
        assert measured.flips == 0
        caption = f"{name}: F/3nt {measured.angle_distortion:.2e}, L2 stretch {measured.stretch_l2:.3g}"
        print(f"{caption}, {measured.flips} flipped, {len(F):,} triangles")
        plotter.subplot(*divmod(i, 3))
        plot_checkerboard(V, F, uv, frequency=frequency, plotter=plotter)
        plotter.view_vector(view, viewup=up)
        plotter.camera.zoom(1.1)
        plotter.add_text(caption, font_size=10)
    Path("out").mkdir(exist_ok=True)
    with replacing("out/checkerboards.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/checkerboards.png")
