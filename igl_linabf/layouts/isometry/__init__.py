"""Maps that keep lengths as well as they can, and maps without flipped triangles.

In: a mesh and a map of it. Out: the isometric map next to it, by Newton's method; the map without flips, by
igl's SLIM from one that has some (the guarantee).
Rabinovich et al. 2017; Smith, De Goes, Kim 2019.
"""

from .maps import IsometricMap, at_pins, isometric, isometric_together
from .slim import InjectiveMap, embedded_inside, injective
