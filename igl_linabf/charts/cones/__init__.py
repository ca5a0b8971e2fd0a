"""Place cones, the few vertices that keep all curvature of a surface when the rest is flattened.

Takes a surface. Returns cones with their angles, a seam through the cones, and the resulting charts.
The conformal scale follows Ben-Chen, Gotsman, Bunin 2008.
"""

from .cone_charts import NO_CONES, ConeCharts, SurfaceCones, make_charts_with_cones
from .options import Cones, GivenCones
from .placement import find_cones
