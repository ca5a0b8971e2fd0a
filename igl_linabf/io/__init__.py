"""Read mesh files with all their contents, and write them with new texture coordinates.

Errors name the damaged line of a file. An output file is written completely or not at all. Each format has a
module or sub-package; `files` defines the public functions and `parsing` is shared by the readers.
"""

from .._runtime import replacing
from .colours import find_largest_image as find_largest_image
from .colours import get_corner_colours as get_corner_colours
from .colours import image_maps
from .colours import is_direction_map as is_direction_map
from .colours import list_image_users as list_image_users
from .external import Patch as Patch
from .external import Segment, read_tifxyz, write_tifxyz
from .external import average_surfaces as average_surfaces
from .external import check_target as check_target
from .external import copy_polydata_arrays as copy_polydata_arrays
from .external import find_companion_surfaces as find_companion_surfaces
from .external import triangulate_strip_cells as triangulate_strip_cells
from .external import write_patch as write_patch
from .external import writing_tifxyz as writing_tifxyz
from .files import as_mesh_file as as_mesh_file
from .files import (
    read_file,
    read_mesh,
    read_texture,
    unit_square,
    write_file,
    write_grid,
    write_mesh,
    write_obj,
    write_textured,
)
from .formats import FLAT as FLAT
from .formats import READABLE_SUFFIXES, WRITERS
from .formats import WITH_IMAGES as WITH_IMAGES
from .formats import WITH_TWO_MAPS as WITH_TWO_MAPS
from .formats import check_no_file_exists as check_no_file_exists
from .formats import detect_suffix as detect_suffix
from .formats import find_object_frames as find_object_frames
from .formats import has_transformed_textures as has_transformed_textures
from .formats import is_flat_format as is_flat_format
from .formats import list_companion_files as list_companion_files
from .formats import normalize_suffix as normalize_suffix
from .formats import transform_to_object_space as transform_to_object_space
from .formats import write_atomically as write_atomically
from .materials import COLOUR as COLOUR
from .materials import MTL_KEYWORDS as MTL_KEYWORDS
from .mesh_file import MeshFile
from .parsing import Damaged as Damaged
from .parsing import Extras
from .parsing import call_reader as call_reader
from .parsing import import_optional as import_optional
from .pictures import write_image
from .vertex_splits import split_at_seams as split_at_seams

SUFFIXES = tuple(WRITERS)
READABLE = tuple(READABLE_SUFFIXES)

__all__ = [
    "READABLE",
    "SUFFIXES",
    "Extras",
    "MeshFile",
    "Segment",
    "image_maps",
    "read_file",
    "read_mesh",
    "read_texture",
    "read_tifxyz",
    "replacing",
    "unit_square",
    "write_file",
    "write_grid",
    "write_image",
    "write_mesh",
    "write_obj",
    "write_textured",
    "write_tifxyz",
]
