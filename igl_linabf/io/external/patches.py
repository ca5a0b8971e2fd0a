"""Read and write FreeSurfer patches, which store a subset of a surface's vertices with their positions."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._types import BoolArray, FloatArray, IntArray
from ...errors import MeshError, MeshWarning, first_few, format_count, stack_level
from ...surface import Polygons, build_topology, drop_unused_vertices, find_patch_faces
from ..mesh_file import MeshFile
from ..parsing import Damaged
from ..vertex_splits import split_vertices, to_single_precision

PATCH_MAGIC = b"\xff" * 4  # the integer -1; surface files begin with other bytes
ROW_DTYPE = np.dtype([("vertex", ">i4"), ("place", ">f4", 3)])

# Names of one or two surface files whose average is close to the surface midway between white matter and
# pial surface, best first.
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
    """The data that only patch files contain.

    Attributes
    ----------
    border : (#V,) bool
        Whether a vertex is flagged as a border vertex.
    """

    border: BoolArray


def find_companion_surfaces(folder: Path, hemisphere: str) -> list[Path]:
    """Return the best available surface of a hemisphere, "lh" or "rh": one file, or two files to average."""
    for names in SURFACE_NAMES:
        paths = [folder / f"{hemisphere}.{name}" for name in names]
        if all(path.is_file() for path in paths):
            return paths
    return []


def average_surfaces(meshes: list[MeshFile]) -> MeshFile:
    """Return the first surface with its vertex positions averaged over all surfaces."""
    first = meshes[0]
    for mesh in meshes[1:]:
        if mesh.V.shape != first.V.shape or not np.array_equal(mesh.polygons.corners, first.polygons.corners):
            raise MeshError(
                f"{first.path} has {format_count(len(first.V), 'vertex')} and {mesh.path} {len(mesh.V):,}, "
                "or their faces differ: they do not belong to the same hemisphere"
            )
    return replace(first, V=np.mean([mesh.V for mesh in meshes], axis=0))


def parse_patch(path: Path, surface: MeshFile) -> MeshFile:
    """Read the largest piece of a patch as a part of its surface; vertices keep the surface's numbers.

    Faces are included if all three vertices are in the patch. The positions of a flat patch become texture
    coordinates.
    """
    rows = _read_rows(path.read_bytes())
    number = rows["vertex"].astype(np.int64)
    vertex, n = np.abs(number) - 1, len(surface.V)
    outside = np.flatnonzero(vertex >= n)
    if len(outside):
        raise MeshError(
            f"{path} has the vertices {first_few(vertex[outside])}, and its surface {surface.path} has {n}: "
            "pass the surface from which the patch was cut"
        )
    is_kept, border = np.zeros((2, n), dtype=bool)
    is_kept[vertex], border[vertex[number < 0]] = True, True
    F = surface.triangles
    try:
        found = find_patch_faces(F, is_kept)
    except MeshError as error:
        raise MeshError(f"{path} on {surface.path}: {error}; is this the patch's own surface?") from None
    vertices, faces = drop_unused_vertices(F[found.rows], n)
    interior = vertices[build_topology(faces, vertices).is_interior]
    slit_vertices = interior[border[interior]]
    remarks = [f"without {part}" for part in found.left_out_descriptions]
    if len(slit_vertices):
        remarks.append(
            f"with closed slits at vertices {first_few(slit_vertices)}, which are flagged as border but are "
            "interior: a patch is cut by leaving out vertices, not along edges"
        )
    if remarks:
        message = f"{path} is read {'; '.join(remarks)}"
        warnings.warn(message, MeshWarning, stacklevel=stack_level())
    # do not warn that contents of the surface file, such as its MRI volume, are lost
    extras = replace(surface.extras, unshared=(), source=Patch(border))
    mesh = MeshFile(surface.V, Polygons.from_triangles(F[found.rows]), extras=extras)
    if rows["place"][:, 2].any():
        return mesh
    place = np.full((n, 2), np.nan)
    place[vertex] = rows["place"][:, :2]
    return mesh.with_texture(place)


def _read_rows(data: bytes) -> NDArray[Any]:
    """Return the rows of a patch file; raise `Damaged` if the rows do not match the header."""
    if len(data) < 8 or data[:4] != PATCH_MAGIC:
        raise Damaged("it does not begin with -1 as a big-endian integer, like a patch")
    count = int.from_bytes(data[4:8], "big")
    if len(data) != 8 + ROW_DTYPE.itemsize * count:
        raise Damaged(
            f"it has {len(data)} bytes instead of {8 + ROW_DTYPE.itemsize * count} for "
            f"{format_count(count, 'vertex')}"
        )
    rows = np.frombuffer(data, dtype=ROW_DTYPE, offset=8)
    vertex, occurrences = np.unique(np.abs(rows["vertex"].astype(np.int64)), return_counts=True)
    if not count or vertex[0] == 0 or (occurrences > 1).any():
        invalid = first_few(vertex[(occurrences > 1) | (vertex == 0)] - 1)
        raise Damaged(
            f"its vertex numbers are not distinct and positive at vertices {invalid}"
            if count
            else "it has no vertices"
        )
    if not np.isfinite(rows["place"]).all():
        raise Damaged("it has positions that are NaN or infinite")
    return rows


def save_patch(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write a flat patch: the number of each vertex on the surface, and its position in the plane.

    Vertex numbers count from 1, and are negative for border vertices. The border is the border of the patch
    that was read, or otherwise the boundary of the surface. A patch file stores no triangles.
    """
    split = split_vertices(mesh)
    vertex, times = np.unique(split.vertex, return_counts=True)
    if (times > 1).any():
        raise MeshError(
            f"vertices {first_few(vertex[times > 1])} are on seams, and a patch has one position per vertex: "
            "write .surf or .gii, or flatten a disk"
        )
    if isinstance(mesh.extras.source, Patch):
        border = mesh.extras.source.border[split.vertex]
    else:
        used, F = drop_unused_vertices(mesh.triangles, len(mesh.V))
        border = np.isin(split.vertex, used[~build_topology(F, used).is_interior])
    write_patch(temporary, split.vertex, border, split.TC)


def write_patch(path: str, vertex: IntArray, border: BoolArray, place: FloatArray) -> None:
    """Write the vertices of a patch with their positions in the plane or in space."""
    rows = np.zeros(len(vertex), dtype=ROW_DTYPE)
    rows["vertex"] = np.where(border, -1, 1) * (vertex + 1)
    rows["place"][:, : place.shape[1]] = to_single_precision(place, "TC" if place.shape[1] == 2 else "V")
    Path(path).write_bytes(np.array([-1, len(rows)], dtype=">i4").tobytes() + rows.tobytes())
