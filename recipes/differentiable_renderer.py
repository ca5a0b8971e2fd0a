"""
Texture coordinates for a differentiable renderer
=================================================

nvdiffrast and PyTorch3D take `uv` and `uv_idx`: texture coordinates, and the index of the texture coordinates
at each corner of the triangles. `adapters.to_torch` returns both as tensors with the dtypes and the device of
the mesh. This recipe learns a texture from the colours observed at points of the surface. It repeats the
steps of such a renderer at each pixel: interpolate `uv`, look up the texture, and follow the gradient.
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
# Make a ball, its atlas, and `uv` and `uv_idx`.
SIZE = 128
V, F = igl.upsample(*igl.icosahedron(), 3)
V /= np.linalg.norm(V, axis=1, keepdims=True)
atlas = unwrap(V, F, packing=Packing(resolution=SIZE))
if torch is None:
    print("torch is not installed: using the arrays of the atlas")
    uv, uv_idx = atlas.TC, atlas.FTC
else:
    vertices, faces = torch.tensor(V, dtype=torch.float32), torch.tensor(F, dtype=torch.int32)
    tensors = adapters.to_torch(vertices, faces, atlas.TC, atlas.FTC)
    print(f"tensors of {tensors[0].dtype} and {tensors[1].dtype} on {tensors[0].device}")
    uv, uv_idx = (tensor.numpy() for tensor in tensors)

# %%
# Find the texel of each pixel, as a renderer does: from its triangle and the weights of the corners.
rng = np.random.default_rng(0)
face = rng.choice(len(F), 200_000, p=igl.doublearea(V, F) / igl.doublearea(V, F).sum())
weights = rng.dirichlet((1, 1, 1), len(face))
points, texture_points = (
    np.einsum("pk,pkd->pd", weights, corners) for corners in (V[F[face]], uv[uv_idx[face]])
)
observed = 0.5 + 0.5 * np.sin(5 * points + [0, 1, 2])
column, row = (
    np.clip((x * SIZE).astype(int), 0, SIZE - 1) for x in (texture_points[:, 0], 1 - texture_points[:, 1])
)
texel = row * SIZE + column

# %%
# Learn the texture. The gradient of the squared error at a texel is twice the sum of the errors of its
# pixels.
texture = np.full((SIZE * SIZE, 3), 0.5)
pixels = np.maximum(np.bincount(texel, minlength=SIZE**2), 1)[:, None]
for step in range(30):
    error = texture[texel] - observed
    gradient = np.column_stack([2 * np.bincount(texel, e, SIZE**2) for e in error.T])
    texture -= 0.2 * gradient / pixels
    if step % 10 == 0:
        print(f"step {step}: root mean square error {np.sqrt((error**2).mean()):.3f}")
assert np.sqrt((error**2).mean()) < 0.05

# %%
# Draw the ball with the learned texture, and the texture itself.
image = pv.Texture(np.uint8(255 * texture.reshape(SIZE, SIZE, 3)))
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plotter.add_mesh(adapters.to_pyvista(V, F, uv, uv_idx), texture=image, lighting=False)
plotter.subplot(0, 1)
plotter.add_mesh(pv.Plane(direction=(0, 0, 1)), texture=image, lighting=False)
plotter.view_xy()
Path("out").mkdir(exist_ok=True)
plotter.show(screenshot="out/differentiable_renderer.png")
