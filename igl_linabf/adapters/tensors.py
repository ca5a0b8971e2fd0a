"""Tensors of PyTorch."""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..io import as_mesh_file
from ..surface import face_array, vertex_array

if TYPE_CHECKING:
    import torch


def from_torch(V: torch.Tensor, F: torch.Tensor) -> tuple[FloatArray, IntArray]:
    """Vertices and triangles as arrays, detached from the graph of gradients.

    Parameters
    ----------
    V : (#V, 3) tensor
        On any device.
    F : (#F, 3) tensor of integers

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        The tensors have other shapes.

    Examples
    --------
    The page on other libraries has one.
    """
    return vertex_array(V.detach().cpu().numpy()), face_array(F.detach().cpu().numpy())


def to_torch(
    V: torch.Tensor, F: torch.Tensor, TC: ArrayLike, FTC: ArrayLike | None = None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Texture coordinates as tensors like those of the mesh, as differentiable renderers take them.

    Parameters
    ----------
    V : (#V, 3) tensor
        The texture coordinates get its dtype and device.
    F : (#F, 3) tensor of integers
        Their rows get its dtype and device: int32 for nvdiffrast, int64 for PyTorch3D.
    TC : (#TC, 2) float
        Texture coordinates, or a map of `flatten`.
    FTC : (#F, 3) int, optional
        Their rows at the corners of the faces, as an atlas has them; `F` by default.

    Returns
    -------
    uv : (#TC, 2) tensor
        Without a gradient.
    uv_idx : (#F, 3) tensor

    Raises
    ------
    MeshError
        The arrays do not fit together, or are not finite.

    Examples
    --------
    The page on other libraries has one.
    """
    import torch

    mesh = as_mesh_file(*from_torch(V, F)).textured(TC, FTC)
    uv = torch.as_tensor(mesh.TC, dtype=V.dtype, device=V.device)
    return uv, torch.as_tensor(mesh.FTC, dtype=F.dtype, device=F.device)
