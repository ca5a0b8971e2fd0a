"""`--bake`: what the command bakes into the texture of a GLB file."""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np

from .._types import FloatArray
from ..charts import Atlas
from ..errors import MeshError
from ..io import WITH_IMAGES, MeshFile
from ..textures import bake
from .arguments import choice

RESOLUTION = 2048  # if none is asked for
BAKE = choice(
    ("colors", "normals", "position"),
    help=f"bake a texture of --resolution texels ({RESOLUTION}) into a GLB, glTF or 3MF file, or beside "
    "an OBJ: the colours of the vertices, normals in the object's space (127.5 (n + 1)), or positions in the "
    "bounding cube",
)


def check_bake(kind: str | None, mesh: MeshFile, output: Path, pages: int | None) -> None:
    """Refuse before the work what cannot be baked."""
    if kind is None:
        return
    if output.suffix.lower() not in WITH_IMAGES:
        known = " or ".join(WITH_IMAGES)
        raise ValueError(f"--bake needs a file with a texture: give an output that ends in {known}")
    if pages is not None and pages > 1:
        raise ValueError("--bake writes one image: leave out --pages")
    if kind == "colors" and mesh.colours is None:
        raise MeshError(f"{mesh.path} has no colours at its vertices: bake normals or position")


def baked(kind: str, mesh: MeshFile, atlas: Atlas, resolution: int) -> FloatArray:
    """The image, from 0 to 1."""
    if atlas.pages > 1:
        raise MeshError(
            f"--bake writes one image, and the atlas has {atlas.pages} pages: use a smaller density"
        )
    V, triangles = mesh.V, mesh.triangles
    if kind == "colors":
        assert mesh.colours is not None
        return bake(V, mesh.F, atlas, mesh.colours[:, :3], resolution)
    if kind == "normals":
        normals = np.nan_to_num(igl.per_vertex_normals(V, triangles))
        image = bake(V, mesh.F, atlas, normals, resolution)
        length = np.linalg.norm(image, axis=2, keepdims=True)
        return np.asarray(image / np.where(length > 0, length, 1) / 2 + 0.5)
    used = V[np.unique(triangles)]
    low, size = used.min(axis=0), np.ptp(used, axis=0).max()
    return bake(V, mesh.F, atlas, (V - low) / (size if size > 0 else 1.0), resolution)
