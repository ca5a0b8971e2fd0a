"""
Another unwrapper for a pipeline that calls xatlas
==================================================

Many pipelines that generate meshes call `xatlas.parametrize`, often deep inside a library. One line before
that call replaces xatlas by this package: `sys.modules["xatlas"] = igl_linabf.xatlas`. In this recipe the
library is trimesh, whose `mesh.unwrap()` imports xatlas.
"""

import sys
from pathlib import Path

import numpy as np
import pyvista as pv
import trimesh
from pymeshfix.examples import bunny_scan

import igl_linabf.xatlas
from igl_linabf import check_uv
from igl_linabf.io import read_mesh
from igl_linabf.plot import plot_checkerboard, plot_uv

# %%
# Replace xatlas for the whole process. Libraries that import it later, or inside a function, get the module
# of this package.
sys.modules["xatlas"] = igl_linabf.xatlas

# %%
# Run the pipeline. The faces keep their order.
V, F = read_mesh(bunny_scan)
mesh = trimesh.Trimesh(V, F, process=False).unwrap()
assert (mesh.vertices[mesh.faces] == V[F]).all()

# %%
# Check the texture coordinates that trimesh got.
check = check_uv(mesh.vertices, mesh.faces, mesh.visual.uv, mesh.faces)
print(check)
assert check.good

# %%
# Draw the mesh with a checkerboard, and its atlas.
corners = np.asarray(mesh.faces, dtype=np.int64)
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plot_checkerboard(mesh.vertices, corners, mesh.visual.uv, plotter=plotter)
plotter.view_vector((0.3, -1, 0.3), (0, 0, 1))
plotter.subplot(0, 1)
plot_uv(mesh.visual.uv, corners, plotter=plotter)
Path("out").mkdir(exist_ok=True)
plotter.show(screenshot="out/xatlas_pipeline.png")
