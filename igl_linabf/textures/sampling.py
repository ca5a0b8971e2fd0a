"""Look up values of images at texture coordinates."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from .._types import FloatArray, IntArray
from ..charts import UDIM_ROW

Wrap = Literal["repeat", "clamp", "mirror"]


@dataclass(frozen=True, eq=False)
class Picture:
    """An image, and how it continues beyond its borders.

    Attributes
    ----------
    pixels : (#rows, #columns, k) float64
        The first row is the upper one.
    wrap : (Wrap, Wrap)
        Continuation in u and in v.
    matrix : ((3,), (3,)) of float
        Affine map from texture coordinates (u, v, 1), with v pointing up, to image coordinates.
    nearest : bool
        Whether a lookup returns the nearest pixel instead of interpolating, for example for pixel art.
    tiles : mapping of int to (#rows, #columns, k) float64
        Pixels of each UDIM tile by page, if the image consists of tiles. `pixels` is then one of the tiles.
    """

    pixels: FloatArray
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    matrix: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    nearest: bool = False
    tiles: Mapping[int, FloatArray] = field(default_factory=dict)

    def select_tile(self, page: int) -> "Picture":
        """Return the UDIM tile of a page, at its position, repeating its border pixels outside the tile."""
        column, row = page % UDIM_ROW, page // UDIM_ROW
        (a, b, x), (c, d, y) = self.matrix
        matrix = ((a, b, x - column), (c, d, y - row))
        return replace(self, pixels=self.tiles[page], wrap=("clamp", "clamp"), matrix=matrix, tiles={})

    def find_pages(self, uv: FloatArray) -> IntArray:
        """Return the page of texture coordinates (n, 2), (n,); -1 outside the ten columns of UDIM tiles."""
        column, row = np.floor(self._map_to_image(uv))
        inside = (column >= 0) & (column < UDIM_ROW) & (row >= 0)
        return np.where(inside, column + UDIM_ROW * row, -1).astype(np.int64)

    def _map_to_image(self, uv: FloatArray) -> FloatArray:
        """Return the coordinates in the image, (2, n), of texture coordinates (n, 2)."""
        return np.asarray(np.array(self.matrix) @ np.vstack((uv.T, np.ones(len(uv)))))

    def interpolate(self, uv: FloatArray) -> FloatArray:
        """Return values (n, k) at texture coordinates (n, 2), with v pointing up, by bilinear interpolation.

        With the attribute `nearest`, return the values of the nearest pixels instead.
        """
        rows, columns = self.pixels.shape[:2]
        u, v = self._map_to_image(uv)
        x, y = u * columns - 0.5, (1 - v) * rows - 0.5
        if self.nearest:
            i = _wrap_indices(np.floor(y + 0.5), rows, self.wrap[1])
            return self.pixels[i, _wrap_indices(np.floor(x + 0.5), columns, self.wrap[0])]
        left, upper = np.floor(x), np.floor(y)
        across, down = (x - left)[:, None], (y - upper)[:, None]
        i, j = (_wrap_indices(upper + k, rows, self.wrap[1]) for k in (0, 1))
        a, b = (_wrap_indices(left + k, columns, self.wrap[0]) for k in (0, 1))
        above = (1 - across) * self.pixels[i, a] + across * self.pixels[i, b]
        below = (1 - across) * self.pixels[j, a] + across * self.pixels[j, b]
        return np.asarray((1 - down) * above + down * below)


def _wrap_indices(index: FloatArray, n: int, wrap: Wrap) -> IntArray:
    """Map pixel indices outside an image of `n` rows or columns to indices inside it."""
    if wrap == "clamp":
        index = np.clip(index, 0, n - 1)
    if wrap == "mirror":
        back = np.mod(index, 2 * n)
        index = np.minimum(back, 2 * n - 1 - back)
    return np.asarray(np.mod(index, n), dtype=np.int64)
