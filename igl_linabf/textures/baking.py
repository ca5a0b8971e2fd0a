"""Bake values on a surface into images of its atlas."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, FloatArray, IntArray
from ..charts import UDIM_ROW, parse_page_size
from ..errors import MemoryLimitError, MeshError, format_count, is_number
from ..linalg import available_memory, format_gigabytes, has_free_memory
from .coordinates import Coordinates, MappedTriangles
from .texels import Rows, Size, Texels, find_boundary_texels, find_covered_texels, find_nearest_known_texels

STRIP_TEXELS = 1 << 20  # number of texels to paint at a time, to bound the memory
BYTES_PER_VALUE, BYTES_PER_TEXEL = 8, 2  # bytes of memory for a value of an image, and for masks of a texel

Values = ArrayLike | Callable[[FloatArray], ArrayLike]


def bake(
    V: ArrayLike,
    F: Any,
    atlas: Coordinates,
    values: Values,
    resolution: int | tuple[int, int],
    *,
    padding: int = 8,
    background: float = 0.0,
) -> FloatArray:
    """Bake values on a surface into an image of its atlas.

    Each texel gets the value at the point of the surface to which its centre corresponds. The texels around
    a chart that a bilinear lookup may use get the value at the nearest point of the chart's boundary.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
        The unwrapped faces, which may be polygons.
    atlas : Atlas, (#V, 2) float, or (TC, FTC)
        Result of `unwrap` with `Packing(resolution=resolution)`, so that the distances between charts
        suffice; or a map within the unit square; or the texture coordinates of any program, `TC` (#TC, 2)
        with their rows `FTC` at the corners, -1 at corners without coordinates. Each triangle has to lie in
        one UDIM tile. Where triangles overlap, a texel gets the value of the last triangle.
    values : (#V,), (#V, k) or (#F, 3, k) float, or callable
        Values at vertices or at corners of triangles, or a function of points (#P, 3) that returns (#P,) or
        (#P, k).
    resolution : int or (int, int)
        Texels along the side of a page, or its width and height.
    padding : int
        Width in texels of an additional border around each chart, for coarser mip levels.
    background : float
        Value of the remaining texels.

    Returns
    -------
    image : (height, width) or (height, width, k) float64
        The first row is the upper one, with v = 1 - 1 / (2 height), as in image files. The shape is
        (#pages, height, width[, k]) if the atlas has several pages.

    Raises
    ------
    MeshError
        The arrays do not match the atlas, or a triangle lies outside the unit square and all other UDIM
        tiles.
    ValueError
        The resolution is not positive.

    Examples
    --------
    Bake positions, so that each texel is a point of the surface:

    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F, packing=igl_linabf.Packing(resolution=64))
    >>> bake(V, F, atlas, V, 64).shape
    (64, 64, 3)

    Bake a function of the point:

    >>> heights = bake(V, F, atlas, lambda points: points[:, 2], 64)
    >>> bool(abs(heights).max() <= 1)
    True

    Bake for a map, or for texture coordinates of another program:

    >>> uv = igl_linabf.io.unit_square(igl_linabf.linabf(V, F[1:]))
    >>> bake(V, F[1:], uv, V, 64).shape, bake(V, F, (atlas.TC, atlas.FTC), V, 64).shape
    ((64, 64, 3), (64, 64, 3))
    """
    size = parse_page_size(resolution)
    padding = check_padding(padding)
    mapped = MappedTriangles.from_mesh(V, F, atlas)
    at_corners, function = _get_corner_values(values, mapped)
    check_image_memory(size, mapped.pages, 3 if function is not None else at_corners.shape[2])

    def values_at(shown: Texels) -> tuple[FloatArray, IntArray]:
        made = shown.interpolate(at_corners)
        return made if function is None else _call_function(function, made), shown.index

    images = [paint_page(page, size, padding, background, values_at) for page in list_pages(mapped, size)]
    image = images[0] if len(images) == 1 else np.stack(images)
    # scalar values give an image without a channel axis
    alone = image.shape[-1] == 1 if callable(values) else np.ndim(values) == 1
    return image[..., 0] if alone else image


def check_padding(padding: int) -> int:
    """Check the width of the border around charts, in texels.

    Raises
    ------
    ValueError
        The width is not a non-negative integer.
    """
    if not is_number(padding, 0, whole=True):
        raise ValueError(f"padding is {padding!r}: give a number of texels, at least 0")
    return int(padding)


def check_image_memory(size: Size, number: int, channels: int) -> None:
    """Raise a `MemoryLimitError` if `number` images of this size do not fit into memory."""
    texels = size[0] * size[1]
    wanted = BYTES_PER_VALUE * texels * channels * (number + (number > 1)) + BYTES_PER_TEXEL * texels
    if not has_free_memory(wanted):
        each = "" if number == 1 else f"{number} images of "
        raise MemoryLimitError(
            f"baking {each}{size[0]} x {size[1]} texels takes about {format_gigabytes(wanted)}, but only "
            f"{format_gigabytes(available_memory() or 0)} are free: use a smaller resolution"
        )


@dataclass(frozen=True, eq=False)
class Page:
    """The triangles on one page.

    Attributes
    ----------
    faces : (#T,) int64
        Indices of the triangles.
    triangles : (#T, 3, 2) float64
        Corners of the triangles, in texels.
    F : (#T, 3) int64
        Rows of texture coordinates at the corners.
    """

    faces: IntArray
    triangles: FloatArray
    F: IntArray


def list_pages(mapped: MappedTriangles, size: Size) -> Iterator[Page]:
    """Yield the triangles of each page."""
    for k in range(mapped.pages):
        mine = np.flatnonzero(mapped.page == k)
        rows = mapped.rows[mine]
        yield Page(mine, (mapped.TC[rows] - [k % UDIM_ROW, k // UDIM_ROW]) * size - 0.5, rows)


def paint_page(
    page: Page,
    size: Size,
    padding: int,
    background: float,
    values_at: Callable[[Texels], tuple[FloatArray, IntArray]],
) -> FloatArray:
    """Return the image of a page, (height, width, k), painted in strips to bound the memory.

    `values_at(texels)` returns the values (#P, k) and the indices of texels; `texels.face` is the index of a
    triangle. Known texels are copied into the free texels within a distance of `padding`.
    """
    width, height = size
    image, is_known = np.empty((0, 0)), np.zeros((height, width), dtype=bool)
    for shown in _iterate_bilinear_texels(page, size):
        if len(shown.index) or not image.size:
            values, index = values_at(shown)
            if not image.size:
                image = np.full((height * width, values.shape[1]), float(background))
            image[index] = values
            is_known.flat[index] = True
    _dilate_texels(image, is_known, padding)
    return image.reshape(height, width, -1)[::-1]


def _dilate_texels(image: FloatArray, is_known: BoolArray, padding: int) -> None:
    """Copy known texels of an image, (#texels, k), into the free texels around them."""
    height, width = is_known.shape
    for begin, end in _iterate_strips(height, width):
        first, last = max(begin - padding, 0), min(end + padding, height)
        grown, source = find_nearest_known_texels(is_known[first:last], padding)
        grown, source = grown + first * width, source + first * width
        inside = (grown >= begin * width) & (grown < end * width)
        image[grown[inside]] = image[source[inside]]


def _iterate_strips(height: int, width: int) -> Iterator[Rows]:
    """Yield strips of rows that cover a page."""
    step = max(STRIP_TEXELS // width, 1)
    for begin in range(0, height, step):
        yield begin, min(begin + step, height)


def _get_corner_values(
    values: Values, mapped: MappedTriangles
) -> tuple[FloatArray, Callable[[FloatArray], ArrayLike] | None]:
    """Return values at the corners of triangles, (#T, 3, k), and None; or positions and their function."""
    triangles, n = mapped.F, len(mapped.V)
    if callable(values):
        return mapped.V[triangles], values
    given = _to_numbers(values, "values are not")
    if given.ndim == 3:
        if given.shape[:2] != triangles.shape:
            raise MeshError(
                f"values are {given.shape[0]} x {given.shape[1]} corners for "
                f"{format_count(len(triangles), 'triangle')}: "
                "pass (#F, 3, k), or values at vertices"
            )
        return given, None
    if given.ndim not in (1, 2) or len(given) != n:
        raise MeshError(
            f"values have the shape {given.shape} for {format_count(n, 'vertex')}: "
            "pass (#V,), (#V, k), (#F, 3, k) or a function of the point"
        )
    return given.reshape(n, -1)[triangles], None


def _to_numbers(values: ArrayLike, what: str) -> FloatArray:
    """Convert values to an array of floats; `what` begins the error message."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise MeshError(f"{what} an array of real numbers: use rows of equal length") from None


def _call_function(function: Callable[[FloatArray], ArrayLike], points: FloatArray) -> FloatArray:
    """Call a user's function of points, and check the shape of its values."""
    made = _to_numbers(function(points), "the function does not return")
    if made.ndim not in (1, 2) or len(made) != len(points):
        raise MeshError(
            f"the function returns the shape {made.shape} for {format_count(len(points), 'point')}: "
            "return a row for each"
        )
    return made.reshape(len(made), -1)


def _iterate_bilinear_texels(page: Page, size: Size) -> Iterator[Texels]:
    """Yield, in strips, the texels whose centres are in triangles or that a bilinear lookup may use."""
    F, triangles = page.F, page.triangles
    tail, head = F, F[:, [1, 2, 0]]
    n = int(F.max(initial=0)) + 1
    open_ = ~np.isin(tail * n + head, head * n + tail, kind="sort")
    low, high = triangles[..., 1].min(axis=1, initial=np.inf), triangles[..., 1].max(axis=1, initial=-np.inf)
    for rows in _iterate_strips(size[1], size[0]):
        near = np.flatnonzero((low < rows[1] + 1) & (high > rows[0] - 2))
        inner = find_covered_texels(triangles[near], size, rows)
        face, k = np.nonzero(open_[near])
        outer = find_boundary_texels(triangles[near], (face, k), size, rows)
        free = np.ones((rows[1] - rows[0]) * size[0], dtype=bool)
        free[inner.index - rows[0] * size[0]] = False
        more = free[outer.index - rows[0] * size[0]]
        yield Texels(
            np.concatenate((inner.index, outer.index[more])),
            page.faces[near[np.concatenate((inner.face, outer.face[more]))]],
            np.concatenate((inner.weights, outer.weights[more])),
        )
