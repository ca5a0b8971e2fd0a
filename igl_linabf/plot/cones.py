"""Draw cones as spheres, and both sides of a seam in the same colour."""

from colorsys import hsv_to_rgb
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..charts import Atlas
from ..surface import connected_labels
from .constants import MARKER_RADIUS

HUE_STEP = 0.618  # hue difference of consecutive arcs, as a share of the full circle: the golden ratio
CONE_COLOUR = "#e09f1f"


@dataclass(frozen=True, eq=False)
class SeamSides:
    """The seam edges of an atlas with cones, grouped into arcs.

    Attributes
    ----------
    arc : (#E,) int64
        Arc of each seam edge. An arc runs from one cone, end or branch point to the next.
    side : (#S, 2, 2) float64
        Ends of both sides of the seam edges in the map.
    arc_of_side : (#S,) int64
    """

    arc: IntArray
    side: FloatArray
    arc_of_side: IntArray


def find_seam_sides(atlas: Atlas) -> SeamSides:
    """Return both sides of each seam edge, and their arcs."""
    seams = np.sort(atlas.seams, axis=1)
    n = int(max(atlas.origin.max(initial=0), seams.max(initial=0))) + 1
    keys, number = np.unique(seams @ [n, 1], return_inverse=True)
    arc = _number_arcs(seams, atlas.report.cones, n)
    corner = atlas.triangles
    F = atlas.origin[corner]
    ends = np.stack((corner, np.roll(corner, -1, axis=1)), axis=-1).reshape(-1, 2)
    key = np.sort(np.stack((F, np.roll(F, -1, axis=1)), axis=-1), axis=-1).reshape(-1, 2) @ [n, 1]
    at = np.minimum(np.searchsorted(keys, key), max(len(keys) - 1, 0))
    there = np.flatnonzero(keys[at] == key) if len(keys) else np.zeros(0, dtype=np.int64)
    first = np.empty(len(keys), dtype=np.int64)
    first[number] = np.arange(len(seams))
    return SeamSides(arc, atlas.flat[ends[there]], arc[first[at[there]]])


def _number_arcs(seams: IntArray, cones: IntArray, n: int) -> IntArray:
    """Return the arc of each seam edge; arcs pass through vertices with two seam edges, except cones."""
    end, edge = seams.ravel(), np.repeat(np.arange(len(seams)), 2)
    through = np.bincount(end, minlength=n) == 2
    through[cones] = False
    inner = np.flatnonzero(through[end])
    pair = edge[inner[np.argsort(end[inner], kind="stable")]].reshape(-1, 2)
    return np.unique(connected_labels(pair, len(seams)), return_inverse=True)[1]


def choose_arc_colours(arcs: IntArray) -> NDArray[np.uint8]:
    """Return the colour of each edge, (#E, 3) from 0 to 255, given the arcs of the edges."""
    each = [
        hsv_to_rgb(i * HUE_STEP % 1, 0.85, 0.65 if i % 2 else 0.9) for i in range(arcs.max(initial=0) + 1)
    ]
    return (255 * np.array(each).reshape(-1, 3)).astype(np.uint8)[arcs]


def add_cones(plotter: pv.Plotter, centres: FloatArray, diagonal: float, **options: Any) -> None:
    """Add a sphere at each cone to a plotter."""
    if len(centres):
        ball = pv.Sphere(radius=MARKER_RADIUS * diagonal, theta_resolution=16, phi_resolution=16)
        balls = pv.PolyData(centres).glyph(geom=ball, scale=False, orient=False)
        plotter.add_mesh(balls, color=CONE_COLOUR, smooth_shading=True, **options)
