"""Read and write 3MF with lib3mf: placed objects, names, units, colours and texture coordinates."""

from .reading import ThreeMfFile, parse_3mf
from .writing import save_3mf
