"""The cost of an atlas as it is: measured stretch, true seams, true fill."""

import numpy as np

from .._core import dihedrals
from .._types import FloatArray, IntArray
from ..flattening import Isometric, Method
from ..surface import Submesh
from .atlas import Atlas, AtlasCost, page_cost, rows_of_texture_seams
from .cut_graphs import ISOMETRIC_STRETCH_WEIGHT, seam_lengths
from .features import CreasedSurface, face_normals
from .options import ChartOptions


def cost_of(surface: Submesh, atlas: Atlas, options: ChartOptions) -> AtlasCost:
    """What an atlas of these triangles costs by the options of its charts."""
    double_area = surface.measured[0]
    own = np.bincount(atlas.chart, double_area, len(atlas.charts))
    stretch = max(own @ [chart.quality.stretch_l2 - 1 for chart in atlas.charts] / own.sum(), 0.0)
    creased = CreasedSurface(surface, options.hidden)
    rows, length = priced_seams(creased, atlas.FTC)
    area = creased.double_area / 2
    size = np.sqrt(area[creased.label[creased.faces[rows, 0]]])  # of its component, which counts by its area
    seams = options.worth(float(length @ size / area.sum())) if len(rows) else 0.0
    return AtlasCost(stretch_weight(options.method) * float(stretch), seams, page_cost(atlas.fill))


def stretch_weight(method: Method) -> float:
    """What the L2 stretch of its maps beyond 1 is multiplied by."""
    return ISOMETRIC_STRETCH_WEIGHT if isinstance(method, Isometric) else 1.0


def priced_seams(creased: CreasedSurface, texture: IntArray) -> tuple[IntArray, FloatArray]:
    """The seams of texture coordinates, (#F, 3): rows of the edges inside, and lengths times prices."""
    surface, topology = creased.surface, creased.surface.topology
    edges = rows_of_texture_seams(topology, texture)
    rows = np.searchsorted(topology.inside, edges)
    normals = face_normals(surface, creased.extent[creased.label])
    bend = dihedrals(surface.V, topology.corner, np.ascontiguousarray(topology.sides[:, edges]), normals)
    return rows, seam_lengths(creased.visible_length[rows], bend)
