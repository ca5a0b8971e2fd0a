"""Room: io."""

from .formats import parse
from .plain import read_mesh, replacing, unit_square, write_obj
from .textured import SUFFIXES, read_texture, write_mesh

__all__ = [
    "SUFFIXES",
    "parse",
    "read_mesh",
    "read_texture",
    "replacing",
    "unit_square",
    "write_mesh",
    "write_obj",
]
