"""Textures: values on a surface as images on its atlas.

In: a surface, its atlas, values at vertices or corners, or a function of the point. Out: images whose texels
hold what the surface has there, and round the charts what is nearest.
"""

from .baking import bake
from .texels import covered, near_sides
