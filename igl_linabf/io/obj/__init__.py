"""OBJ, with the groups and materials that it names."""

from .reading import ObjText, parse_obj, with_looks
from .writing import has_library, materials_beside, obj_names, save_obj, side_files
