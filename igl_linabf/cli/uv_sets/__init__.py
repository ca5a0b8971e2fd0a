"""The commands `check` and `pack`, which measure and repack the texture coordinates of a mesh."""

from .checking import CHECK
from .packing import PACK
