"""Measure the cost of an atlas from its stretch, its seams and the fill of its pages."""

import numpy as np

from .atlas import Atlas, find_seam_prices
from .cost import AtlasCost, compute_page_cost
from .cut_graphs import get_stretch_weight
from .features import CreasedSurface
from .options import ChartRules


def measure_cost(creased: CreasedSurface, atlas: Atlas, rules: ChartRules) -> AtlasCost:
    """Return the cost of an atlas on the surface `creased`, whose charts were made by `rules`."""
    own = np.bincount(atlas.chart, creased.surface.areas_and_products[0], len(atlas.charts))
    stretch = max(own @ [chart.quality.stretch_l2 - 1 for chart in atlas.charts] / own.sum(), 0.0)
    rows, price = find_seam_prices(creased, atlas.FTC)
    area = creased.component_double_area / 2
    size = np.sqrt(
        area[creased.component_of_face[creased.faces_of_edges[rows, 0]]]
    )  # size of the component of each seam edge
    seams = rules.get_required_gain(float(price @ size / area.sum())) if len(rows) else 0.0
    return AtlasCost(get_stretch_weight(rules.method) * float(stretch), seams, compute_page_cost(atlas.fill))
