"""Options of commands that pack charts for a texture."""

from __future__ import annotations

from collections.abc import Mapping

from .commands import Argument

PACKING: Mapping[str, Argument] = {
    "resolution": {
        "type": int,
        "metavar": "TEXELS",
        "help": "texels along a page's side; distances between charts are then counted in texels",
    },
    "padding": {
        "type": float,
        "default": 2.0,
        "metavar": "TEXELS",
        "help": "between two charts, with --resolution (default: %(default)g)",
    },
    "texel-density": {
        "type": float,
        "metavar": "TEXELS",
        "help": "texels per unit of length (default: as many as the pages hold)",
    },
    "pages": {
        "type": int,
        "metavar": "N",
        "help": "pages, as UDIM tiles (default: 1, or what it takes)",
    },
}
NAMES = tuple(name.replace("-", "_") for name in PACKING)
