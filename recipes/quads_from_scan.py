"""
Remeshing a scan with quadrangles
=================================

A scan consists of triangles of all shapes. Linear ABF preserves angles. Therefore the lines of a square grid
in the map meet at nearly right angles on the surface, and form a mesh of quadrangles. It is written as an OBJ
file of polygons.
"""

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from pymeshfix import MeshFix
from pymeshfix.examples import bunny_scan

from igl_linabf import linabf
from igl_linabf.io import read_mesh, write_grid
from igl_linabf.plot import plot_grid
from igl_linabf.remesh import quad_grid

# %%
# Repair and decimate the scan of the Stanford bunny, and cut its body off at the neck and above the feet.
Path("out").mkdir(exist_ok=True)
bunny = MeshFix(*read_mesh(bunny_scan))
bunny.repair()
V, F, *_ = igl.qslim(bunny.points.astype(float), bunny.faces.astype(np.int64), 10_000)
x, _, height = V[F].mean(axis=1).T
F = F[(height > 6) & (height < 29) & (x > -8)]
_, piece = igl.facet_components(F)
V, F, *_ = igl.remove_unreferenced(V, F[piece == np.bincount(piece).argmax()])

# %%
# Flatten the body, and lay a grid of about 2,000 cells over the map, whose area is the area of the surface.
uv = linabf(V, F)
grid = quad_grid(V, F, uv, spacing=np.sqrt(igl.doublearea(V, F).sum() / 2 / 2000))
write_grid("out/quads_from_scan.obj", grid)

# %%
# Measure how much the angles of the complete cells deviate from 90 degrees.
corners = grid.V[grid.quads]
ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
cosine = (ahead * back).sum(axis=2) / np.linalg.norm(ahead, axis=2) / np.linalg.norm(back, axis=2)
angles = np.degrees(np.arccos(cosine))
deviation = np.abs(angles - 90)
print(
    f"{len(F):,} triangles; {len(grid.quads):,} of {len(grid.faces):,} cells are whole quadrangles, "
    f"whose angles are {deviation.mean():.1f} degrees off 90 in the mean"
)
assert len(grid.quads) > 0.8 * len(grid.faces)
assert deviation.mean() < 6

# %%
# Draw the complete cells light, and the cells cut by the boundary dark.
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plot_grid(grid, plotter=plotter)
plotter.view_vector((0.3, -1, 0.3), (0, 0, 1))
plotter.subplot(0, 1)
plot_grid(grid, flat=True, plotter=plotter)
plotter.show(screenshot="out/quads_from_scan.png")
