"""
Baking the details of a fine model into a texture
=================================================

The Stanford bunny has 102 k triangles. It is decimated to 3 k triangles, unwrapped, and given a texture in
which each texel stores the normal at the nearest point of the fine bunny. For this, `bake` calls a function
once, with the surface points of all texels.

From left to right: the coarse bunny, its texture, and the coarse bunny with the texture. The colours encode
the directions of the normals. The details of the fine model appear as lines that the coarse model does not
have::

    python demos/baking.py
"""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from stretch import bunny

from igl_linabf import Packing, unwrap
from igl_linabf.io import replacing, write_image, write_textured
from igl_linabf.textures import bake

RESOLUTION = 512

fine, triangles = bunny()
normals = igl.per_vertex_normals(fine, triangles)
V, F = igl.qslim(fine, triangles, 3000)[:2]
F = F.astype(np.int64)


def sample_normals(points: np.ndarray) -> np.ndarray:
    """Return the normals of the fine bunny at the points nearest to `points`, as colours."""
    _, face, nearest = igl.point_mesh_squared_distance(points, fine, triangles)
    a, b, c = (np.ascontiguousarray(fine[triangles[face, k]]) for k in range(3))
    weights = igl.barycentric_coordinates(nearest, a, b, c)
    n = np.einsum("pk,pkd->pd", weights, normals[triangles[face]])
    return n / np.linalg.norm(n, axis=1, keepdims=True) / 2 + 0.5


def build_surface(TC: np.ndarray) -> pv.PolyData:
    """Return the coarse bunny with texture coordinates."""
    corners = np.column_stack((np.full(len(F), 3), atlas.FTC))
    surface = pv.PolyData(V[atlas.origin], corners)
    surface.active_texture_coordinates = TC
    return surface


if __name__ == "__main__":
    atlas = unwrap(V, F, packing=Packing(resolution=RESOLUTION, padding=4))
    image = bake(V, F, atlas, sample_normals, RESOLUTION)
    coarse = bake(V, F, atlas, igl.per_vertex_normals(V, F), RESOLUTION)
    covered = np.linalg.norm(coarse, axis=2) > 0
    difference = np.linalg.norm((2 * image - 1 - coarse)[covered], axis=1)
    print(
        f"{len(F):,} triangles of {len(triangles):,}; {atlas.fill:.0%} of {RESOLUTION} x {RESOLUTION} texels"
    )
    print(f"directions of fine and coarse normals differ by {np.median(difference):.2f} in the median")
    assert atlas.good
    assert np.median(difference) > 0.05  # the normals of the fine bunny add details
    np.testing.assert_allclose(np.linalg.norm(2 * image[covered] - 1, axis=1), 1, atol=1e-9)

    Path("out").mkdir(exist_ok=True)
    write_image("out/baking_texture.png", image)
    write_textured("out/baking.glb", V, F, atlas.TC, atlas.FTC, image)
    pixels = np.ascontiguousarray((image * 255).round().astype(np.uint8))
    surface = build_surface(atlas.TC)
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(1, 3), off_screen=True, window_size=[2100, 700], border=False)
        plotter.add_mesh(surface, color="lightgray")
        plotter.subplot(0, 1)
        plane = pv.Plane(direction=(0, 0, 1))
        plotter.add_mesh(plane, texture=pv.Texture(pixels), lighting=False)
        plotter.view_xy()
        plotter.camera.zoom(1.4)
        plotter.subplot(0, 2)
        plotter.add_mesh(surface, texture=pv.Texture(pixels), lighting=False)
        for column in (0, 2):
            plotter.subplot(0, column)
            plotter.view_xy()
            plotter.camera.zoom(1.3)
        with replacing("out/baking.png") as temporary:
            plotter.show(screenshot=temporary)
        plotter.close()
    print("wrote out/baking.glb, .png and baking_texture.png")
