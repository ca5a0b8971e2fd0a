"""Bake values on a surface, or images on old texture coordinates, into images of an atlas.

Values are given at vertices or corners, or as a function of points. Texels around the charts get the nearest
value.
"""

from .baking import bake, check_image_memory
from .sampling import Picture as Picture
from .sampling import Wrap as Wrap
from .texels import Texels, find_covered_texels, find_texels_near_sides
from .transfer import bake_texture
