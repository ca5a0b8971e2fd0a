"""Files: in come paths, and surfaces with their maps; out come arrays, and files that are whole or not there.

Reads OBJ, OFF, PLY and STL, and refuses what is damaged with its place; writes OBJ, PLY and GLB with texture
coordinates. One module a format; `files` has the public functions, `parsing` what the readers share.
"""

from .._runtime import replacing
from .files import READERS, WRITERS, read_mesh, read_texture, unit_square, write_grid, write_mesh, write_obj

SUFFIXES = tuple(WRITERS)
READABLE = tuple(READERS)

__all__ = [
    "READABLE",
    "SUFFIXES",
    "read_mesh",
    "read_texture",
    "replacing",
    "unit_square",
    "write_grid",
    "write_mesh",
    "write_obj",
]
