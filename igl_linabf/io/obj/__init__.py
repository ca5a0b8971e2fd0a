"""OBJ, with the groups and materials that it names."""

from .reading import ObjText, parse_obj, with_looks
from .writing import materials_beside, save_obj
