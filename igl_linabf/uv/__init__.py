"""Check and repack existing texture coordinates from any program, given as `V`, `F`, `TC`, `FTC`."""

from .checking import CHECKED_RESOLUTION as CHECKED_RESOLUTION
from .checking import TexelDensity, UVCheck, UVCheckReport, check_uv
from .repacking import PackedUV, pack
from .repacking import ScaleName as ScaleName
from .sheets import Sheet
