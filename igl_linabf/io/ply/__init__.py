"""Read and write text and binary PLY files with all their elements and properties."""

from .reading import PlyTables, parse_ply, select_second_uv_set
from .writing import save_ply
