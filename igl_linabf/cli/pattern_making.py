"""Define the command `igl-linabf pattern`."""

import warnings
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from .._runtime import progress_part
from ..charts import ChartOptions, Packing, unwrap
from ..errors import OutcomeWarning
from ..io import MeshFile
from ..patterns import (
    DEFAULT_UNITS,
    PAPERS,
    PATTERN_SUFFIXES,
    UNITS,
    PatternOptions,
    build_pattern,
    writing_pattern,
)
from .arguments import CHARTS, EXTEND_SEAMS, SEAMS, MethodName, Option, parse_axis, parse_factors, read_seams
from .jobs import MESHES, PROGRESS, REPORTS, ExitCode, Job, describe_output_options
from .outputs import report_troubles, write_outputs

OUTPUT = describe_output_options("SVG, DXF (both in millimetres) or PDF", PATTERN_SUFFIXES)
UNIT = Option(f"unit of length of the mesh (default: that in its file, or {DEFAULT_UNITS})", choices=UNITS)
GRAIN = Option("direction in space along which the arrows point (default: z)", "AXIS", parse_axis)
UP = Option("direction in space that points up on the pieces (default: the grain)", "AXIS", parse_axis)
TABS = Option("width of glue tabs for paper, in the unit of the mesh (default: no tabs)", "WIDTH")
ALLOWANCE = Option(
    "width of the seam allowance for cloth, in the unit of the mesh (default: no allowance)", "WIDTH"
)
COMPENSATION = Option(
    "factors that enlarge the pieces across and along the arrows, for cloth that shrinks: 1.03,1.05 "
    "(default: 1,1)",
    "ACROSS,ALONG",
    parse_factors,
)
UNITS_NOTES = {
    "option": "from --units",
    "file": "from its file",
    "default": "the default, because its file does not state a unit: see --units",
}


@dataclass(frozen=True)
class PatternJob(Job):
    """A job of the command `pattern`, which writes SVG by default."""

    format: str = "svg"

    suffixes = PATTERN_SUFFIXES


def draw_pattern(
    job: Annotated[PatternJob, {**MESHES, **OUTPUT, **REPORTS}],
    *,
    units: Annotated[str | None, UNIT] = None,
    crease: Annotated[float, Option("smallest angle between two faces at a fold line", "DEGREES")] = 30.0,
    grain: Annotated[list[float] | None, GRAIN] = None,
    up: Annotated[list[float] | None, UP] = None,
    paper: Annotated[str, Option("paper size of a PDF", choices=tuple(PAPERS))] = "A4",
    tabs: Annotated[float | None, TABS] = None,
    allowance: Annotated[float | None, ALLOWANCE] = None,
    compensation: Annotated[tuple[float, float] | None, COMPENSATION] = None,
    seams: Annotated[Literal["auto", "uv"] | Path, SEAMS] = "auto",
    charts: Annotated[ChartOptions | None, {"extend": EXTEND_SEAMS, **CHARTS}],
    method: MethodName = "isometric",
) -> ExitCode:
    """Unwrap a mesh and draw its pieces at true scale, with numbered seams, to cut and join.

    The table lists the lengths of both sides of each seam, and how much they differ. If the pattern changes
    lengths on the surface by more than 5 %, a warning says so.

    A sheet of thickness t has two sides that differ in size: pass its mid-surface, t/2 from both sides,
    instead of the closed solid. If bends are modelled as arcs, the pattern includes their bend allowance
    a (r + t/2), where a is the angle in radians and r is the inner radius.

    Examples
    --------
    lampshade.obj -o lampshade.svg --units cm    # a mesh in centimetres
    lamps/shade.gltf -o shade.svg --allow-outside    # its buffer is in another folder
    lampshade.glb -o lampshade.svg    # in metres, like every GLB
    lampshade.obj -o lampshade.pdf --paper A3 --quiet
    bodice.obj -o bodice.dxf --grain y --up z --crease 60 --trade 20 --method linabf
    box.obj -o box.pdf --units mm --tabs 8    # paper, with glue tabs of 8 mm
    duct.obj -o duct.dxf --units mm --seams pairs.txt    # along the edges of pairs.txt
    duct.obj -o duct.dxf --units mm --seams pairs.txt --extend-seams    # and along more
    bodice.obj -o bodice.pdf --units cm --hide back    # seams at the back
    bodice.obj -o bodice.pdf --units cm --max-stretch 1.0001    # more pieces, which fit better
    duct.obj -o duct.dxf --units mm --keep-holes
    lampshade.obj -o lampshade.pdf --max-dirichlet 4.01 --max-charts 6    # by a search over trade
    lampshade.obj -o lampshade.pdf --repair-overlaps
    bodice.obj -o bodice.svg --units cm --allowance 1.5 --compensation 1.03,1.05    # cloth that shrinks
    'parts/*.obj' -o sheets/ --format dxf --json > seams.jsonl    # one line per mesh
    'parts/*.obj' -o sheets/ --force    # replaces existing sheets
    """
    mesh = job.read_mesh()
    unit, given_by = _find_units(units, mesh)
    options = PatternOptions.from_arguments(
        unit, crease, grain or parse_axis("z"), up, tabs, allowance, compensation or (1.0, 1.0)
    )
    with warnings.catch_warnings(), progress_part("unwrapping", PROGRESS["computing"]):
        warnings.simplefilter("ignore", OutcomeWarning)  # `report_troubles` reports the problems
        edges = read_seams(seams, mesh, charts, method)
        # sheets are larger than pieces: do not cut pieces to fill a page
        atlas = unwrap(mesh.V, mesh.F, edges, charts=charts, method=method, packing=Packing(cut_below=0))
    pattern = build_pattern(mesh.V, mesh.F, atlas, options)
    figures = {"good": atlas.good, "troubles": atlas.troubles, "pattern": pattern, "units_given_by": given_by}
    text = f"{pattern} ({UNITS_NOTES[given_by]})"
    write_outputs(job, text, figures, write=partial(writing_pattern, pattern=pattern, paper=paper))
    return report_troubles(job, atlas.good, atlas.troubles)


def _find_units(asked: str | None, mesh: MeshFile) -> tuple[str, str]:
    """Return the unit of length, and whether an option, the file or the default sets it."""
    if asked is not None:
        return asked, "option"
    return (DEFAULT_UNITS, "default") if mesh.units is None else (mesh.units, "file")
