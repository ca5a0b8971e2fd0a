"""Read and write OBJ files with their groups, and MTL files with their images."""

from .reading import ObjText, load_materials, parse_obj
from .writing import (
    encode_material_files,
    get_image_paths,
    get_library_path,
    has_library,
    make_obj_names,
    make_unused_name,
    save_obj,
)
