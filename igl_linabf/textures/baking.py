"""Bake values on a surface into the images of its atlas."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..charts import UDIM_ROW, Atlas
from ..errors import MeshError, is_number
from ..surface import vertex_array
from .texels import Texels, around, covered, nearest_known

Values = ArrayLike | Callable[[FloatArray], ArrayLike]


def bake(
    V: ArrayLike,
    F: Any,
    atlas: Atlas,
    values: Values,
    resolution: int,
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
    resolution : int
        Texels along a page's side.
    padding : int
        Texels by which charts grow further into what is free around them, for coarser mip levels.
    background : float
        Value of all other texels.

    Returns
    -------
    image : (resolution, resolution) or (resolution, resolution, k) float64
        The first row is the upper one, v = 1 - 1 / (2 resolution), as in image files. Of an atlas with
        several pages (#pages, resolution, resolution[, k]).

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
    if not is_number(resolution, 1, whole=True):
        raise ValueError(f"resolution is {resolution!r}: give the texels along the image's side, like 1024")
    if not is_number(padding, 0, whole=True):
        raise ValueError(f"padding is {padding!r}: give the texels around charts that are filled, from 0 on")
    resolution, padding = int(resolution), int(padding)
    positions = vertex_array(V)
    if len(atlas.origin) and int(atlas.origin.max()) >= len(positions):
        raise MeshError(
            f"the atlas has more vertices than the {len(positions)} of V: pass what was unwrapped"
        )
    triangles, chart = atlas.triangles, atlas.chart
    if atlas.split is not None:
        chart = chart[atlas.split.face]
    at_corners, function = _corner_values(values, positions, atlas, triangles)
    used = chart >= 0
    page = np.zeros(len(triangles), dtype=np.int64)
    page[used] = atlas.page[chart[used]]
    images = []
    for k in range(atlas.pages):
        mine = np.flatnonzero(page == k)
        uv = atlas.TC[triangles[mine]] - [k % UDIM_ROW, k // UDIM_ROW]
        shown = _shown(uv * resolution - 0.5, triangles[mine], resolution)
        made = shown.values(at_corners[mine])
        if function is not None:
            made = _called(function, made)
        images.append(_image(shown.index, made, resolution, padding, background))
    image = images[0] if len(images) == 1 else np.stack(images)
    # one value a texel, and not a row of one
    alone = image.shape[-1] == 1 if callable(values) else np.ndim(values) == 1
    return image[..., 0] if alone else image


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


def _shown(triangles: FloatArray, F: IntArray, resolution: int) -> Texels:
    """The texels of a page that show the surface: their centres do, or a lookup asks for them."""
    inner = covered(triangles, resolution)
    tail, head = F, F[:, [1, 2, 0]]
    n = int(F.max(initial=0)) + 1
    open_ = ~np.isin(tail * n + head, head * n + tail, kind="sort")
    face, k = np.nonzero(open_)
    outer = around(triangles, (face, k), resolution)
    free = np.ones(resolution * resolution, dtype=bool)
    free[inner.index] = False
    more = free[outer.index]
    return Texels(
        np.concatenate((inner.index, outer.index[more])),
        np.concatenate((inner.face, outer.face[more])),
        np.concatenate((inner.weights, outer.weights[more])),
    )


def _image(
    index: IntArray, values: FloatArray, resolution: int, padding: int, background: float
) -> FloatArray:
    image = np.full((resolution * resolution, values.shape[1]), float(background))
    image[index] = values
    grown, source = nearest_known(index, resolution, padding)
    image[grown] = image[source]
    return image.reshape(resolution, resolution, -1)[::-1]
