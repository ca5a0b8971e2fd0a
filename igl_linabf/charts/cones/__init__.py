"""Cones: the few vertices that keep all curvature when the rest of a surface is flattened.

In: a surface. Out: cones with their angles, a seam through them, and the charts that this makes.
The conformal scale is that of Ben-Chen, Gotsman, Bunin 2008.
"""

from .coned_charts import NO_CONES, ConeAngles, Coned, Cones, GivenCones, coned
from .finding import find_cones
