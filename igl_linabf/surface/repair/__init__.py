"""Any array of triangles as a clean surface.

In: V, F with anything in it. Out: an oriented manifold, each face with an area, and what was changed.
`patches` has what remains of a surface where some of its vertices stay.
"""

from .cleaning import Cleaned, Repair, clean, cleaned_surface, merge_coincident, unrepaired
from .patches import PatchFaces, patch_faces
