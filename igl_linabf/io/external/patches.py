"""FreeSurfer's patches: the vertices of a surface that stay, with their places. nibabel knows no patches."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._types import BoolArray, FloatArray, IntArray
from ...errors import MeshError, MeshWarning, some, stack_level
from ...surface import Polygons, compact, patch_faces, topology_of
from ..mesh_file import MeshFile
from ..parsing import Damaged
from ..vertex_splits import split_vertices, to_single_precision

PATCH_MAGIC = b"\xff" * 4  # the version, -1; no surface has this for its first bytes
ROW_DTYPE = np.dtype([("vertex", ">i4"), ("place", ">f4", 3)])

# The surfaces on which cortices are measured, in the order in which they are looked for: midway between the
# white matter and the pial surface, or the mean of two.
SURFACE_NAMES = (
    ("fiducial",),
    ("midthickness",),
    ("smoothwm", "pial"),
    ("white", "pial"),
    ("smoothwm",),
    ("white",),
    ("pial",),
)


@dataclass(frozen=True, eq=False)
class Patch:
    """What is of a patch's file alone.

    Attributes
    ----------
    border : (#V,) bool
        The vertices that are flagged as those of the border.
    """

    border: BoolArray


def surfaces_beside(folder: Path, hemisphere: str) -> list[Path]:
    """The files, one or two, whose mean is the cortex of a hemisphere, "lh" or "rh", if they are there."""
    for names in SURFACE_NAMES:
        paths = [folder / f"{hemisphere}.{name}" for name in names]
        if all(path.is_file() for path in paths):
            return paths
    return []


def mean_surface(meshes: list[MeshFile]) -> MeshFile:
    """The first surface, its vertices midway to those of the second, if there are two."""
    first = meshes[0]
    for mesh in meshes[1:]:
        if mesh.V.shape != first.V.shape or not np.array_equal(mesh.polygons.corners, first.polygons.corners):
            raise MeshError(
                f"{first.path} has {len(first.V)} vertices and {mesh.path} {len(mesh.V)}, or other faces: "
                "they are not of one hemisphere"
            )
    return replace(first, V=np.mean([mesh.V for mesh in meshes], axis=0))


def parse_patch(path: Path, surface: MeshFile) -> MeshFile:
    """The part of the surface that a patch leaves, vertices by their numbers on the surface.

    The faces are those whose three vertices stay, in the largest piece. Of a flat patch the places are the
    texture coordinates.
    """
    rows = _read_rows(path.read_bytes())
    number = rows["vertex"].astype(np.int64)
    vertex, n = np.abs(number) - 1, len(surface.V)
    outside = np.flatnonzero(vertex >= n)
    if len(outside):
        raise MeshError(
            f"{path} has the vertices {some(vertex[outside])}, and its surface {surface.path} has {n}: give "
            "the surface from which it was cut"
        )
    is_kept, border = np.zeros((2, n), dtype=bool)
    is_kept[vertex], border[vertex[number < 0]] = True, True
    F = surface.triangles
    try:
        found = patch_faces(F, is_kept)
    except MeshError as error:
        raise MeshError(f"{path} on {surface.path}: {error}; is this the patch's own surface?") from None
    vertices, faces = compact(F[found.rows], n)
    interior = vertices[topology_of(faces, vertices).interior]
    slit_vertices = interior[border[interior]]
    remarks = [f"without {part}" for part in found.left_out]
    if len(slit_vertices):
        remarks.append(
            f"with closed slits at vertices {some(slit_vertices)}, which are flagged as border and lie inside: a "
            "patch is cut where vertices are left out, not along edges"
        )
    if remarks:
        message = f"{path} is read {'; '.join(remarks)}"
        warnings.warn(message, MeshWarning, stacklevel=stack_level())
    # what only the surface's file has, its volume for example, is not the patch's
    extras = replace(surface.extras, unshared=(), source=Patch(border))
    mesh = MeshFile(surface.V, Polygons.of_triangles(F[found.rows]), extras=extras)
    if rows["place"][:, 2].any():
        return mesh
    place = np.full((n, 2), np.nan)
    place[vertex] = rows["place"][:, :2]
    return mesh.textured(place)


def _read_rows(data: bytes) -> NDArray[Any]:
    """The rows of a patch's file; raises where they are not what its beginning says."""
    if len(data) < 8 or data[:4] != PATCH_MAGIC:
        raise Damaged("it does not begin as a patch, with -1 as a big-endian integer")
    count = int.from_bytes(data[4:8], "big")
    if len(data) != 8 + ROW_DTYPE.itemsize * count:
        raise Damaged(
            f"it has {len(data)} bytes, where {count} vertices take {8 + ROW_DTYPE.itemsize * count}"
        )
    rows = np.frombuffer(data, dtype=ROW_DTYPE, offset=8)
    vertex, occurrences = np.unique(np.abs(rows["vertex"].astype(np.int64)), return_counts=True)
    if not count or vertex[0] == 0 or (occurrences > 1).any():
        problem = "none" if not count else some(vertex[(occurrences > 1) | (vertex == 0)] - 1)
        raise Damaged(f"its vertices are numbered from 1, each once, and it has {problem} otherwise")
    if not np.isfinite(rows["place"]).all():
        raise Damaged("it has places that are no numbers")
    return rows


def save_patch(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write a flat patch: the vertices that have a place in the plane, by their numbers on the surface.

    Numbers count from 1, and are negative at the border: where the patch that was read has it, or else the
    boundary. The triangles are those of the surface.
    """
    split = split_vertices(mesh)
    vertex, times = np.unique(split.vertex, return_counts=True)
    if (times > 1).any():
        raise MeshError(
            f"vertices {some(vertex[times > 1])} are on seams, and a patch has one place for each: write "
            ".surf or .gii, or flatten a disk"
        )
    if isinstance(mesh.extras.source, Patch):
        border = mesh.extras.source.border[split.vertex]
    else:
        used, F = compact(mesh.triangles, len(mesh.V))
        border = np.isin(split.vertex, used[~topology_of(F, used).interior])
    write_patch(temporary, split.vertex, border, split.TC)


def write_patch(path: str, vertex: IntArray, border: BoolArray, place: FloatArray) -> None:
    """Write the vertices of a patch, with their places in the plane or in space."""
    rows = np.zeros(len(vertex), dtype=ROW_DTYPE)
    rows["vertex"] = np.where(border, -1, 1) * (vertex + 1)
    rows["place"][:, : place.shape[1]] = to_single_precision(place, "TC" if place.shape[1] == 2 else "V")
    Path(path).write_bytes(np.array([-1, len(rows)], dtype=">i4").tobytes() + rows.tobytes())
