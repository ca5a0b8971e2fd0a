"""Write patterns as SVG, DXF or PDF with svgwrite, ezdxf or matplotlib."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray
from ..charts import Atlas
from ..io import import_optional, replacing
from .options import MILLIMETRES, PatternOptions
from .pattern import Pattern, build_pattern
from .sheets import MARGIN, STYLES, Sheet, build_sheet

LINE_WIDTH = 0.25  # in mm

PAPERS = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "A0": (841.0, 1189.0), "letter": (215.9, 279.4)}  # mm
INSTALL_HINT = "patterns need pip install 'igl-linabf[patterns]'"
Units = Literal["mm", "cm", "m", "in", "ft", "um"]


def write_pattern(
    path: str | os.PathLike[str],
    V: ArrayLike,
    F: ArrayLike,
    atlas: Atlas | ArrayLike,
    units: Units | None = None,
    *,
    crease: float = 30.0,
    grain: ArrayLike = (0.0, 0.0, 1.0),
    up: ArrayLike | None = None,
    paper: str = "A4",
    tabs: float | None = None,
    allowance: float | None = None,
    compensation: ArrayLike = (1.0, 1.0),
) -> Pattern:
    """Write the pieces of a flattened surface at true scale, to be cut out and joined.

    Both sides of a seam have the same number, at a notch in the middle of each side. Creases are fold lines:
    dash-dotted mountain folds away from the viewer, who sees the outside of the surface, and dashed valley
    folds towards the viewer. An arrow on each piece shows the grain. A scale bar and a legend are drawn below
    the pieces. A PDF is tiled into pages, which overlap by a centimetre.

    Pieces of an `Atlas` that fit along a seam are joined, and slits whose sides coincide are closed, so that
    a hole in a plate stays a hole. Seams that were given to `unwrap` are kept. All pieces are rotated so that
    their arrows point up.

    A sheet of thickness t has two sides that differ in size. Pass its mid-surface, t / 2 from both sides,
    instead of the closed solid. If bends are modelled as arcs of the mid-surface, their bend allowance is
    included: a bend by the angle a (radians) with the inner radius r takes a (r + k t) of the sheet, with
    k = 0.5 on the mid-surface.

    Parameters
    ----------
    path : path of an SVG, DXF or PDF file
        A unit of SVG and DXF is a millimetre.
    V : (#V, 3) float
    F : (#F, 3) int, or polygons
    atlas : Atlas, or (#V, 2) float
        The result of `unwrap` for V and F, or a flat map. `method="isometric"` preserves lengths best.
    units : {"mm", "cm", "m", "in", "ft", "um"}, optional
        Unit of length of V; by default "mm". `read_file(path).units` is the unit stated in a file.
        The pattern's attribute `units` is the unit that was used.
    crease : float
        Smallest angle between neighbouring faces at a fold line, in degrees.
    grain : (3,) float
        Direction in space along which the arrows point. On pieces that are perpendicular to it, the arrow is
        parallel to the long side.
    up : (3,) float, optional
        Direction in space that points up on the pieces; by default the direction of the grain. If all pieces
        are perpendicular to it, their long sides are horizontal. A single flat piece has upright sides.
    paper : {"A4", "A3", "A0", "letter"}
        Paper size of a PDF.
    tabs : float, optional
        Width of glue tabs for paper, in the unit of V. Each straight part of a seam has a trapezoid on one of
        its sides. Tabs are tapered and, if necessary, less wide than `tabs`: they overlap neither a piece nor
        another tab, and do not stick out of the face behind them.
    allowance : float, optional
        Width of the seam allowance for cloth, in the unit of V. The pieces are cut along lines at this
        distance from all outlines. Notches extend from the cutting line across the sewing line.
    compensation : (2,) float
        Factors that enlarge the pieces across and along their arrows (weft and warp, if the grain is the
        warp). They are applied last, and do not change the widths of tabs and allowance. For cloth that
        shrinks by 5 % along the grain, use (1, 1 / 0.95).

    Returns
    -------
    Pattern
        The drawn lines, in millimetres. `print(pattern)` lists the lengths of both sides of each seam.

    Raises
    ------
    MeshError
        The arrays do not match.
    ValueError
        The suffix is unknown, an option has an invalid value, or both `tabs` and `allowance` are given.
    ImportError
        The package that writes this format is missing; the message has the pip command.
    OSError
        The file cannot be written. In that case no file is left behind.

    Warns
    -----
    OutcomeWarning
        The lengths of some edges change by more than 5 %: the pieces do not fit the surface.
    MeshWarning
        Some seams have no room for tabs or allowance.

    Examples
    --------
    >>> import os, tempfile, igl_linabf
    >>> V = [[x, y, z] for z in (0, 40) for y in (0, 30) for x in (0, 20)]
    >>> F = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> path = os.path.join(tempfile.mkdtemp(), "box.svg")
    >>> pattern = write_pattern(path, V, F, igl_linabf.unwrap(V, F), "mm")
    >>> pattern.pieces, len(pattern.seams), len(pattern.folds)
    (1, 3, 5)
    >>> bool(pattern.error < 1e-6)
    True
    >>> bool((pattern.fold_angles > 0).all())  # all folds of a convex body are mountain folds
    True
    >>> len(write_pattern(path, V, F, igl_linabf.unwrap(V, F), "mm", tabs=8).tabs)
    7
    """
    path = Path(path)
    if path.suffix.lower() not in WRITERS:
        raise ValueError(f"{path} is not a pattern file: use one that ends in {', '.join(WRITERS)}")
    if paper not in PAPERS:
        raise ValueError(f"paper is {paper!r}: use one of {', '.join(PAPERS)}")
    options = PatternOptions.from_arguments(units, crease, grain, up, tabs, allowance, compensation)
    pattern = build_pattern(V, F, atlas, options)
    with writing_pattern(path, pattern, paper):
        return pattern


@contextmanager
def writing_pattern(path: str | os.PathLike[str], pattern: Pattern, paper: str) -> Iterator[None]:
    """Write a pattern under a temporary name, and rename the file when the `with` block succeeds.

    The suffix selects the format.
    """
    with replacing(path) as temporary:
        WRITERS[Path(path).suffix.lower()](temporary, build_sheet(pattern), PAPERS[paper])
        yield


def _save_svg(path: str, sheet: Sheet, _: tuple[float, float]) -> None:
    svgwrite = import_optional("svgwrite", INSTALL_HINT)
    drawing = svgwrite.Drawing(
        path,
        size=(f"{sheet.width!r}mm", f"{sheet.height!r}mm"),
        viewBox=f"0 0 {sheet.width!r} {sheet.height!r}",
        debug=False,  # svgwrite's checks of each number would dominate the time
    )

    def flip_y(points: FloatArray) -> list[tuple[float, float]]:
        return [(x, sheet.height - y) for x, y in points.tolist()]

    for layer, own in STYLES.items():
        group = drawing.g(id=layer, stroke=own.colour, fill="none", stroke_width=LINE_WIDTH)
        for stroke in sheet.strokes:
            if stroke.layer == layer:
                shape = drawing.polygon if stroke.closed else drawing.polyline
                style, settings = stroke.style, {}
                if style.dashes:
                    settings["stroke_dasharray"] = ",".join(f"{length:g}" for length in style.dashes)
                if style.colour != own.colour:
                    settings["stroke"] = style.colour
                group.add(shape(flip_y(stroke.points), **settings))
        drawing.add(group)
        texts = drawing.g(fill=own.colour, font_family="sans-serif")
        for label in sheet.labels:
            if label.layer == layer:
                (x, y), size = flip_y(label.at[None])[0], label.height
                anchor = "middle" if label.centred else "start"
                place = (x, y + 0.35 * size)
                texts.add(drawing.text(label.text, insert=place, font_size=size, text_anchor=anchor))
        drawing.add(texts)
    drawing.save()


def _save_dxf(path: str, sheet: Sheet, _: tuple[float, float]) -> None:
    ezdxf = import_optional("ezdxf", INSTALL_HINT)
    document = ezdxf.new("R2010", setup=True)
    document.units = ezdxf.units.MM
    model = document.modelspace()
    for layer, style in STYLES.items():
        if style.dashes:
            signed = [length * (-1) ** k for k, length in enumerate(style.dashes)]
            document.linetypes.add(layer.upper(), [sum(style.dashes), *signed], description=f"{layer} lines")
        made = document.layers.add(layer, linetype=layer.upper() if style.dashes else "CONTINUOUS")
        made.rgb = tuple(int(style.colour[i : i + 2], 16) for i in (1, 3, 5))
    for stroke in sheet.strokes:
        line = model.add_lwpolyline(stroke.points.tolist(), close=stroke.closed)
        line.dxf.layer = stroke.layer
        if stroke.sample_of is not None:
            sampled = document.layers.get(stroke.sample_of)
            line.dxf.linetype, line.rgb = sampled.dxf.linetype, sampled.rgb
    alignments = ezdxf.enums.TextEntityAlignment
    for label in sheet.labels:
        text = model.add_text(label.text, height=label.height, dxfattribs={"layer": label.layer})
        align = alignments.MIDDLE_CENTER if label.centred else alignments.MIDDLE_LEFT
        text.set_placement(label.at.tolist(), align=align)
    document.saveas(path)


def _save_pdf(path: str, sheet: Sheet, paper: tuple[float, float]) -> None:
    """Write the sheet as one page if it fits, otherwise as overlapping pages labelled by row and column.

    The pages are in landscape format if fewer pages are then needed.
    """
    figures = import_optional("matplotlib.figure", INSTALL_HINT)
    pages = import_optional("matplotlib.backends.backend_pdf", INSTALL_HINT)
    paper = min((paper, paper[::-1]), key=lambda size: int(np.prod(_count_tiles(sheet, size))))
    free, (columns, rows) = np.array(paper) - 2 * MARGIN, _count_tiles(sheet, paper)
    with pages.PdfPages(path, metadata={"Creator": "igl_linabf", "CreationDate": None}) as file:
        for row in range(rows):
            for column in range(columns):
                corner = np.array([column, rows - 1 - row]) * (free - MARGIN)
                name = f"row {row + 1} of {rows}, column {column + 1} of {columns}"
                file.savefig(_draw_page(figures, sheet, corner, free, paper, name))


def _count_tiles(sheet: Sheet, paper: tuple[float, float]) -> tuple[int, int]:
    """Return the numbers of columns and rows of pages that a sheet needs."""
    columns, rows = (
        max(1, int(np.ceil((size - MARGIN) / (room - 3 * MARGIN) - 1e-9)))
        for size, room in zip((sheet.width, sheet.height), paper, strict=True)
    )
    return columns, rows


def _draw_page(
    module: Any, sheet: Sheet, corner: FloatArray, free: FloatArray, paper: tuple[float, float], name: str
) -> Any:
    """Draw one page of the sheet; `corner` is the lower left corner of its frame on the sheet."""
    figure = module.Figure(figsize=(paper[0] / MILLIMETRES["in"], paper[1] / MILLIMETRES["in"]))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(corner[0] - MARGIN, corner[0] - MARGIN + paper[0])
    axes.set_ylim(corner[1] - MARGIN, corner[1] - MARGIN + paper[1])
    points = 72 / MILLIMETRES["in"]
    frame = import_optional("matplotlib.patches", INSTALL_HINT).Rectangle(
        (corner[0], corner[1]), *free, fill=False, linewidth=0.5, edgecolor="#888888"
    )
    axes.add_patch(frame)
    for stroke in sheet.strokes:
        line = np.vstack((stroke.points, stroke.points[:1])) if stroke.closed else stroke.points
        if (line.max(axis=0) < corner).any() or (line.min(axis=0) > corner + free).any():
            continue
        style = stroke.style
        dashes = (0, tuple(length / LINE_WIDTH for length in style.dashes)) if style.dashes else "-"
        (shape,) = axes.plot(*line.T, color=style.colour, linewidth=LINE_WIDTH * points, linestyle=dashes)
        shape.set_clip_path(frame)
    for label in sheet.labels:
        if (label.at >= corner).all() and (label.at <= corner + free).all():
            axes.text(*label.at, label.text, fontsize=label.height * points, color=STYLES[label.layer].colour,
                      ha="center" if label.centred else "left", va="center")  # fmt: skip
    axes.text(corner[0], corner[1] - MARGIN / 2, name, fontsize=8, va="center")
    return figure


WRITERS: dict[str, Callable[[str, Sheet, tuple[float, float]], None]] = {
    ".svg": _save_svg,
    ".dxf": _save_dxf,
    ".pdf": _save_pdf,
}
PATTERN_SUFFIXES = tuple(WRITERS)
