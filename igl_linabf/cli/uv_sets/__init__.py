"""The commands for texture coordinates that a mesh has.

In: a command line. Out: what is wrong with them, and an exit code; or a file with their charts packed anew.
"""

from .checking import CHECK
from .packing import PACK
