"""Read the seams of the options `--seams`."""

import warnings
from pathlib import Path
from typing import Any, Literal

import numpy as np

from .._types import FloatArray
from ..charts import ChartOptions, texture_seams, unwrap
from ..errors import MeshError
from ..io import MeshFile
from ..surface import Faces, Polygons
from .arguments import Option

SEAMS = Option(
    "auto, uv (seams of the file's texture coordinates), or a file of vertex pairs from 0", "SEAMS"
)
EXTEND_SEAMS = Option("add the seams that --seams lacks", flags=("--extend-seams",))


def read_seams(
    seams: Literal["auto", "uv"] | Path, mesh: MeshFile, charts: ChartOptions | None, method: Any
) -> Any:
    """Return the seam edges from texture coordinates or a file; None for automatic seams."""
    if seams == "auto":
        return None
    if seams != "uv":
        return read_rows(seams, np.int64, "integers: write two vertices on each line")
    if mesh.TC is None or mesh.FTC is None:
        raise MeshError(f"{mesh.path} has no texture coordinates: it has no texture seams")
    TC, FTC = _unwrap_bare_faces(mesh, charts, method) if mesh.bare.any() else (mesh.TC, mesh.FTC)
    return texture_seams(mesh.F, FTC, mesh.V, TC, sides=True)


def _unwrap_bare_faces(mesh: MeshFile, charts: ChartOptions | None, method: Any) -> tuple[FloatArray, Faces]:
    """Return the texture coordinates of a mesh; faces without them get an automatic atlas."""
    assert mesh.TC is not None and mesh.texture is not None
    corners, sizes = mesh.polygons.corners_of(np.flatnonzero(mesh.bare)), mesh.polygons.sizes[mesh.bare]
    bare = Polygons(mesh.polygons.corners[corners], sizes)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the whole mesh is unwrapped later, with the same warnings
        atlas = unwrap(mesh.V, bare.shaped, charts=charts, method=method, progress=False)
    texture = mesh.texture.copy()
    texture[corners] = len(mesh.TC) + bare.texture_of(atlas.FTC).corners
    beside = np.ceil(mesh.TC.max(axis=0)) + 1  # UDIM tiles without old texture coordinates
    return np.concatenate((mesh.TC, atlas.TC + beside)), mesh.polygons.shape(texture)


def read_rows(path: Path, kind: type, what: str) -> Any:
    """Read the rows of a text file; an empty file gives shape (0, 2)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # NumPy warns about an empty file
        try:
            table: Any = np.loadtxt(path, dtype=kind, ndmin=2, encoding="utf-8-sig")
        except FileNotFoundError:
            raise MeshError(f"there is no file {path}: name a table of {what}") from None
        except ValueError:
            raise MeshError(f"{path} is not a table of {what}") from None
    return table if table.size else table.reshape(0, 2)
