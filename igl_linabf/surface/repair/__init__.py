"""Any array of triangles as a clean surface.

In: V, F with anything in it. Out: an oriented manifold, each face with an area, and what was changed.
"""

from .cleaning import Cleaned, Repair, clean, cleaned_surface, merge_coincident, unrepaired
