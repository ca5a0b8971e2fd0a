"""The command `igl-linabf pattern`."""

import argparse
import warnings
from functools import partial

from .._runtime import progress_part
from ..charts import ChartOptions, unwrap
from ..errors import OutcomeWarning
from ..flattening import METHODS
from ..io import MeshFile
from ..patterns import DEFAULT_UNITS, PAPERS, PATTERN_SUFFIXES, UNITS, pattern_of, writing_pattern
from .arguments import choice, format_argument, output_argument, parse_axis, shared_arguments, value
from .commands import Command
from .jobs import PROGRESS, read_given_mesh
from .outputs import check_outputs, report_troubles, write_outputs

UNITS_NOTES = {
    "option": "from --units",
    "file": "from its file",
    "default": "the default, because its file does not state a unit: see --units",
}


def _pattern(options: argparse.Namespace) -> int:
    check_outputs(options.output, None, PATTERN_SUFFIXES)
    mesh = read_given_mesh(options)
    with warnings.catch_warnings(), progress_part("unwrapping", PROGRESS["computing"]):
        warnings.simplefilter("ignore", OutcomeWarning)  # reported below
        atlas = unwrap(mesh.V, mesh.F, charts=ChartOptions(trade=options.trade), method=options.method)
    units, given_by = _find_units(options.units, mesh)
    pattern = pattern_of(mesh.V, mesh.F, atlas, units, options.crease, options.grain, options.up)
    figures = {"good": atlas.good, "troubles": atlas.troubles, "pattern": pattern, "units_given_by": given_by}
    text = f"{pattern} ({UNITS_NOTES[given_by]})"
    write_outputs(
        options, text, figures, write=partial(writing_pattern, pattern=pattern, paper=options.paper)
    )
    return report_troubles(options, atlas.good, atlas.troubles)


def _find_units(asked: str | None, mesh: MeshFile) -> tuple[str, str]:
    """Return the unit of length, and whether an option, the file or the default sets it."""
    if asked is not None:
        return asked, "option"
    return (DEFAULT_UNITS, "default") if mesh.units is None else (mesh.units, "file")


PATTERN = Command(
    "pattern",
    _pattern,
    "unwrap a mesh and draw its pieces at true scale, with numbered seams, to cut and join",
    {
        **shared_arguments("mesh"),
        "output": output_argument("SVG, DXF or PDF file (a unit of SVG and DXF is a millimetre)"),
        "format": format_argument(PATTERN_SUFFIXES, "svg"),
        "units": choice(
            UNITS, help=f"unit of length of the mesh (default: that in its file, or {DEFAULT_UNITS})"
        ),
        "crease": value("DEGREES", "smallest angle between two faces at a fold line", float, 30.0),
        "grain": value("AXIS", "direction in space along which the arrows point", parse_axis, "z"),
        "up": value(
            "AXIS", "direction in space that points up on the pieces (default: the grain)", parse_axis
        ),
        "paper": choice(PAPERS, "A4", "paper size of a PDF"),
        **shared_arguments("trade"),
        "method": choice(sorted(METHODS), "isometric"),
        **shared_arguments("force", "json", "quiet"),
    },
    "Draw a pattern at true scale. The table lists the lengths of both sides of each seam.",
    (
        "lampshade.obj -o lampshade.svg --units cm    # a mesh in centimetres",
        "lampshade.glb -o lampshade.svg    # in metres, like every GLB",
        "lampshade.obj -o lampshade.pdf --paper A3 --quiet",
        "bodice.obj -o bodice.dxf --grain y --up z --crease 60 --trade 20 --method linabf",
        "'parts/*.obj' -o sheets/ --format dxf --json > seams.jsonl    # one line per mesh",
        "'parts/*.obj' -o sheets/ --force    # replaces existing sheets",
    ),
    each=True,
)
