"""Repair of arbitrary triangles into an oriented manifold without degenerate faces.

`clean` also reports each repair. `patch_faces` extracts the largest piece of a surface after some of its
vertices have been removed.
"""

from .cleaning import Cleaned, Repair, clean, cleaned_surface, merge_coincident, unrepaired
from .disks import RepairedDisk, repair_disk
from .patches import PatchFaces, patch_faces
