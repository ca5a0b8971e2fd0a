"""
Unwrapping from a Blender script
================================

Run this script in the text editor of Blender, with the extension installed. It reads the polygons of the
active object, and writes the atlas to the UV layer of the object. Outside Blender, a generated torus replaces
the object.

The operator of the extension does the same, and also marks the seams::

    bpy.ops.uv.linabf_unwrap(seams="FOUND")
"""

from pathlib import Path

import numpy as np

from igl_linabf import Packing, unwrap

try:
    import bpy
except ImportError:
    bpy = None

# %%
# Get the vertices and the polygons. Quadrangles are not split.
if bpy is not None:
    if bpy.context.active_object is None or bpy.context.active_object.type != "MESH":
        bpy.ops.mesh.primitive_torus_add(major_segments=36, minor_segments=16)
    mesh = bpy.context.active_object.data
    V = np.array([vertex.co for vertex in mesh.vertices], dtype=float)
    F = [list(polygon.vertices) for polygon in mesh.polygons]
else:
    i, j = np.meshgrid(np.arange(36), np.arange(16), indexing="ij")
    a, b = i.ravel() * np.pi / 18, j.ravel() * np.pi / 8
    r = 1 + 0.25 * np.cos(b)
    V = np.column_stack((r * np.cos(a), r * np.sin(a), 0.25 * np.sin(b)))
    right, up = (i + 1) % 36, (j + 1) % 16
    corners = (i * 16 + j, right * 16 + j, right * 16 + up, i * 16 + up)
    F = np.stack([corner.ravel() for corner in corners], axis=1)

# %%
# Unwrap the mesh. `FTC` has an index into `TC` for each corner of the polygons, in the order of Blender's
# loops.
atlas = unwrap(V, F, packing=Packing(resolution=1024))
loops = np.concatenate([atlas.TC[corners] for corners in atlas.FTC])
print(atlas)
assert atlas.good
assert loops.shape == (sum(map(len, F)), 2)
assert loops.min() >= 0 and loops.max() <= 1

# %%
# Write the UV layer, or draw a picture.
if bpy is not None:
    layer = mesh.uv_layers.active or mesh.uv_layers.new()
    layer.uv.foreach_set("vector", loops.astype(np.float32).ravel())
    written = np.empty(loops.size, dtype=np.float32)
    layer.uv.foreach_get("vector", written)
    assert np.allclose(written, loops.ravel(), atol=1e-6)
else:
    import pyvista as pv

    from igl_linabf.plot import plot_checkerboard, plot_uv

    triangles, triangles_of_map = (
        np.asarray(polygons)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3) for polygons in (F, atlas.FTC)
    )
    plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
    plot_checkerboard(V, triangles, atlas, plotter=plotter)
    plotter.subplot(0, 1)
    plot_uv(atlas.TC, triangles_of_map, plotter=plotter)
    Path("out").mkdir(exist_ok=True)
    plotter.show(screenshot="out/blender_python.png")
