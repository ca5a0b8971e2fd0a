"""Write OBJ files, with the interface of `xatlas.export` in xatlas-python."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import replacing
from .arrays import check_shape


def export(
    path: str | os.PathLike[str],
    positions: ArrayLike,
    indices: ArrayLike | None = None,
    uvs: ArrayLike | None = None,
    normals: ArrayLike | None = None,
) -> None:
    """Write an OBJ file whose faces have one index for position, texture coordinates and normal.

    Parameters
    ----------
    path : path of the OBJ file
    positions : (#V, 3) float
    indices : (#F, 3) int, optional
    uvs : (#V, 2) float, optional
    normals : (#V, 3) float, optional

    Raises
    ------
    ValueError
        A shape is wrong.
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import igl, os, tempfile
    >>> from igl_linabf.xatlas import parametrize
    >>> V, F = igl.icosahedron()
    >>> vmapping, indices, uvs = parametrize(V, F)
    >>> path = os.path.join(tempfile.mkdtemp(), "textured.obj")
    >>> export(path, V[vmapping], indices, uvs)
    >>> igl.readOBJ(path)[3].shape
    (20, 3)
    """
    n = check_shape("positions", positions, 3)
    tables = [("v", positions)]
    for keyword, name, array, columns in (("vt", "uvs", uvs, 2), ("vn", "normals", normals, 3)):
        if array is not None:
            check_shape(name, array, columns, n)
            tables.append((keyword, array))
    form = {("v",): "{0}", ("v", "vt"): "{0}/{0}", ("v", "vn"): "{0}//{0}"}.get(
        tuple(keyword for keyword, _ in tables), "{0}/{0}/{0}"
    )
    if indices is not None:
        check_shape("indices", indices, 3)
    with replacing(path) as temporary, open(temporary, "w", encoding="utf-8", newline="\n") as file:
        for keyword, rows in tables:
            file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in np.asarray(rows).tolist())
        if indices is not None:
            corners = (np.asarray(indices).astype(np.int64) + 1).tolist()
            file.writelines(f"f {' '.join(map(form.format, face))}\n" for face in corners)
