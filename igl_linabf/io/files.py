"""Read and write meshes; the suffix chooses the format."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
from numpy.typing import ArrayLike

from .._runtime import replacing
from .._types import FloatArray, IntArray
from ..errors import MeshError, some
from ..remesh import QuadGrid
from ..surface import face_array, vertex_array
from .corners import check_corners, textured
from .gltf import save_glb
from .obj import parse_obj, save_obj, save_polygons
from .off import parse_off
from .parsing import Damaged, Parsed
from .ply import parse_ply, save_ply
from .stl import parse_stl

READERS: dict[str, Callable[[bytes, str], Parsed]] = {
    ".obj": parse_obj,
    ".off": lambda data, _: parse_off(data),
    ".ply": lambda data, _: parse_ply(data),
    ".stl": lambda data, _: parse_stl(data),
}
WRITERS = {".obj": save_obj, ".ply": save_ply, ".glb": save_glb}


def read_mesh(path: str | os.PathLike[str]) -> tuple[FloatArray, IntArray]:
    """Read a triangle mesh.

    Parameters
    ----------
    path : path of an OBJ, OFF, PLY or STL file
        Text or binary. Polygons are split into fans of triangles. In STL, corners at equal
        positions become one vertex.

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        The file is damaged or has no triangles; the text names the line.
    OSError
        The file does not exist or cannot be read.

    Warns
    -----
    MeshWarning
        An OBJ file has lines that are not OBJ statements; they are skipped.

    Examples
    --------
    >>> import igl, os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "icosahedron.off")
    >>> igl.write_triangle_mesh(path, *igl.icosahedron())
    >>> V, F = read_mesh(path)
    >>> V.shape, F.shape
    ((12, 3), (20, 3))
    """
    V, F, _, _ = _parsed(path)
    if not len(V) or not len(F):
        raise MeshError(f"{path} holds {len(V)} vertices and no triangles: is it a mesh?")
    if Path(path).suffix.lower() == ".stl":
        V, _, _, F = igl.remove_duplicate_vertices(V, F, 0.0)
    return vertex_array(V), face_array(F)


def read_texture(path: str | os.PathLike[str]) -> tuple[FloatArray, IntArray]:
    """Read the texture coordinates of an OBJ file.

    Parameters
    ----------
    path : path of an OBJ file

    Returns
    -------
    TC : (#TC, 2) float64
    FTC : (#F, 3) int64
        Indices at the corners; rows as in `read_mesh`, which splits polygons.

    Raises
    ------
    MeshError
        It is not an OBJ file, it is damaged, or a corner has no texture coordinates.
    OSError
        The file does not exist or cannot be read.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "one.obj")
    >>> with open(path, "w") as file:
    ...     _ = file.write("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nvt 0 0\\nvt 1 0\\nvt 0 1\\nf 1/1 2/2 3/3\\n")
    >>> read_texture(path)[0].tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    """
    path = Path(path)
    if path.suffix.lower() != ".obj":
        raise MeshError(f"{path} is not an OBJ file: only OBJ files are read for texture coordinates")
    _, F, TC, FTC = _parsed(path)
    if not len(F):
        raise MeshError(f"{path} has no faces: is it a mesh?")
    if not len(TC) or (FTC == -1).all():
        raise MeshError(f"{path} has no texture coordinates at its faces (vt, f v/vt): unwrap it first")
    bare = np.flatnonzero((FTC == -1).any(axis=1))
    if len(bare):
        raise MeshError(
            f"{path} has no texture coordinates at corners of the faces {some(bare)}: add vt indices there"
        )
    check_corners(TC, FTC, f"the f lines of {path}", "vt")
    return TC, FTC


def _parsed(path: str | os.PathLike[str]) -> Parsed:
    path = Path(path)
    if path.suffix.lower() not in READERS:
        raise MeshError(f"{path} is not a mesh file: use one that ends in {', '.join(READERS)}")
    return parse(path.read_bytes(), path.suffix.lower(), str(path))


def parse(data: bytes, suffix: str, name: str) -> Parsed:
    """The mesh in the bytes of a file.

    Parameters
    ----------
    data : bytes
    suffix : {".obj", ".off", ".ply", ".stl"}
    name : str
        Name of the file in messages.

    Raises
    ------
    MeshError
        The file is damaged; the text says where.

    Warns
    -----
    MeshWarning
        An OBJ file has lines that are not OBJ statements; they are skipped.
    """
    try:
        return READERS[suffix](data, name)
    except Damaged as damage:
        raise MeshError(f"{name} cannot be read as {suffix[1:].upper()}: {damage}") from None


def write_obj(path: str | os.PathLike[str], V: ArrayLike, F: ArrayLike, uv: ArrayLike) -> None:
    """Write a surface with its flat map as texture coordinates (`vt`).

    Parameters
    ----------
    path : path of the OBJ file
    V : (#V, 3) float
    F : (#F, 3) int
    uv : (#V, 2) float
        Written unchanged; `unit_square` scales it to the range of textures. Vertices without
        coordinates (NaN) get no `vt`.

    Raises
    ------
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import igl, igl_linabf, os, tempfile
    >>> V, F = igl.icosahedron()
    >>> path = os.path.join(tempfile.mkdtemp(), "flat.obj")
    >>> write_obj(path, V, F[1:], igl_linabf.linabf(V, F[1:]))
    >>> igl.readOBJ(path)[1].shape
    (12, 2)
    """
    positions, faces, map_ = vertex_array(V), face_array(F), vertex_array(uv, 2, "uv")
    if len(map_) != len(positions):
        raise MeshError(f"uv has {len(map_)} rows for {len(positions)} vertices: pass one row a vertex")
    mapped = np.asarray(np.isfinite(map_).all(axis=1))
    missing = np.flatnonzero(~mapped[faces].all(axis=1))
    if len(missing):
        raise MeshError(f"face {missing[0]} has a vertex without coordinates in uv: pass a map of all faces")
    with replacing(path) as temporary:
        save_obj(temporary, positions, faces, map_, faces)


def write_mesh(
    path: str | os.PathLike[str], V: ArrayLike, F: ArrayLike, TC: ArrayLike, FTC: ArrayLike | None = None
) -> None:
    """Write a surface with texture coordinates; the suffix chooses the format.

    OBJ has separate indices for positions and texture coordinates, so the surface stays connected
    along seams; numbers are written exactly. PLY and GLB have texture coordinates at vertices only:
    a vertex is written once for each of its texture coordinates. Texture coordinates in PLY (`s`,
    `t`) and everything in GLB are **32-bit floats**, seven digits; positions in PLY are doubles. In
    GLB v is flipped, as glTF requires; readers undo this.

    Parameters
    ----------
    path : path of an OBJ, PLY or GLB file
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
        Texture coordinates, v upwards. Rows that are not finite are left out; no corner may use one.
    FTC : (#F, 3) int, optional
        Indices of the texture coordinates at the corners; by default `F`, for coordinates at
        vertices.

    Raises
    ------
    MeshError
        The suffix is none of the three, indices are out of range, or coordinates are not finite or
        too large for 32-bit floats.
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "two.obj")
    >>> V, F = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    >>> TC, FTC = [[0, 0], [1, 0], [1, 1], [2, 0], [3, 1], [2, 1]], [[0, 1, 2], [3, 4, 5]]
    >>> write_mesh(path, V, F, TC, FTC)
    >>> read_texture(path)[1].tolist()
    [[0, 1, 2], [3, 4, 5]]
    """
    suffix = Path(path).suffix.lower()
    if suffix not in WRITERS:
        raise MeshError(f"{path} has an unknown suffix: use {', '.join(WRITERS)}")
    positions, faces, map_, corners = textured(V, F, TC, FTC)
    with replacing(path) as temporary:
        WRITERS[suffix](temporary, positions, faces, map_, corners)


def write_grid(path: str | os.PathLike[str], grid: QuadGrid) -> None:
    """Write a grid as an OBJ file of polygons, with its flat map as texture coordinates.

    Parameters
    ----------
    path : path of the OBJ file
    grid : QuadGrid

    Raises
    ------
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import igl, igl_linabf, os, tempfile
    >>> V, F = igl.icosahedron()
    >>> grid = igl_linabf.quad_grid(V, F[1:], igl_linabf.linabf(V, F[1:]))
    >>> path = os.path.join(tempfile.mkdtemp(), "grid.obj")
    >>> write_grid(path, grid)
    >>> os.path.getsize(path) > 50_000
    True
    """
    corners = (np.repeat(face + 1, 2).tolist() for face in grid.faces)  # v and vt are of one index
    with replacing(path) as temporary:
        save_polygons(temporary, grid.V, grid.uv, corners)


def unit_square(uv: ArrayLike) -> FloatArray:
    """The map moved and uniformly scaled into [0, 1] x [0, 1].

    Parameters
    ----------
    uv : (#V, 2) float
        NaN rows stay NaN.

    Returns
    -------
    uv : (#V, 2) float64
        Its longer side has length 1; the minimum of u and of v is 0.

    Examples
    --------
    >>> unit_square([[-2, 0], [2, 0], [0, 2]]).tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5]]
    """
    map_ = vertex_array(uv, 2, "uv")
    low, high = np.nanmin(map_, axis=0), np.nanmax(map_, axis=0)
    return np.asarray((map_ - low) / (high - low).max())
