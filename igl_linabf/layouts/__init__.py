"""Lay out a flat map from target angles.

Takes the topology of a disk and its target angles. Returns complex positions of the vertices. References:
Zayer, Levy, Seidel 2007, section 5; Tutte 1963 and Floater 2003 (embeddings); Rabinovich et al. 2017 (SLIM);
Degener, Meseth, Klein 2003 and Smith, De Goes, Kim 2019 (the isometric energy and its convex part).
"""

from .boundary import Boundary, compute_harmonic_map, develop_boundary
from .choice import (
    MAX_BOUNDARY_GAP,
    Layout,
    LayoutName,
    LayoutOptions,
    check_method,
    check_pins,
    lay_out,
    layout,
    place_map,
)
from .conformal_energy import find_far_points, least_squares
from .convex import embed_in_circle
from .greedy import lay_out_greedily
from .isometry import embed_in_boundary, flatten_isometrically, make_injective, make_isometric, pull_to_pins
