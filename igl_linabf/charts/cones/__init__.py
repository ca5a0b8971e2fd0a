"""Cones: the few vertices that keep all curvature when the rest of a surface is flattened.

In: a surface. Out: cones with their angle sums, a seam through them, and the charts along it.
The conformal scale is that of Ben-Chen, Gotsman, Bunin 2008.
"""

from .cone_charts import NO_CONES, ConeCharts, charts_with_cones
from .options import Cones, GivenCones
from .placement import find_cones
from .surface_cones import SurfaceCones
