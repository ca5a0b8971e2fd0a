"""Convert meshes from and to PyTorch tensors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..io import as_mesh_file
from ..surface import face_array, vertex_array

if TYPE_CHECKING:
    import torch


def from_torch(V: torch.Tensor, F: torch.Tensor) -> tuple[FloatArray, IntArray]:
    """Return vertices and triangles as arrays, detached from the autograd graph.

    Parameters
    ----------
    V : (#V, 3) tensor
        A tensor on any device.
    F : (#F, 3) tensor of integers

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        A tensor has the wrong shape.

    Examples
    --------
    See the documentation page about other libraries.
    """
    return vertex_array(V.detach().cpu().numpy()), face_array(F.detach().cpu().numpy())


def to_torch(
    V: torch.Tensor, F: torch.Tensor, TC: ArrayLike, FTC: ArrayLike | None = None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return texture coordinates as tensors for differentiable renderers.

    Parameters
    ----------
    V : (#V, 3) tensor
        Determines the dtype and device of the texture coordinates.
    F : (#F, 3) tensor of integers
        Determines the dtype and device of the indices: int32 for nvdiffrast, int64 for PyTorch3D.
    TC : (#TC, 2) float
        Texture coordinates, or a map from `flatten`.
    FTC : (#F, 3) int, optional
        Rows of `TC` at the corners of the faces, such as the `FTC` of an atlas; `F` by default.

    Returns
    -------
    uv : (#TC, 2) tensor
        Texture coordinates without a gradient.
    uv_idx : (#F, 3) tensor

    Raises
    ------
    MeshError
        The arrays do not match, or are not finite.

    Examples
    --------
    See the documentation page about other libraries.
    """
    import torch

    mesh = as_mesh_file(*from_torch(V, F)).with_texture(TC, FTC)
    uv = torch.as_tensor(mesh.TC, dtype=V.dtype, device=V.device)
    return uv, torch.as_tensor(mesh.FTC, dtype=F.dtype, device=F.device)
