"""
The same mesh deforming
=======================

A cortex is inflated in frames: its triangles stay, its vertices move. A `Flattener` keeps what follows from
the triangles alone, so that each frame takes less than a `flatten` of its own, and gives the same map to
the last bit.
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
# First and last positions of the vertices; those between are interpolated.
fsaverage = fetch_surf_fsaverage("fsaverage5")
white, inflated, cut = (load_surf_mesh(fsaverage[f"{name}_left"]) for name in ("white", "infl", "flat"))
F = cut.faces.astype(np.int64)
first, last = (surface.coordinates.astype(float) for surface in (white, inflated))
_, F, _, used = igl.remove_unreferenced(first, F)
first, last = first[used], last[used]
frames = [first + t * (last - first) for t in (0, 0.5, 1)]

# %%
# Flatten each frame. The map may turn from frame to frame, so each one is fitted to the one before.
flattener = Flattener(F)
maps = []
for V in frames:
    result = flattener.flatten(V)
    measured = quality(V, F, result.uv)
    print(f"F/3nt {measured.angle_distortion:.4f}, {measured.flips} flipped triangles")
    assert measured.flips == 0
    maps.append(fit(result.uv, maps[-1]) if maps else result.uv)
assert (result.uv == flatten(frames[-1], F).uv).all()

# %%
# The frames, and their maps.
plotter = pv.Plotter(shape=(2, 3), off_screen=True, window_size=[1500, 1000], border=False)
for column, (V, uv) in enumerate(zip(frames, maps, strict=True)):
    plotter.subplot(0, column)
    plot_checkerboard(V, F, uv, plotter=plotter)
    plotter.view_vector((-1, 0, 0), (0, 0, 1))
    plotter.subplot(1, column)
    plot_uv(uv, F, plotter=plotter)
Path("out").mkdir(exist_ok=True)
plotter.show(screenshot="out/deforming_mesh.png")
