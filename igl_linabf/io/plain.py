"""Meshes from files, flat maps into files; an output file appears whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import igl
import numpy as np
from numpy.typing import ArrayLike

from .._runtime import undone_at_once
from ..errors import MeshError
from ..surface import FloatArray, IntArray, face_array, vertex_array
from .formats import parse_file


def read_mesh(path: str | os.PathLike[str]) -> tuple[FloatArray, IntArray]:
    """Read a triangle mesh.

    Parameters
    ----------
    path : path of an OBJ, OFF, PLY or STL file
        Text or binary. Polygons are split into fans of triangles; STL's corners at equal positions
        become one vertex.

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        The file is damaged, with its line, or has no triangles.
    OSError
        There is no such file, or it may not be read.

    Warns
    -----
    MeshWarning
        An OBJ has lines that are no statements of that format.

    Examples
    --------
    >>> import igl, os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "icosahedron.off")
    >>> igl.write_triangle_mesh(path, *igl.icosahedron())
    >>> V, F = read_mesh(path)
    >>> V.shape, F.shape
    ((12, 3), (20, 3))
    """
    parsed = parse_file(path)
    V, F = parsed.V, parsed.F
    if not len(V) or not len(F):
        raise MeshError(f"{path} holds {len(V)} vertices and no triangles: is it a mesh?")
    if Path(path).suffix.lower() == ".stl":
        V, _, _, F = igl.remove_duplicate_vertices(V, F, 0.0)
    return vertex_array(V), face_array(F)


def unit_square(uv: ArrayLike) -> FloatArray:
    """The map moved and scaled, as a whole, into [0, 1] x [0, 1].

    Parameters
    ----------
    uv : (#V, 2) float
        NaN rows stay.

    Returns
    -------
    uv : (#V, 2) float64
        Its longer side is 1 long, and both begin at 0.

    Examples
    --------
    >>> unit_square([[-2, 0], [2, 0], [0, 2]]).tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5]]
    """
    map_ = vertex_array(uv, 2, "uv")
    low, high = np.nanmin(map_, axis=0), np.nanmax(map_, axis=0)
    return np.asarray((map_ - low) / (high - low).max())


def write_obj(path: str | os.PathLike[str], V: ArrayLike, F: ArrayLike, uv: ArrayLike) -> None:
    """Write a surface with its flat map as texture coordinates (`vt`).

    Parameters
    ----------
    path : path of the OBJ file
    V : (#V, 3) float
    F : (#F, 3) int
    uv : (#V, 2) float
        As it is: `unit_square` brings it where textures are. Vertices without coordinates (NaN)
        get no `vt`.

    Raises
    ------
    OSError
        The file cannot be written; nothing is left behind then.

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
    number = np.cumsum(mapped)
    with replacing(path) as temporary, open(temporary, "w", encoding="ascii") as file:
        file.write("# igl_linabf\n")
        for keyword, rows in (("v", positions), ("vt", map_[mapped])):
            file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in rows.tolist())
        corners = np.stack((faces + 1, number[faces]), axis=-1).reshape(-1, 6)
        file.writelines("f {}/{} {}/{} {}/{}\n".format(*row) for row in corners.tolist())


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[str]:
    """A temporary file beside `path` that takes its place when the block succeeds.

    Parameters
    ----------
    path : path of the file to write

    Yields
    ------
    str
        Path of the temporary file, with the same suffix.

    Raises
    ------
    OSError
        The folder is not there, or may not be written to, or the disk is full; it names `path`.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "notes.txt")
    >>> with replacing(path) as temporary, open(temporary, "w") as file:
    ...     print("whole or not at all", file=file)
    >>> os.listdir(os.path.dirname(path))
    ['notes.txt']
    """
    path = Path(path)
    temporary = path.with_name(f".igl_linabf-{secrets.token_hex(8)}{path.suffix}")
    remove = partial(temporary.unlink, missing_ok=True)
    with undone_at_once(remove):
        try:
            # not tempfile's, whose mode only the umask of the whole process, threads and all, would tell
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            yield str(temporary)
            os.replace(temporary, path)
        except BaseException as error:
            remove()
            if isinstance(error, OSError) and error.errno and error.filename in (None, str(temporary)):
                raise OSError(error.errno, error.strerror, str(path)) from None
            raise
