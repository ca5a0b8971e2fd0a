"""
A sheet metal pattern
=====================

A duct connects a square opening with a round one. It is bent from one piece of sheet metal and welded along
one seam. `write_pattern` draws the piece at true scale for a laser cutter, with the bending lines. The
surface is the mid-surface of the sheet, half its thickness from both sides.
"""

import re
from pathlib import Path

import igl
import numpy as np
import pyvista as pv

from igl_linabf import unwrap
from igl_linabf.patterns import write_pattern

# %%
# Build the duct, in millimetres. A triangle stands on each side of the square, and a fan of triangles
# leads from each corner to the circle.
SIDES, WIDTH, RADIUS, HEIGHT = 32, 300, 100, 250
turn = (np.arange(SIDES) + 0.5) * 2 * np.pi / SIDES
circle = np.column_stack((RADIUS * np.cos(turn), RADIUS * np.sin(turn), np.full(SIDES, HEIGHT)))
square = WIDTH / 2 * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
V = np.concatenate((circle, square))
F = []
for i in range(SIDES):
    corner, j = SIDES + i * 4 // SIDES, (i + 1) % SIDES
    next_corner = SIDES + j * 4 // SIDES
    F.append([j, i, corner])
    if next_corner != corner:
        F.append([corner, next_corner, j])
F = np.array(F)

# %%
# Unwrap along one seam from a corner of the square to the circle. The surface is developable: no length
# changes.
seam = np.array([[SIDES, 0]])
Path("out").mkdir(exist_ok=True)
atlas = unwrap(V, F, seam)
pattern = write_pattern("out/duct.svg", V, F, atlas, "mm", crease=5)
print(pattern)
assert pattern.pieces == len(pattern.seams) == 1
assert pattern.error < 1e-6
(weld,) = pattern.seams
np.testing.assert_allclose(weld.lengths, np.linalg.norm(V[SIDES] - V[0]), rtol=1e-6)

# %%
# All bends are mountain folds: they go away from the viewer of the drawing, who sees the outside of the duct.
assert (pattern.fold_angles > 0).all()
print(f"bends by {pattern.fold_angles.min():.1f} to {pattern.fold_angles.max():.1f} degrees")

# %%
# The outline is as long as the two rims of the duct and twice the seam.
(outline,) = pattern.outlines
cut = np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1).sum()
rims = np.linalg.norm(np.diff(V[igl.boundary_facets(F)[0]], axis=1), axis=2).sum()
np.testing.assert_allclose(cut, rims + 2 * weld.length, rtol=1e-6)
size = re.search(r'width="([\d.]+)mm"', Path("out/duct.svg").read_text(encoding="utf-8"))
assert float(size[1]) > pattern.size[0]

# %%
# Draw the duct with its seam in red, and the piece with the bending lines.
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plotter.add_mesh(pv.PolyData.from_regular_faces(V, F), color="#c8ccd0", show_edges=True)
plotter.add_lines(V[seam[0]], color="#c02020", width=8)
plotter.view_vector((0.9, 1, 0.6), (0, 0, 1))
plotter.subplot(0, 1)
for line, colour, closed in [(outline, "black", True), *((fold, "#2050c0", False) for fold in pattern.folds)]:
    points = np.column_stack((line, np.zeros(len(line))))
    plotter.add_lines(
        np.vstack((points, points[:1])) if closed else points, color=colour, width=3, connected=True
    )
plotter.view_xy()
plotter.camera.zoom(1.2)
plotter.show(screenshot="out/sheet_metal.png")
