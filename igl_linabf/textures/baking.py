"""Bake values on a surface into the images of its atlas."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..charts import UDIM_ROW, Atlas, page_size
from ..errors import MeshError, is_number
from ..surface import vertex_array
from .texels import Size, Texels, around, covered, nearest_known

Values = ArrayLike | Callable[[FloatArray], ArrayLike]


def bake(
    V: ArrayLike,
    F: Any,
    atlas: Atlas,
    values: Values,
    resolution: int | tuple[int, int],
    *,
    padding: int = 8,
    background: float = 0.0,
) -> FloatArray:
    """Values on a surface as an image on its atlas.

    Each texel holds the value at the point of the surface that its centre shows. The texels around a chart
    that a bilinear lookup may ask for hold the value at the nearest point of its boundary.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
        The faces that were unwrapped; polygons, too.
    atlas : Atlas
        As `unwrap` returns it with `Packing(resolution=resolution)`. Charts are then far enough apart.
    values : (#V,), (#V, k) or (#F, 3, k) float, or callable
        At vertices; at the corners of triangles; or a function of points (#P, 3) that returns (#P,) or
        (#P, k).
    resolution : int or (int, int)
        Texels along a page's side, or its width and height.
    padding : int
        Texels by which charts grow further into what is free around them, for coarser mip levels.
    background : float
        Value of all other texels.

    Returns
    -------
    image : (height, width) or (height, width, k) float64
        The first row is the upper one, v = 1 - 1 / (2 height), as in image files. Of an atlas with
        several pages (#pages, height, width[, k]).

    Raises
    ------
    MeshError
        The arrays do not fit the atlas.
    ValueError
        The resolution is not positive.

    Examples
    --------
    Positions, whose texels are points of the surface:

    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F, packing=igl_linabf.Packing(resolution=64))
    >>> bake(V, F, atlas, V, 64).shape
    (64, 64, 3)

    A function of the point:

    >>> heights = bake(V, F, atlas, lambda points: points[:, 2], 64)
    >>> bool(abs(heights).max() <= 1)
    True
    """
    size = page_size(resolution)
    padding = checked_padding(padding)
    positions = vertices_of(V, atlas)
    triangles = atlas.triangles
    at_corners, function = _corner_values(values, positions, atlas, triangles)
    images = []
    for mine, shown in shown_texels(atlas, size):
        made = shown.values(at_corners[mine])
        if function is not None:
            made = _called(function, made)
        images.append(filled_image(shown.index, made, size, padding, background))
    image = images[0] if len(images) == 1 else np.stack(images)
    # one value a texel, and not a row of one
    alone = image.shape[-1] == 1 if callable(values) else np.ndim(values) == 1
    return image[..., 0] if alone else image


def checked_padding(padding: int) -> int:
    """The texels around charts that are filled.

    Raises
    ------
    ValueError
        They are no whole number from 0 on.
    """
    if not is_number(padding, 0, whole=True):
        raise ValueError(f"padding is {padding!r}: give the texels around charts that are filled, from 0 on")
    return int(padding)


def vertices_of(V: ArrayLike, atlas: Atlas) -> FloatArray:
    """The vertices as an array.

    Raises
    ------
    MeshError
        The atlas has more of them.
    """
    positions = vertex_array(V)
    if len(atlas.origin) and int(atlas.origin.max()) >= len(positions):
        raise MeshError(
            f"the atlas has more vertices than the {len(positions)} of V: pass what was unwrapped"
        )
    return positions


def shown_texels(atlas: Atlas, size: Size) -> Iterator[tuple[IntArray, Texels]]:
    """Of each page the triangles that lie on it, and the texels that show them; faces are among these."""
    triangles, chart = atlas.triangles, atlas.chart
    if atlas.split is not None:
        chart = chart[atlas.split.face]
    used = chart >= 0
    page = np.zeros(len(triangles), dtype=np.int64)
    page[used] = atlas.page[chart[used]]
    for k in range(atlas.pages):
        mine = np.flatnonzero(page == k)
        uv = atlas.TC[triangles[mine]] - [k % UDIM_ROW, k // UDIM_ROW]
        yield mine, _shown(uv * size - 0.5, triangles[mine], size)


def _corner_values(
    values: Values, positions: FloatArray, atlas: Atlas, triangles: IntArray
) -> tuple[FloatArray, Callable[[FloatArray], ArrayLike] | None]:
    """Values (#T, 3, k) at the corners of the triangles; positions, for a function of the point."""
    if callable(values):
        return positions[atlas.origin[triangles]], values
    given = _numbers(values, "values are")
    if given.ndim == 3:
        if given.shape[:2] != triangles.shape:
            raise MeshError(
                f"values are {given.shape[0]} x {given.shape[1]} corners for {len(triangles)} triangles: "
                "pass (#F, 3, k), or values at vertices"
            )
        return given, None
    if given.ndim not in (1, 2) or len(given) != len(positions):
        raise MeshError(
            f"values have the shape {given.shape} for {len(positions)} vertices: "
            "pass (#V,), (#V, k), (#F, 3, k) or a function of the point"
        )
    return given.reshape(len(given), -1)[atlas.origin[triangles]], None


def _numbers(values: ArrayLike, what: str) -> FloatArray:
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise MeshError(f"{what} no array of real numbers: pass as many in each row") from None


def _called(function: Callable[[FloatArray], ArrayLike], points: FloatArray) -> FloatArray:
    made = _numbers(function(points), "the function returns")
    if made.ndim not in (1, 2) or len(made) != len(points):
        raise MeshError(f"the function returns {made.shape} for {len(points)} points: return a row for each")
    return made.reshape(len(made), -1)


def _shown(triangles: FloatArray, F: IntArray, size: Size) -> Texels:
    """The texels of a page that show the surface: their centres do, or a lookup asks for them."""
    inner = covered(triangles, size)
    tail, head = F, F[:, [1, 2, 0]]
    n = int(F.max(initial=0)) + 1
    open_ = ~np.isin(tail * n + head, head * n + tail, kind="sort")
    face, k = np.nonzero(open_)
    outer = around(triangles, (face, k), size)
    free = np.ones(size[0] * size[1], dtype=bool)
    free[inner.index] = False
    more = free[outer.index]
    return Texels(
        np.concatenate((inner.index, outer.index[more])),
        np.concatenate((inner.face, outer.face[more])),
        np.concatenate((inner.weights, outer.weights[more])),
    )


def filled_image(
    index: IntArray, values: FloatArray, size: Size, padding: int, background: float
) -> FloatArray:
    """The image (height, width, k) of values at some texels, which grow into what is free around them."""
    image = np.full((size[0] * size[1], values.shape[1]), float(background))
    image[index] = values
    grown, source = nearest_known(index, size, padding)
    image[grown] = image[source]
    return image.reshape(size[1], size[0], -1)[::-1]
