"""
Quadrangular remeshing from the map
===================================

Figure 6 of the paper shows this application. The iso-lines of the flat map are drawn on the surface and form
a mesh of quadrangles. Their angles are close to 90 degrees, because the map nearly preserves angles.

The surfaces are the cortex, a disk with seven holes, and a closed surface, which is unwrapped first. Complete
cells are light, and cells cut by a boundary or a seam are dark. Each mesh is written as an OBJ file of
polygons::

    python demos/quads.py [MESH]
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from checkerboards import double_torus
from cortex import cortex
from holes import crown_without_tips

from igl_linabf import Packing, linabf, unwrap
from igl_linabf.io import read_mesh, replacing, write_grid
from igl_linabf.plot import plot_grid
from igl_linabf.remesh import QuadGrid, quad_grid

CELLS = 4000


def grid_of(V: np.ndarray, F: np.ndarray) -> QuadGrid:
    """Return a grid of about `CELLS` cells on a surface; a closed surface is unwrapped first."""
    if len(igl.boundary_facets(F)[0]):
        uv = linabf(V, F)
    else:
        atlas = unwrap(V, F, method="linabf", packing=Packing(cut_below=0))
        V, F, uv = V[atlas.origin], atlas.FTC, atlas.TC
    return quad_grid(V, F, uv, np.sqrt(igl.doublearea(np.ascontiguousarray(uv), F).sum() / 2 / CELLS))


def corner_angles(grid: QuadGrid) -> np.ndarray:
    """Return the angles of the complete cells in degrees, (#Q, 4)."""
    corners = grid.V[grid.quads]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cosine = (ahead * back).sum(axis=2) / np.linalg.norm(ahead, axis=2) / np.linalg.norm(back, axis=2)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        surfaces = {Path(sys.argv[1]).stem: read_mesh(sys.argv[1])}
    else:
        surfaces = {"cortex": cortex()[:2], "holes": crown_without_tips(), "double_torus": double_torus()}
    views = {"holes": ((0.3, -1, 1.2), (0, 0, 1)), "double_torus": ((0.5, -0.8, 1), (0, 1, 0))}
    Path("out").mkdir(exist_ok=True)
    with pv.vtk_verbosity("error"):
        size = [1400, 700 * len(surfaces)]
        plotter = pv.Plotter(shape=(len(surfaces), 2), off_screen=True, window_size=size, border=False)
    for row, (name, (V, F)) in enumerate(surfaces.items()):
        grid = grid_of(V, F)
        write_grid(f"out/quads_{name}.obj", grid)
        angles = corner_angles(grid)
        share = len(grid.quads) / len(grid.faces)
        deviation = np.abs(angles - 90).mean()
        caption = f"{name}: {len(grid.faces):,} faces, {share:.0%} quads"
        caption += f", angles {angles.mean():.1f} +-{deviation:.1f} degrees"
        print(caption)
        if len(sys.argv) == 1:
            assert share > 0.84
            assert abs(angles.mean() - 90) < 2
            assert deviation < 6
        plotter.subplot(row, 0)
        plot_grid(grid, plotter=plotter)
        view, up = views.get(name, ((-1, 0, 0), (0, 0, 1)))
        plotter.view_vector(view, viewup=up)
        plotter.camera.zoom(1.1)
        plotter.add_text(caption, font_size=14)
        plotter.subplot(row, 1)
        plot_grid(grid, flat=True, plotter=plotter)
    with replacing("out/quads.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/quads.png and an OBJ for each")
