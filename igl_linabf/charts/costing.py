"""The cost of an atlas as it is: measured stretch, true seams, true fill."""

import numpy as np

from .._core import dihedrals
from ..flattening import Isometric
from ..surface import Submesh
from .atlas import Atlas, AtlasCost, page_cost, rows_of_texture_seams
from .cut_graphs import ISOMETRIC_STRETCH_WEIGHT, seam_lengths
from .features import CreasedSurface, face_normals
from .options import ChartOptions


def cost_of(surface: Submesh, atlas: Atlas, options: ChartOptions) -> AtlasCost:
    """What an atlas of these triangles costs by the options of its charts."""
    double_area = surface.measured[0]
    own = np.bincount(atlas.chart, double_area, len(atlas.charts))
    stretch = own @ [chart.quality.stretch_l2 - 1 for chart in atlas.charts] / own.sum()
    if isinstance(options.method, Isometric):
        stretch *= ISOMETRIC_STRETCH_WEIGHT
    seams = _seam_length(surface, atlas, options)
    if seams:
        seams = seams / options.trade if options.trade else np.inf
    return AtlasCost(float(stretch), float(seams), page_cost(atlas.fill))


def _seam_length(surface: Submesh, atlas: Atlas, options: ChartOptions) -> float:
    """The length of the seams times their price, in square roots of the area of their component.

    Each component counts by its share of the area.
    """
    topology, creased = surface.topology, CreasedSurface(surface, options.hidden)
    edges = rows_of_texture_seams(topology, atlas.FTC)
    rows = np.searchsorted(topology.inside, edges)
    normals = face_normals(surface, creased.extent[creased.label])
    bend = dihedrals(surface.V, topology.corner, np.ascontiguousarray(topology.sides[:, edges]), normals)
    length = seam_lengths(creased.visible_length[rows], bend)
    area = creased.double_area / 2
    size = np.sqrt(area[creased.label[creased.faces[rows, 0]]])
    return float(length @ size / area.sum())
