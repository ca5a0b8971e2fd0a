"""Textures: values on a surface as images on its atlas.

In: a surface, its atlas, values at vertices or corners, or a function of the point; or images on old texture
coordinates. Out: images whose texels hold what the surface has there, and round the charts what is nearest.
"""

from .baking import bake
from .sampling import Picture as Picture
from .sampling import Wrap as Wrap
from .texels import covered, near_sides
from .transfer import bake_texture
