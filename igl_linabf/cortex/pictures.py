"""Draw pictures of flat cortices, which show the folds and the change of area."""

from __future__ import annotations

from typing import Any

import igl
import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray
from ..measures import distortion
from ..surface import Submesh, sum_by_index
from ..textures import find_covered_texels
from .flat_hemispheres import FlatHemisphere

PANEL_WIDTH = 900  # side length of a square panel, pixels
MAX_LOG_AREA_RATIO = 0.7  # log of the area ratio at the ends of the colour scale: a factor of two
SMOOTHING_LENGTH = 2.0  # millimetres over which the drawn curvature is smoothed

SHRUNK_COLOUR, UNCHANGED_COLOUR, ENLARGED_COLOUR = (0.15, 0.35, 0.75), (0.95, 0.95, 0.95), (0.75, 0.2, 0.15)
GYRUS_GREY, SULCUS_GREY = 0.75, 0.35  # grey levels of gyri and sulci


def compute_log_area_ratios(flat: FlatHemisphere) -> FloatArray:
    """Return log(area in the map / area of the surface) around each vertex, (#V,); NaN outside the map."""
    V, F = flat.hemisphere.V, flat.F
    surface = Submesh.from_input(V, F)
    of_faces = np.nan_to_num(
        distortion(surface.V, surface.F, flat.uv[surface.vertices], "area"), neginf=-20.0
    )
    n = len(V)
    around = sum_by_index(F.ravel(), np.ones(F.size), n)
    with np.errstate(invalid="ignore"):
        return np.asarray(sum_by_index(F.ravel(), np.repeat(of_faces, 3), n) / around)


def compute_mean_curvatures(V: FloatArray, F: IntArray) -> FloatArray:
    """Return the smoothed mean curvature at each vertex, in 1/mm. The curvature of sulci is negative."""
    n, normals = len(V), igl.per_vertex_normals(V, F)
    area = igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    with np.errstate(invalid="ignore", divide="ignore"):
        curvature = np.nan_to_num(-((igl.cotmatrix(V, F) @ V) * normals).sum(axis=1) / area / 2)
    edges = igl.edges(F)
    length = float(np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1).mean())
    ends = np.concatenate((edges, edges[:, ::-1]))
    neighbours = sparse.csr_array((np.ones(len(ends)), ends.T), shape=(n, n)) + sparse.eye_array(n)
    number = neighbours.sum(axis=1)
    for _ in range(1 + round((SMOOTHING_LENGTH / length) ** 2)):
        curvature = neighbours @ curvature / number
    return np.asarray(curvature)


def draw_flat_hemisphere(flat: FlatHemisphere, change: FloatArray) -> Any:
    """Draw a Pillow image with two panels: the folds, and where the map shrinks or enlarges areas.

    `change` is the result of `compute_log_area_ratios`, with 0 outside the map.
    """
    from PIL import Image, ImageDraw

    folds = compute_mean_curvatures(flat.hemisphere.V, flat.hemisphere.F)
    pixel, values = _interpolate_at_pixels(flat, np.column_stack((folds, change / MAX_LOG_AREA_RATIO)))
    panels = np.ones((PANEL_WIDTH, 2, PANEL_WIDTH, 3))
    row, column = np.divmod(pixel, PANEL_WIDTH)
    panels[row, 0, column] = np.where(values[:, :1] < 0, SULCUS_GREY, GYRUS_GREY)
    shown = np.clip(np.abs(values[:, 1:]), 0, 1)
    colour = np.where(values[:, 1:] < 0, SHRUNK_COLOUR, ENLARGED_COLOUR)
    panels[row, 1, column] = (1 - shown) * UNCHANGED_COLOUR + shown * colour
    pixels = np.rint(255 * panels[::-1]).astype(np.uint8)
    image = Image.fromarray(pixels.reshape(PANEL_WIDTH, 2 * PANEL_WIDTH, 3))
    pen = ImageDraw.Draw(image)
    measured, factor = flat.quality, np.exp(MAX_LOG_AREA_RATIO)
    texts = (
        f"{flat.hemisphere.subject.name}  {flat.hemisphere.name}\nsulci dark, gyri light",
        f"area: blue shrunk to 1/{factor:.2g}, red enlarged {factor:.2g} times\n"
        f"distance error {100 * measured.distance_error:.1f} %, {measured.flips} flipped"
        if measured.distance_error is not None
        else "area",
    )
    for k, text in enumerate(texts):
        pen.multiline_text((PANEL_WIDTH * k + 12, 8), text, fill=(0, 0, 0), font_size=18)
    return image


def _interpolate_at_pixels(flat: FlatHemisphere, values: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the indices of the panel's pixels in the map, from the lowest row, and their values."""
    uv = flat.uv[flat.F]
    low, high = uv.min(axis=(0, 1)), uv.max(axis=(0, 1))
    scale = 0.86 * PANEL_WIDTH / (high - low).max()
    triangles = (uv - (low + high) / 2) * scale + PANEL_WIDTH * np.array([0.5, 0.47])
    texels = find_covered_texels(triangles, (PANEL_WIDTH, PANEL_WIDTH))
    return texels.index, texels.interpolate(values[flat.F])
