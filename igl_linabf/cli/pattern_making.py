"""`igl-linabf pattern`."""

import argparse
import warnings
from functools import partial

from .._runtime import progress_part
from ..charts import Seams, unwrap
from ..errors import OutcomeWarning
from ..flattening import METHODS
from ..patterns import PAPERS, PATTERN_SUFFIXES, UNITS, pattern_of, writing_pattern
from .arguments import axis, choice, format_of, shared, value, written_to
from .commands import Command
from .jobs import PROGRESS, given_mesh
from .outputs import check_outputs, hand_out, judged


def _pattern(options: argparse.Namespace) -> int:
    check_outputs(options.output, None, PATTERN_SUFFIXES)
    mesh = given_mesh(options)
    with warnings.catch_warnings(), progress_part("unwrapping", PROGRESS["computing"]):
        warnings.simplefilter("ignore", OutcomeWarning)  # what is wrong is said below
        atlas = unwrap(mesh.V, mesh.F, Seams(trade=options.trade), options.method)
    asked = options.units, options.crease, options.grain, options.up
    pattern = pattern_of(mesh.V, mesh.F, atlas, *asked)
    figures = {"good": atlas.good, "troubles": atlas.troubles, "pattern": pattern}
    hand_out(
        options, str(pattern), figures, write=partial(writing_pattern, pattern=pattern, paper=options.paper)
    )
    return judged(options, atlas.good, atlas.troubles)


PATTERN = Command(
    "pattern",
    _pattern,
    "unwrap a mesh and draw its pieces at true scale, with numbered seams, to cut and join",
    {
        **shared("mesh"),
        "output": written_to("SVG, DXF or PDF file (a unit of SVG and DXF is a millimetre)"),
        "format": format_of(PATTERN_SUFFIXES, "svg"),
        "units": choice(UNITS, "mm", "of the mesh"),
        "crease": value("DEGREES", "between faces, from which their edge is a fold line", float, 30.0),
        "grain": value("AXIS", "direction in space along which the arrows point", axis, "z"),
        "up": value("AXIS", "direction in space that points up on the pieces (default: the grain)", axis),
        "paper": choice(PAPERS, "A4", "of a PDF"),
        **shared("trade"),
        "method": choice(sorted(METHODS), "isometric"),
        **shared("json", "quiet"),
    },
    "Draw a pattern at true scale. The table lists the lengths of both sides of each seam.",
    (
        "lampshade.obj -o lampshade.svg --units cm    # a mesh in centimetres",
        "lampshade.obj -o lampshade.pdf --paper A3 --quiet",
        "bodice.obj -o bodice.dxf --grain y --up z --crease 60 --trade 20 --method linabf",
        "'parts/*.obj' -o sheets/ --format dxf --json > seams.jsonl    # one line a mesh",
    ),
    each=True,
)
