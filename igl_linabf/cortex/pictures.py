"""Pictures of flat cortices: the folds, and what has become of areas."""

from __future__ import annotations

from typing import Any

import igl
import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray
from ..measures import distortion
from ..surface import Submesh, sum_by
from ..textures import covered
from .constants import LARGEST_LOG_AREA, PANEL_PIXELS, SMOOTHING
from .flat_hemispheres import FlatHemisphere

SHRUNK, LEVEL, GROWN = (0.15, 0.35, 0.75), (0.95, 0.95, 0.95), (0.75, 0.2, 0.15)  # colours of areas
GYRUS, SULCUS = 0.75, 0.35  # greys


def area_changes(flat: FlatHemisphere) -> FloatArray:
    """log(area in the map / area of the surface) around each vertex, (#V,); NaN where there is no map."""
    V, F = flat.hemisphere.V, flat.F
    surface = Submesh.checked(V, F)
    of_faces = np.nan_to_num(
        distortion(surface.V, surface.F, flat.uv[surface.vertices], "area"), neginf=-20.0
    )
    n = len(V)
    around = sum_by(F.ravel(), np.ones(F.size), n)
    with np.errstate(invalid="ignore"):
        return np.asarray(sum_by(F.ravel(), np.repeat(of_faces, 3), n) / around)


def mean_curvatures(V: FloatArray, F: IntArray) -> FloatArray:
    """The mean curvature at each vertex, smoothed over some millimetres; negative in sulci, 1/mm."""
    n, normals = len(V), igl.per_vertex_normals(V, F)
    area = igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    with np.errstate(invalid="ignore", divide="ignore"):
        curvature = np.nan_to_num(-((igl.cotmatrix(V, F) @ V) * normals).sum(axis=1) / area / 2)
    edges = igl.edges(F)
    length = float(np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1).mean())
    ends = np.concatenate((edges, edges[:, ::-1]))
    neighbours = sparse.csr_array((np.ones(len(ends)), ends.T), shape=(n, n)) + sparse.eye_array(n)
    number = neighbours.sum(axis=1)
    for _ in range(1 + round((SMOOTHING / length) ** 2)):
        curvature = neighbours @ curvature / number
    return np.asarray(curvature)


def draw(flat: FlatHemisphere, change: FloatArray) -> Any:
    """Pillow's image of two panels: sulci dark, and areas that the map shrinks blue and enlarges red.

    `change` is that of `area_changes`, 0 where there is no map.
    """
    from PIL import Image, ImageDraw

    folds = mean_curvatures(flat.hemisphere.V, flat.hemisphere.F)
    pixel, values = _on_map(flat, np.column_stack((folds, change / LARGEST_LOG_AREA)))
    panels = np.ones((PANEL_PIXELS, 2, PANEL_PIXELS, 3))
    row, column = np.divmod(pixel, PANEL_PIXELS)
    panels[row, 0, column] = np.where(values[:, :1] < 0, SULCUS, GYRUS)
    shown = np.clip(np.abs(values[:, 1:]), 0, 1)
    panels[row, 1, column] = (1 - shown) * LEVEL + shown * np.where(values[:, 1:] < 0, SHRUNK, GROWN)
    pixels = np.rint(255 * panels[::-1]).astype(np.uint8)
    image = Image.fromarray(pixels.reshape(PANEL_PIXELS, 2 * PANEL_PIXELS, 3))
    pen = ImageDraw.Draw(image)
    measured, factor = flat.quality, np.exp(LARGEST_LOG_AREA)
    texts = (
        f"{flat.hemisphere.subject.name}  {flat.hemisphere.name}\nsulci dark, gyri light",
        f"area: blue shrunk to 1/{factor:.2g}, red enlarged {factor:.2g} times\n"
        f"distance error {100 * measured.distance_error:.1f} %, {measured.flips} flipped"
        if measured.distance_error is not None
        else "area",
    )
    for k, text in enumerate(texts):
        pen.multiline_text((PANEL_PIXELS * k + 12, 8), text, fill=(0, 0, 0), font_size=18)
    return image


def _on_map(flat: FlatHemisphere, values: FloatArray) -> tuple[IntArray, FloatArray]:
    """The pixels of a panel that the map covers, from the lowest row, and values of the vertices there."""
    uv = flat.uv[flat.F]
    low, high = uv.min(axis=(0, 1)), uv.max(axis=(0, 1))
    scale = 0.86 * PANEL_PIXELS / (high - low).max()
    triangles = (uv - (low + high) / 2) * scale + PANEL_PIXELS * np.array([0.5, 0.47])
    texels = covered(triangles, (PANEL_PIXELS, PANEL_PIXELS))
    return texels.index, texels.values(values[flat.F])
