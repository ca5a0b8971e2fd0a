"""
Baking the colours of a scan into a GLB file
============================================

A scan has a colour at each vertex. Games and web pages need a mesh of few triangles whose colours are in a
texture. This recipe reads a file with its colours, unwraps the mesh, bakes the colours, and writes one GLB
file that contains the texture. trimesh then opens the file, and the texture has the colour of the scan at
each vertex.
"""

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
import trimesh
from pymeshfix import MeshFix
from pymeshfix.examples import bunny_scan
from scipy.spatial import cKDTree

from igl_linabf import Packing, adapters, unwrap
from igl_linabf.io import read_file, read_mesh, write_textured
from igl_linabf.textures import bake

# %%
# Write a PLY file with vertex colours, in place of your scan.
Path("out").mkdir(exist_ok=True)
bunny = MeshFix(*read_mesh(bunny_scan))
bunny.repair()
V, F, *_ = igl.qslim(bunny.points.astype(float), bunny.faces.astype(np.int64), 8_000)
stripes = np.sin(V[:, [2, 0, 1]] * [0.25, 0.35, 0.5])
paint = np.uint8(255 * (0.55 + 0.4 * stripes))
trimesh.Trimesh(V, F, vertex_colors=paint, process=False).export("out/scan.ply")

# %%
# Read the scan, unwrap it, bake its colours, and write the GLB file.
scan = read_file("out/scan.ply")
atlas = unwrap(scan.V, scan.F, packing=Packing(resolution=512))
image = bake(scan.V, scan.F, atlas, scan.colours[:, :3], 512)
write_textured("out/scan.glb", scan.V, scan.F, atlas.TC, atlas.FTC, image)
assert atlas.good

# %%
# Open the file with trimesh, and look up the texture at each vertex.
(opened,) = trimesh.load("out/scan.glb").geometry.values()
looked_up = opened.visual.to_color().vertex_colors[:, :3].astype(int)
_, nearest = cKDTree(V).query(opened.vertices)
error = np.abs(looked_up - paint[nearest]).max(axis=1)
print(
    f"{len(atlas.TC) - len(V)} vertices are doubled at seams; colours are off by {np.median(error):.0f} "
    f"of 255 in the median, by {error.max()} at most"
)
assert np.median(error) <= 2

# %%
# Draw the bunny with its texture, and the texture itself.
texture = pv.Texture(np.uint8(255 * image))
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plotter.add_mesh(adapters.to_pyvista(scan.V, scan.F, atlas.TC, atlas.FTC), texture=texture)
plotter.view_vector((0.3, -1, 0.3), (0, 0, 1))
plotter.subplot(0, 1)
plotter.add_mesh(pv.Plane(direction=(0, 0, 1)), texture=texture, lighting=False)
plotter.view_xy()
plotter.camera.zoom(1.3)
plotter.show(screenshot="out/colours_into_glb.png")
