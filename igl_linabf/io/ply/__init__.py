"""PLY, text and binary, with any elements and properties."""

from .reading import PlyTables, parse_ply
from .writing import save_ply
