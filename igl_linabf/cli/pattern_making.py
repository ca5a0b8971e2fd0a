"""`igl-linabf pattern`."""

from __future__ import annotations

import argparse
import sys
import warnings
from functools import partial
from pathlib import Path

from .._runtime import part
from ..charts import unwrap
from ..errors import OutcomeWarning
from ..patterns import PAPERS, PATTERN_SUFFIXES, UNITS, drawn, pattern_of
from .commands import GOOD, JSON, MESHES, METHOD, NOT_VALID, QUIET, Command
from .jobs import COMPUTED, given_mesh
from .outputs import check_outputs, hand_out
from .unwrapping import TRADED, direction


def _pattern(options: argparse.Namespace) -> int:
    check_outputs(options.output, None, PATTERN_SUFFIXES)
    mesh = given_mesh(options)
    with warnings.catch_warnings(), part("unwrapping", COMPUTED):
        warnings.simplefilter("ignore", OutcomeWarning)  # what is wrong is said below
        atlas = unwrap(mesh.V, mesh.F, None, options.method, trade=options.trade)
    pattern = pattern_of(mesh.V, mesh.F, atlas, options.units, options.crease, options.grain)
    figures = {"good": atlas.good, "troubles": atlas.troubles, "pattern": pattern}
    hand_out(options, str(pattern), figures, write=partial(drawn, pattern=pattern, paper=options.paper))
    for message in atlas.troubles:
        print(f"igl-linabf: {options.of}{message}", file=sys.stderr)
    return GOOD if atlas.good else NOT_VALID


PATTERN = Command(
    "pattern",
    _pattern,
    "unwrap a mesh and draw its pieces at true scale, with numbered seams, to cut and join",
    {
        "mesh": MESHES,
        "output": {
            "metavar": "OUT",
            "type": Path,
            "required": True,
            "help": "SVG, DXF or PDF file (a unit of SVG and DXF is a millimetre), or a folder that exists, "
            "or - for standard output",
        },
        "format": {
            "choices": [suffix[1:] for suffix in PATTERN_SUFFIXES],
            "default": "svg",
            "help": "of files in a folder and of standard output (default: %(default)s)",
        },
        "units": {"choices": UNITS, "default": "mm", "help": "of the mesh (default: %(default)s)"},
        "crease": {
            "metavar": "DEGREES",
            "type": float,
            "default": 30.0,
            "help": "between faces, from which their edge is a fold line (default: %(default)s)",
        },
        "grain": {
            "metavar": "X,Y,Z",
            "type": direction,
            "default": [0.0, 0.0, 1.0],
            "help": "direction in space along which the arrows point (default: 0,0,1)",
        },
        "paper": {"choices": PAPERS, "default": "A4", "help": "of a PDF (default: %(default)s)"},
        "trade": TRADED,
        "method": {**METHOD, "default": "isometric"},
        "json": JSON,
        "quiet": QUIET,
    },
    "Draw a pattern at true scale. The table lists the lengths of both sides of each seam.",
    (
        "lampshade.obj -o lampshade.svg --units cm    # a mesh in centimetres",
        "lampshade.obj -o lampshade.pdf --paper A3 --quiet",
        "bodice.obj -o bodice.dxf --grain 0,1,0 --crease 60 --trade 20 --method linabf",
        "'parts/*.obj' -o sheets/ --format dxf --json > seams.jsonl    # one line a mesh",
    ),
    each=True,
)
