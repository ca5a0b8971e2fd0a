"""Images: as files, and as the texture of a mesh."""

from __future__ import annotations

import os

from numpy.typing import ArrayLike

from .._runtime import replacing
from .files import bare
from .pictures import picture
from .saving import written


def write_image(path: str | os.PathLike[str], image: ArrayLike) -> None:
    """Write an image; Pillow chooses the format by the suffix.

    Parameters
    ----------
    path : path of a PNG file, or of another format of Pillow
    image : (#rows, #columns) or (#rows, #columns, 1, 3 or 4) float
        From 0 to 1; what lies beyond is cut off, and NaN is 0. 8 bits a channel are written.

    Raises
    ------
    MeshError
        The image has another shape.
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import numpy as np, os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "ramp.png")
    >>> write_image(path, np.linspace(0, 1, 64).reshape(8, 8))
    >>> os.path.getsize(path) > 70
    True
    """
    with replacing(path) as temporary:
        picture(image).save(temporary)


def write_textured(
    path: str | os.PathLike[str],
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike,
    image: ArrayLike,
) -> None:
    """Write a surface with an image as its texture.

    GLB, glTF and 3MF hold the image. Beside OBJ it is in a PNG file of the same name, and in an MTL file
    that names it.

    Parameters
    ----------
    path : path of a GLB, glTF, OBJ or 3MF file
    V : (#V, 3) float
    F : (#F, 3) int, or polygons
    TC : (#TC, 2) float
        Texture coordinates in the unit square, v upwards.
    FTC : (#F, 3) int, or in the shape of `F`
    image : (#rows, #columns[, 1, 3 or 4]) float
        From 0 to 1, the upper row first, as `bake` returns it. Viewers take it for sRGB.

    Raises
    ------
    MeshError
        The suffix is none of these, or arrays have other shapes.
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import igl, igl_linabf, os, tempfile
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F, resolution=64)
    >>> path = os.path.join(tempfile.mkdtemp(), "ball.glb")
    >>> write_textured(path, V, F, atlas.TC, atlas.FTC, igl_linabf.bake(V, F, atlas, V / 2 + 0.5, 64))
    >>> os.path.getsize(path) > 1000
    True
    """
    with written(path, bare(V, F), TC, FTC, image):
        pass
