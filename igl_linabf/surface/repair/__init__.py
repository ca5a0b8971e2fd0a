"""Repair arbitrary triangles into an oriented manifold without degenerate faces.

`clean` also reports each repair. `find_patch_faces` extracts the largest piece of a surface after some of its
vertices have been removed, and `split_chords` splits edges between boundary vertices.
"""

from .chords import find_chords, split_chords
from .cleaning import (
    Cleaned,
    Repair,
    clean,
    clean_surface,
    mark_coincident_edges,
    merge_coincident,
    wrap_sound_surface,
)
from .disks import RepairedDisk, repair_disk
from .patches import PatchFaces, find_patch_faces
from .sheets import orient_faces
