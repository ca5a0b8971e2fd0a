"""From target angles to a flat map.

In: a disk's topology and target angles. Out: complex positions of its vertices.
Zayer, Levy, Seidel 2007, section 5; Tutte 1963 and Floater 2003 (embeddings); Rabinovich et al. 2017 (SLIM).
"""

from .boundary import develop_boundaries, develop_boundary
from .choice import GAP, Layout, LayoutName, check_method, lay_out, layout, placed
from .conformal_energy import far_apart, least_squares
from .convex import on_circle
from .greedily import greedy
from .separately import flat_disks
from .slim import Injective, injective
