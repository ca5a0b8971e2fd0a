"""3MF, by lib3mf: objects where the build places them, names, the unit, colours, texture coordinates."""

from .reading import ThreeMfFile, parse_3mf
from .writing import save_3mf
