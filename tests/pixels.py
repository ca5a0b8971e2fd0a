"""Analysis of pictures by their pixels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista as pv
from conftest import read_pixels

from igl_linabf.plot import DARK, LIGHT


def find_colour(image: np.ndarray, colour: str, tolerance: int = 10) -> np.ndarray:
    """Return a mask of the pixels that have a given colour."""
    return (np.abs(image[..., :3].astype(int) - pv.Color(colour).int_rgb) <= tolerance).all(axis=-1)


def count_square_changes(image: np.ndarray) -> int:
    """Count the changes between light and dark squares of a checkerboard along the middle row."""
    row = image[len(image) // 2]
    seen = np.where(find_colour(row, LIGHT), 1, np.where(find_colour(row, DARK), -1, 0))
    seen = seen[seen != 0]
    return int(np.count_nonzero(np.diff(seen)))


def locate_in_colour_map(image: np.ndarray, name: str, tolerance: int = 6) -> np.ndarray:
    """Return the position of the colour of each pixel in a colour map, from 0 to 1; NaN for other colours."""
    table = pv.LookupTable(name, n_values=256).values[:, :3].astype(int)
    seen, index = np.unique(image[..., :3].reshape(-1, 3).astype(int), axis=0, return_inverse=True)
    away = np.abs(seen[:, None] - table).max(axis=-1)
    place = np.where(away.min(axis=-1) <= tolerance, away.argmin(axis=-1) / 255, np.nan)
    return place[index].reshape(image.shape[:2])


def measure_colour_share(picture: Path, rows: int, columns: int) -> list[int]:
    """Return, for each panel of a picture, the percentage of pixels that are not white."""
    image = read_pixels(picture)[..., :3].astype(int).sum(axis=2) < 720
    parts = (p for row in np.split(image, rows) for p in np.split(row, columns, axis=1))
    return [int(100 * part.mean()) for part in parts]
