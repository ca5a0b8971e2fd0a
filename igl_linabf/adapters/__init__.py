"""Convert meshes of other libraries to arrays, and arrays to meshes with texture coordinates.

Supported are meshes of trimesh, pyvista, meshio and Open3D, and tensors of PyTorch.
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
