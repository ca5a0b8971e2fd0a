"""Any array of triangles as a clean surface.

In: V, F with anything in it. Out: an oriented manifold, each face with an area, and what was changed.
"""

from .cleaning import Cleaned, Repair, as_it_is, clean, cleaned_surface, in_one_place
