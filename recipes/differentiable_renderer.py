"""
Texture coordinates for a differentiable renderer
=================================================

nvdiffrast and PyTorch3D take `uv, uv_idx`: texture coordinates, and their rows at the corners of the
triangles. `adapters.to_torch` gives them as tensors like those of the mesh. Here a texture is learned from
colours that were seen at points of the surface, by what such renderers do at a pixel: interpolate uv, look
up the texture, go down the gradient.
"""

from pathlib import Path

import igl
import numpy as np
import pyvista as pv

from igl_linabf import Packing, adapters, unwrap

try:
    import torch
except ImportError:
    torch = None

# %%
# A ball, its atlas, and `uv, uv_idx`.
SIZE = 128
V, F = igl.upsample(*igl.icosahedron(), 3)
V /= np.linalg.norm(V, axis=1, keepdims=True)
atlas = unwrap(V, F, method="isometric", packing=Packing(resolution=SIZE))
if torch is None:
    print("torch is not installed: the arrays serve as they are")
    uv, uv_idx = atlas.TC, atlas.FTC
else:
    vertices, faces = torch.tensor(V, dtype=torch.float32), torch.tensor(F, dtype=torch.int32)
    tensors = adapters.to_torch(vertices, faces, atlas.TC, atlas.FTC)
    print(f"tensors of {tensors[0].dtype} and {tensors[1].dtype} on {tensors[0].device}")
    uv, uv_idx = (tensor.numpy() for tensor in tensors)

# %%
# What a renderer does at each pixel: the triangle and the weights of its corners give the place in the
# texture.
rng = np.random.default_rng(0)
face = rng.choice(len(F), 200_000, p=igl.doublearea(V, F) / igl.doublearea(V, F).sum())
weights = rng.dirichlet((1, 1, 1), len(face))
points, places = (np.einsum("pk,pkd->pd", weights, of) for of in (V[F[face]], uv[uv_idx[face]]))
seen = 0.5 + 0.5 * np.sin(5 * points + [0, 1, 2])
column, row = (np.clip((x * SIZE).astype(int), 0, SIZE - 1) for x in (places[:, 0], 1 - places[:, 1]))
texel = row * SIZE + column

# %%
# Learn the texture: the gradient of the squared error, by texel, is twice the error summed over its pixels.
texture = np.full((SIZE * SIZE, 3), 0.5)
pixels = np.maximum(np.bincount(texel, minlength=SIZE**2), 1)[:, None]
for step in range(30):
    error = texture[texel] - seen
    gradient = np.column_stack([2 * np.bincount(texel, e, SIZE**2) for e in error.T])
    texture -= 0.2 * gradient / pixels
    if step % 10 == 0:
        print(f"step {step}: root mean square error {np.sqrt((error**2).mean()):.3f}")
assert np.sqrt((error**2).mean()) < 0.05

# %%
# The ball with the texture that was learned, and the texture.
image = pv.Texture(np.uint8(255 * texture.reshape(SIZE, SIZE, 3)))
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plotter.add_mesh(adapters.to_pyvista(V, F, uv, uv_idx), texture=image, lighting=False)
plotter.subplot(0, 1)
plotter.add_mesh(pv.Plane(direction=(0, 0, 1)), texture=image, lighting=False)
plotter.view_xy()
Path("out").mkdir(exist_ok=True)
plotter.show(screenshot="out/differentiable_renderer.png")
