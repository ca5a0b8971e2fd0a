"""Old images looked up at texture coordinates, as renderers do it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from .._types import FloatArray, IntArray

Wrap = Literal["repeat", "clamp", "mirror"]


@dataclass(frozen=True, eq=False)
class Picture:
    """An image, and how it goes on beyond its borders.

    Attributes
    ----------
    pixels : (#rows, #columns, k) float64
        The upper row first.
    wrap : (Wrap, Wrap)
        In u and in v.
    """

    pixels: FloatArray
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")

    def at(self, uv: FloatArray) -> FloatArray:
        """Bilinear lookups at texture coordinates (n, 2), v upwards: (n, k)."""
        rows, columns = self.pixels.shape[:2]
        x, y = uv[:, 0] * columns - 0.5, (1 - uv[:, 1]) * rows - 0.5
        left, upper = np.floor(x), np.floor(y)
        across, down = (x - left)[:, None], (y - upper)[:, None]
        i, j = (_inside(upper + k, rows, self.wrap[1]) for k in (0, 1))
        a, b = (_inside(left + k, columns, self.wrap[0]) for k in (0, 1))
        above = (1 - across) * self.pixels[i, a] + across * self.pixels[i, b]
        below = (1 - across) * self.pixels[j, a] + across * self.pixels[j, b]
        return np.asarray((1 - down) * above + down * below)


def _inside(index: FloatArray, n: int, wrap: Wrap) -> IntArray:
    """Indices of pixels, brought into the image."""
    if wrap == "clamp":
        return np.clip(index, 0, n - 1).astype(np.int64)
    if wrap == "mirror":
        back = np.mod(index, 2 * n)
        return np.minimum(back, 2 * n - 1 - back).astype(np.int64)
    return np.mod(index, n).astype(np.int64)
