"""Read and write meshes in the format that the file's suffix selects."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import replacing
from .._types import FloatArray, IntArray
from ..errors import MeshError, first_few, format_count
from ..remesh import QuadGrid
from ..surface import Polygons, face_array, map_array, vertex_array
from .colours import replace_values_that_are_not_finite
from .formats import ImageArgument, parse_file, select_second_uv_set, write_atomically
from .mesh_file import MeshFile, check_corners, gather_at_triangles
from .obj import load_materials, save_obj
from .references import Folder


def read_mesh(path: str | os.PathLike[str], *, allow_outside: bool = False) -> tuple[FloatArray, IntArray]:
    """Read a triangle mesh.

    Parameters
    ----------
    path : path of a file that `read_file` reads
        Text or binary. Polygons are split into triangles; use `read_file` to keep them. In STL, corners at
        equal positions become one vertex.
    allow_outside : bool
        As in `read_file`.

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        The file is damaged or has no triangles; the message names the line. Or it is a folder, a pipe or a
        device.
    ValueError
        The suffix is unknown.
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
    path = Path(path)
    found = parse_file(path, allow_outside=allow_outside)
    F = gather_at_triangles(found, found.polygons.corners)
    if not len(found.V) or not len(F):
        raise _make_no_faces_error(path, found)
    return vertex_array(found.V), face_array(F)


def _make_no_faces_error(path: Path, found: MeshFile) -> MeshError:
    """Return the error for a file without faces."""
    hint = (
        "make a surface of these points first, for example with MeshLab's screened Poisson reconstruction"
        if len(found.V)
        else "is it a mesh?"
    )
    return MeshError(f"{path} holds {format_count(len(found.V), 'vertex')} and no faces: {hint}")


def read_file(
    path: str | os.PathLike[str],
    surface: str | os.PathLike[str] | None = None,
    *,
    partial: bool = False,
    allow_outside: bool = False,
    texcoord: int = 0,
) -> MeshFile:
    """Read a mesh with all contents of its file: polygons, normals, colours, materials and parts.

    Parameters
    ----------
    path : path of an OBJ, OFF, PLY, STL, glTF, GLB, 3MF, GIFTI, FreeSurfer or VTP file
    surface : path, optional
        The surface that contains a FreeSurfer patch. By default, it is found next to the patch by
        FreeSurfer's file names (docs/cortex.md).
    partial : bool
        Keep texture coordinates that only some corners have, and use the index -1 at all other corners.
        `check_uv` accepts such indices.
    allow_outside : bool
        Follow references of the file, such as images and material libraries, to files outside its folder. By
        default these are refused, because a file from a stranger may refer to any file of this computer.
    texcoord : {0, 1}
        With 1, `mesh.TC` are the second texture coordinates of a GLB, glTF or PLY file, for example for
        lightmaps, and `mesh.first` holds the first coordinates. `write_file(..., texcoord=1)` then replaces
        the second coordinates.

    Returns
    -------
    MeshFile
        Pass `mesh.V` and `mesh.F` to `unwrap`; `write_file` writes the other contents unchanged.

    Raises
    ------
    MeshError
        The file is damaged or has no faces; it is a folder, a pipe or a device; it refers to a file outside
        its folder; or the surface of a patch is missing or does not match it.
    ValueError
        The suffix is unknown; a surface is given, but the file is not a patch; or the format has no second
        texture coordinates.
    ImportError
        The package that reads this format is missing; the message states the pip command.
    OSError
        The file does not exist or cannot be read.

    Warns
    -----
    MeshWarning
        Only the largest of several pieces of a patch is read, a patch has closed slits, or colours that are
        NaN or infinite are read as white.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "quad.obj")
    >>> with open(path, "w") as file:
    ...     _ = file.write("o page\\nv 0 0 0\\nv 1 0 0\\nv 1 1 0\\nv 0 1 0\\nf 1 2 3 4\\n")
    >>> mesh = read_file(path)
    >>> mesh.F.tolist(), mesh.parts
    ([[0, 1, 2, 3]], ('page',))
    """
    if texcoord not in (0, 1):
        raise ValueError(f"texcoord is {texcoord!r}: pass 0, or 1 for second texture coordinates")
    path = Path(path)
    found = parse_file(path, surface, allow_outside)
    if not len(found.V) or not len(found.polygons):
        raise _make_no_faces_error(path, found)
    looks = load_materials(found.extras, Folder(path.parent, allow_outside))
    extras = replace_values_that_are_not_finite(looks, path.name)
    mesh = replace(found, V=vertex_array(found.V), extras=extras, path=path, allow_outside=allow_outside)
    if texcoord:
        mesh = select_second_uv_set(mesh, path)
    if mesh.TC is None or mesh.texture is None or not len(mesh.TC):
        return replace(mesh, TC=None, texture=None)
    is_partial = (mesh.texture < 0).any()
    if (mesh.texture < 0).all() or (is_partial and not partial):
        return replace(mesh, TC=None, texture=None)
    if is_partial:
        mesh = replace(mesh, texture=np.maximum(mesh.texture, -1))  # -2 is an OBJ index before the first row
    return mesh


