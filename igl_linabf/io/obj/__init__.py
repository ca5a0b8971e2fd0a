"""OBJ, with the groups and materials that it names."""

from .reading import ObjText, parse_obj, with_looks
from .writing import has_library, image_files, library_of, materials_beside, obj_names, save_obj, without_name
