"""
Flattening a deforming mesh
===========================

A cortex is inflated over several frames: its vertices move, but its triangles do not change. A `Flattener`
computes everything that depends on the triangles only once. Therefore each frame takes less time than a call
of `flatten`, and the map is the same to the last bit.
"""

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from nilearn.datasets import fetch_surf_fsaverage
from nilearn.surface import load_surf_mesh

from igl_linabf import Flattener, flatten, quality
from igl_linabf.plot import fit, plot_checkerboard, plot_uv

# %%
# Load the first and the last positions of the vertices, and interpolate the frames between them.
fsaverage = fetch_surf_fsaverage("fsaverage5")
white, inflated, cut = (load_surf_mesh(fsaverage[f"{name}_left"]) for name in ("white", "infl", "flat"))
F = cut.faces.astype(np.int64)
first, last = (surface.coordinates.astype(float) for surface in (white, inflated))
_, F, _, used = igl.remove_unreferenced(first, F)
first, last = first[used], last[used]
frames = [first + t * (last - first) for t in (0, 0.5, 1)]

# %%
# Flatten each frame. Maps of successive frames may be rotated, so each map is fitted to the previous one.
flattener = Flattener(F)
maps = []
for V in frames:
    result = flattener.flatten(V)
    figures = quality(V, F, result.uv)
    print(f"F/3nt {figures.angle_distortion:.4f}, {figures.flips} flipped triangles")
    assert figures.flips == 0
    maps.append(fit(result.uv, maps[-1]) if maps else result.uv)
assert (result.uv == flatten(frames[-1], F).uv).all()

# %%
# Draw the frames and their maps.
plotter = pv.Plotter(shape=(2, 3), off_screen=True, window_size=[1500, 1000], border=False)
for column, (V, uv) in enumerate(zip(frames, maps, strict=True)):
    plotter.subplot(0, column)
    plot_checkerboard(V, F, uv, plotter=plotter)
    plotter.view_vector((-1, 0, 0), (0, 0, 1))
    plotter.subplot(1, column)
    plot_uv(uv, F, plotter=plotter)
Path("out").mkdir(exist_ok=True)
plotter.show(screenshot="out/deforming_mesh.png")