def write_file(
    path: str | os.PathLike[str],
    mesh: MeshFile,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    image: ImageArgument = None,
    *,
    force: bool = False,
    texcoord: int = 0,
) -> None:
    """Write a mesh from `read_file` with new texture coordinates; the suffix selects the format.

    For an OBJ file, materials from another format are written to an MTL file of the same name next to it.

    Parameters
    ----------
    path : path of an OBJ, PLY, GLB, glTF, 3MF, VTP, GIFTI or FreeSurfer file
    mesh : MeshFile
    TC : (#TC, 2) float
        Texture coordinates, v upwards.
    FTC : same shape as `mesh.F`, optional
        Rows of `TC` at the corners; by default `mesh.F`.
    image : (#rows, #columns[, 1 to 4]) float, optional
        The texture, from 0 to 1, as returned by `bake`. It is embedded in GLB, glTF and 3MF, and written as a
        PNG file next to OBJ. For an atlas of several pages, pass a list of images or an array
        (#pages, #rows, #columns, k); each material is then copied for each page. A dict of images with the
        keys of `image_maps(mesh)` replaces the old images.
    force : bool
        Replace existing MTL and PNG files next to an OBJ file. The file itself is always replaced.
    texcoord : {0, 1}
        With 1, `TC` are second texture coordinates, for example for lightmaps; the first set and its images
        are kept. The second set is stored as TEXCOORD_1 in GLB and glTF, as `s1` and `t1` or `texcoord1` in
        PLY, and in a second file for OBJ.

    Raises
    ------
    MeshError
        The arrays do not match the faces.
    ValueError
        The suffix is unknown, or the format cannot hold an image or second texture coordinates.
    ImportError
        The package that writes this format is missing.
    OSError
        The file cannot be written, or a file next to it exists. In that case nothing is left behind.

    Warns
    -----
    MeshWarning
        The format does not keep all contents of the mesh; the message lists the losses.

    Examples
    --------
    >>> import os, tempfile
    >>> folder = tempfile.mkdtemp()
    >>> with open(os.path.join(folder, "quad.obj"), "w") as file:
    ...     _ = file.write("o page\\nv 0 0 0\\nv 1 0 0\\nv 1 1 0\\nv 0 1 0\\nf 1 2 3 4\\n")
    >>> mesh = read_file(os.path.join(folder, "quad.obj"))
    >>> write_file(os.path.join(folder, "page.obj"), mesh, mesh.V[:, :2])
    >>> read_file(os.path.join(folder, "page.obj")).FTC.tolist()
    [[0, 1, 2, 3]]
    """
    with write_atomically(path, mesh, TC, FTC, image, force=force, texcoord=texcoord):
        pass


