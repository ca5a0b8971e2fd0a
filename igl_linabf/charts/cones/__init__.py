"""Cones: the few vertices at which a map of the surface keeps its curvature, while it is flat elsewhere.

Input: a surface. Output: cones with their angles, a seam through them, and the resulting charts.
The conformal scale follows Ben-Chen, Gotsman, Bunin 2008.
"""

from .cone_charts import NO_CONES, ConeCharts, SurfaceCones, charts_with_cones
from .options import Cones, GivenCones
from .placement import find_cones
