"""Room: charts."""

from .atlas import Atlas, Chart, unwrap
from .overlap_seams import separating_seams
from .packing import pack
from .scaf import make_bijective
from .seams import TRADE, cut, find_seams, seam_mask, texture_seams

__all__ = [
    "TRADE",
    "Atlas",
    "Chart",
    "cut",
    "find_seams",
    "make_bijective",
    "pack",
    "seam_mask",
    "separating_seams",
    "texture_seams",
    "unwrap",
]
