"""Texture coordinates that a mesh already has.

In: `V`, `F`, `TC`, `FTC` of any program. Out: a `UVCheck` that measures and judges them; or the same charts,
packed anew.
"""

from .checking import UVCheck, check_uv
from .repacking import SCALES as SCALES
from .repacking import PackedUV, pack