def read_texture(path: str | os.PathLike[str]) -> tuple[FloatArray, IntArray]:
    """Read the texture coordinates of an OBJ or PLY file.

    Parameters
    ----------
    path : path of an OBJ or PLY file

    Returns
    -------
    TC : (#TC, 2) float64
    FTC : (#F, 3) int64
        Rows of `TC` at the corners of the triangles of `read_mesh`.

    Raises
    ------
    MeshError
        The file is damaged, or a corner has no texture coordinates.
    ValueError
        It is not an OBJ or PLY file.
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
    if path.suffix.lower() not in (".obj", ".ply"):
        raise ValueError(f"{path} is not an OBJ or PLY file: texture coordinates are read only from these")
    found = parse_file(path)
    if not len(found.polygons):
        raise _make_no_faces_error(path, found)
    TC, texture = found.TC, found.texture
    if TC is None or texture is None or not len(TC) or (texture == -1).all():
        raise MeshError(f"{path} has no texture coordinates at its faces (vt, f v/vt): unwrap it first")
    FTC = gather_at_triangles(found, texture)
    bare = np.flatnonzero((FTC == -1).any(axis=1))
    if len(bare):
        raise MeshError(
            f"{path} has no texture coordinates at corners of the faces {first_few(bare)}: add vt indices "
            "there"
        )
    check_corners(TC, Polygons.from_triangles(FTC), f"the f lines of {path}", "vt")
    return TC, FTC


def write_obj(path: str | os.PathLike[str], V: ArrayLike, F: ArrayLike, uv: ArrayLike) -> None:
    """Write a surface with its flat map as texture coordinates (`vt`).

    Parameters
    ----------
    path : path of the OBJ file
    V : (#V, 3) float
    F : (#F, 3) int
    uv : (#V, 2) float
        Written unchanged; use `unit_square` to scale it to the unit square. Vertices without coordinates
        (NaN) get no `vt`.

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
    positions, faces = vertex_array(V), face_array(F)
    map_ = map_array(uv, len(positions))
    mapped = np.asarray(np.isfinite(map_).all(axis=1))
    missing = np.flatnonzero(~mapped[faces].all(axis=1))
    if len(missing):
        raise MeshError(f"face {missing[0]} has a vertex without coordinates in uv: pass a map of all faces")
    _write_as_obj(path, MeshFile(positions, Polygons.from_triangles(faces)).with_texture(map_))


def write_mesh(
    path: str | os.PathLike[str], V: ArrayLike, F: ArrayLike, TC: ArrayLike, FTC: ArrayLike | None = None
) -> None:
    """Write a surface with texture coordinates; the suffix selects the format.

    OBJ has separate indices for positions and texture coordinates. Therefore the surface stays connected
    along seams. Numbers in OBJ are written with all their digits and are read back exactly. PLY stores
    texture coordinates at vertices (`s`, `t`), or as lists at the triangles (`texcoord`) if there are seams.
    GLB stores them at vertices only; therefore a vertex is written once for each of its texture coordinates.
    In PLY, vertices of polygons along seams are duplicated, too. Texture coordinates in PLY and all numbers
    in GLB are **32-bit floats** with seven digits; positions in PLY are doubles. In GLB v is flipped, as glTF
    requires; readers flip it back.

    Parameters
    ----------
    path : path of a file that `write_file` writes
    V : (#V, 3) float
    F : (#F, 3) or (#F, k) int, or list of lists of int
        Triangles or polygons; OBJ, PLY, GLB, glTF and VTP keep polygons.
    TC : (#TC, 2) float
        Texture coordinates, v upwards. Rows that are not finite are skipped; no corner may refer to one.
    FTC : (#F, 3) int, or same shape as `F`, optional
        Rows of `TC` at the corners; by default `F`, for texture coordinates at vertices.

    Raises
    ------
    MeshError
        Indices are out of range, or coordinates are not finite or too large for 32-bit floats.
    ValueError
        The suffix is unknown.
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
    with write_atomically(path, as_mesh_file(V, F), TC, FTC):
        pass


def write_textured(
    path: str | os.PathLike[str],
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike,
    image: ArrayLike,
    *,
    force: bool = False,
) -> None:
    """Write a surface with an image as its texture.

    The image is embedded in GLB, glTF and 3MF. For OBJ it is a PNG file of the same name, which an MTL file
    next to the OBJ file refers to.

    Parameters
    ----------
    path : path of a GLB, glTF, OBJ or 3MF file
    V : (#V, 3) float
    F : (#F, 3) int, or polygons
    TC : (#TC, 2) float
        Texture coordinates in the unit square, v upwards.
    FTC : (#F, 3) int, or same shape as `F`
    image : (#rows, #columns[, 1 to 4]) float
        From 0 to 1, top row first, as returned by `bake`. Viewers interpret the values as sRGB.
    force : bool
        Replace existing MTL and PNG files next to an OBJ file.

    Raises
    ------
    MeshError
        An array has the wrong shape.
    ValueError
        The suffix is unknown, or the format cannot hold an image.
    OSError
        The file cannot be written, or a file next to it exists. In that case nothing is left behind.

    Examples
    --------
    >>> import igl, igl_linabf, os, tempfile
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F, packing=igl_linabf.Packing(resolution=64))
    >>> path = os.path.join(tempfile.mkdtemp(), "ball.glb")
    >>> image = igl_linabf.textures.bake(V, F, atlas, V / 2 + 0.5, 64)
    >>> write_textured(path, V, F, atlas.TC, atlas.FTC, image)
    >>> os.path.getsize(path) > 1000
    True
    """
    with write_atomically(path, as_mesh_file(V, F), TC, FTC, image, force=force):
        pass


def as_mesh_file(V: ArrayLike, F: ArrayLike) -> MeshFile:
    """Return a surface as a `MeshFile`; raise if faces refer to missing or non-finite vertices."""
    positions, faces = vertex_array(V), Polygons.from_faces(F)
    check_corners(positions, faces, "F", "V")
    return MeshFile(positions, faces)


def _write_as_obj(path: str | os.PathLike[str], mesh: MeshFile) -> None:
    """Write an OBJ file, whatever the suffix is."""
    with replacing(path) as temporary:
        save_obj(temporary, mesh, Path(path))


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
    >>> grid = igl_linabf.remesh.quad_grid(V, F[1:], igl_linabf.linabf(V, F[1:]))
    >>> path = os.path.join(tempfile.mkdtemp(), "grid.obj")
    >>> write_grid(path, grid)
    >>> os.path.getsize(path) > 50_000
    True
    """
    _write_as_obj(path, MeshFile(grid.V, Polygons.from_faces(grid.faces)).with_texture(grid.uv))


def unit_square(uv: ArrayLike) -> FloatArray:
    """Return the map, translated and uniformly scaled to fit [0, 1] x [0, 1].

    Parameters
    ----------
    uv : (#V, 2) float
        NaN rows stay NaN.

    Returns
    -------
    uv : (#V, 2) float64
        The longer side of its bounding box has length 1; the minimum of u and of v is 0.

    Examples
    --------
    >>> unit_square([[-2, 0], [2, 0], [0, 2]]).tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5]]
    """
    map_ = vertex_array(uv, 2, "uv")
    low, high = np.nanmin(map_, axis=0), np.nanmax(map_, axis=0)
    return np.asarray((map_ - low) / (high - low).max())
