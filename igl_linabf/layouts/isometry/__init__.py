"""Compute isometric maps, and maps without flipped triangles.

Takes a mesh and a map of it. Returns the nearest isometric map, by Newton's method, or a map without flips
from a map with flips, by the SLIM of igl. References: Rabinovich et al. 2017; Smith, De Goes, Kim 2019.
"""

from .maps import IsometricMap, flatten_isometrically, make_isometric, pull_to_pins
from .slim import InjectiveMap, embed_in_boundary, make_injective
