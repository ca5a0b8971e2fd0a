"""From target angles to a flat map.

In: a disk's topology and target angles. Out: complex positions of its vertices.
Zayer, Levy, Seidel 2007, section 5; Tutte 1963 and Floater 2003 (embeddings); Rabinovich et al. 2017 (SLIM);
Degener, Meseth, Klein 2003 and Smith, De Goes, Kim 2019 (the isometric energy and its convex part).
"""

from .boundary import Boundary, develop_boundary, harmonic
from .choice import Layout, LayoutName, LayoutOptions, check_method, check_pins, lay_out, layout, place_map
from .conformal_energy import far_apart, least_squares
from .constants import FLAT_RESIDUAL, GAP, LARGEST_HOLE_GAP
from .convex import on_circle
from .greedy import greedy
from .isometry import (
    InjectiveMap,
    IsometricMap,
    at_pins,
    embedded_inside,
    injective,
    isometric,
    isometric_together,
)
