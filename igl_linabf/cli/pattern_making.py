"""`igl-linabf pattern`."""

import argparse
import warnings
from functools import partial

from .._runtime import progress_part
from ..charts import Seams, unwrap
from ..errors import OutcomeWarning
from ..flattening import METHODS
from ..io import MeshFile
from ..patterns import DEFAULT_UNITS, PAPERS, PATTERN_SUFFIXES, UNITS, pattern_of, writing_pattern
from .arguments import axis, choice, format_of, shared, value, written_to
from .commands import Command
from .jobs import PROGRESS, given_mesh
from .outputs import check_outputs, hand_out, judged

GIVEN_BY = {
    "option": "as --units says",
    "file": "as its file says",
    "default": "taken so, as its file does not say: --units",
}


def _pattern(options: argparse.Namespace) -> int:
    check_outputs(options.output, None, PATTERN_SUFFIXES)
    mesh = given_mesh(options)
    with warnings.catch_warnings(), progress_part("unwrapping", PROGRESS["computing"]):
        warnings.simplefilter("ignore", OutcomeWarning)  # what is wrong is said below
        atlas = unwrap(mesh.V, mesh.F, Seams(trade=options.trade), options.method)
    units, given_by = _units(options.units, mesh)
    pattern = pattern_of(mesh.V, mesh.F, atlas, units, options.crease, options.grain, options.up)
    figures = {"good": atlas.good, "troubles": atlas.troubles, "pattern": pattern, "units_given_by": given_by}
    said = f"{pattern} ({GIVEN_BY[given_by]})"
    hand_out(options, said, figures, write=partial(writing_pattern, pattern=pattern, paper=options.paper))
    return judged(options, atlas.good, atlas.troubles)


def _units(asked: str | None, mesh: MeshFile) -> tuple[str, str]:
    """The unit of length, and who gives it."""
    if asked is not None:
        return asked, "option"
    return (DEFAULT_UNITS, "default") if mesh.units is None else (mesh.units, "file")


PATTERN = Command(
    "pattern",
    _pattern,
    "unwrap a mesh and draw its pieces at true scale, with numbered seams, to cut and join",
    {
        **shared("mesh"),
        "output": written_to("SVG, DXF or PDF file (a unit of SVG and DXF is a millimetre)"),
        "format": format_of(PATTERN_SUFFIXES, "svg"),
        "units": choice(
            UNITS, help=f"of the mesh (default: those of its file; {DEFAULT_UNITS} if it says none)"
        ),
        "crease": value("DEGREES", "between faces, from which their edge is a fold line", float, 30.0),
        "grain": value("AXIS", "direction in space along which the arrows point", axis, "z"),
        "up": value("AXIS", "direction in space that points up on the pieces (default: the grain)", axis),
        "paper": choice(PAPERS, "A4", "of a PDF"),
        **shared("trade"),
        "method": choice(sorted(METHODS), "isometric"),
        **shared("force", "json", "quiet"),
    },
    "Draw a pattern at true scale. The table lists the lengths of both sides of each seam.",
    (
        "lampshade.obj -o lampshade.svg --units cm    # a mesh in centimetres",
        "lampshade.glb -o lampshade.svg    # in metres, as every GLB",
        "lampshade.obj -o lampshade.pdf --paper A3 --quiet",
        "bodice.obj -o bodice.dxf --grain y --up z --crease 60 --trade 20 --method linabf",
        "'parts/*.obj' -o sheets/ --format dxf --json > seams.jsonl    # one line a mesh",
        "'parts/*.obj' -o sheets/ --force    # replaces sheets that are there already",
    ),
    each=True,
)
