"""Meshes of other libraries: arrays out of them, and texture coordinates into them.

In: a mesh of trimesh, pyvista, meshio or Open3D, or tensors of PyTorch. Out: V, F; and such a mesh again,
with the texture coordinates where its library looks for them.
"""

from .meshes import (
    from_meshio,
    from_open3d,
    from_pyvista,
    from_trimesh,
    to_meshio,
    to_open3d,
    to_pyvista,
    to_trimesh,
    vertex_map,
)
from .tensors import from_torch, to_torch

__all__ = [
    "from_meshio",
    "from_open3d",
    "from_pyvista",
    "from_torch",
    "from_trimesh",
    "to_meshio",
    "to_open3d",
    "to_pyvista",
    "to_torch",
    "to_trimesh",
    "vertex_map",
]
