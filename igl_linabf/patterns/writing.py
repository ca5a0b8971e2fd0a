"""Draw patterns on a sheet in millimetres, and write it with svgwrite, ezdxf or matplotlib."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray
from ..charts import Atlas
from ..io import import_optional, replacing
from .pieces import MILLIMETRES, Pattern, build_pattern

MARGIN = 10.0  # margin of the sheet and of each page, and overlap of pages, in mm
LINE_WIDTH = 0.25  # in mm
BAR_LENGTHS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # possible lengths of the scale bar, in mm

PAPERS = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "A0": (841.0, 1189.0), "letter": (215.9, 279.4)}  # mm
INSTALL_HINT = "patterns need pip install 'igl-linabf[patterns]'"

OUTLINE, SEAM, FOLD, TEXT, GRAIN = "outline", "seam", "fold", "text", "grain"
COLOURS = {OUTLINE: "#000000", SEAM: "#c02020", FOLD: "#2050c0", TEXT: "#000000", GRAIN: "#208040"}
DASHED = {FOLD}
Units = Literal["mm", "cm", "m", "in", "ft", "um"]


@dataclass(frozen=True, eq=False)
class Stroke:
    """A polyline through points (n, 2), open or closed."""

    layer: str
    points: FloatArray
    closed: bool = False


@dataclass(frozen=True, eq=False)
class Label:
    """A text centred at a point."""

    layer: str
    text: str
    at: FloatArray
    height: float


@dataclass(frozen=True, eq=False)
class Sheet:
    """All lines and texts of a drawing, whose lower left corner is at (0, 0)."""

    width: float
    height: float
    strokes: tuple[Stroke, ...]
    labels: tuple[Label, ...]


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
) -> Pattern:
    """Write the pieces of a flattened surface at true scale, to be cut out and joined.

    Both sides of a seam have the same number, at a notch in the middle of each side. Creases are dashed fold
    lines. An arrow on each piece shows the grain, and a scale bar is drawn below the pieces. A PDF is tiled
    into pages, which overlap by a centimetre.

    Pieces of an `Atlas` that fit along a seam are joined, and slits whose sides coincide are closed, so that
    a hole in a plate stays a hole. Seams that were given to `unwrap` are kept. All pieces are rotated so that
    their arrows point up.

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

    Returns
    -------
    Pattern
        The drawn lines. `print(pattern)` lists the lengths of both sides of each seam.

    Raises
    ------
    MeshError
        The arrays do not match.
    ValueError
        The suffix is unknown, or `units`, `grain`, `up` or `paper` has an invalid value.
    ImportError
        The package that writes this format is missing; the message has the pip command.
    OSError
        The file cannot be written. In that case no file is left behind.

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
    """
    path = Path(path)
    if path.suffix.lower() not in WRITERS:
        raise ValueError(f"{path} is not a pattern file: use one that ends in {', '.join(WRITERS)}")
    if paper not in PAPERS:
        raise ValueError(f"paper is {paper!r}: use one of {', '.join(PAPERS)}")
    pattern = build_pattern(V, F, atlas, units, crease, grain, up)
    with writing_pattern(path, pattern, paper):
        return pattern


@contextmanager
def writing_pattern(path: str | os.PathLike[str], pattern: Pattern, paper: str) -> Iterator[None]:
    """Write a pattern under a temporary name, and rename the file when the `with` block succeeds.

    The suffix selects the format.
    """
    with replacing(path) as temporary:
        WRITERS[Path(path).suffix.lower()](temporary, _build_sheet(pattern), PAPERS[paper])
        yield


def _build_sheet(pattern: Pattern) -> Sheet:
    """Return a sheet with outlines, seam marks, folds, arrows, names of pieces, and a scale bar."""
    width, height = pattern.size
    text = float(np.clip(max(width, height) / 60, 0.5, 5.0))
    foot = 4 * text + MARGIN
    shift = np.array([MARGIN, MARGIN + foot])
    strokes = [Stroke(OUTLINE, line + shift, closed=True) for line in pattern.outlines]
    strokes += [Stroke(FOLD, fold + shift) for fold in pattern.folds]
    labels = []
    for seam in pattern.seams:
        small = float(
            np.clip(0.4 * min(seam.lengths), 0.3 * text, text)
        )  # smaller on short seams, so that neighbouring labels do not overlap
        for side, towards in zip(seam.sides, (1.0, 1.0 if seam.twisted else -1.0), strict=True):
            at, normal = _find_midpoint(side)
            notch = np.array([at, at + 0.8 * small * towards * normal])
            strokes.append(Stroke(SEAM, notch + shift))
            labels.append(Label(SEAM, str(seam.number), at + 1.6 * small * towards * normal + shift, small))
    for i, (tail, head) in enumerate(pattern.grain):
        strokes += [Stroke(GRAIN, line + shift) for line in _draw_arrow(tail, head, text)]
        labels.append(Label(TEXT, f"piece {i}", 0.4 * tail + 0.6 * head + shift + [0, 1.5 * text], text))
    bar = float(
        max(
            (length for length in BAR_LENGTHS if length <= 0.6 * max(width, 10 * text)),
            default=BAR_LENGTHS[0],
        )
    )
    left, base = MARGIN, MARGIN + 1.5 * text
    ends = [np.array([[x, base - text / 2], [x, base + text / 2]]) for x in (left, left + bar)]
    rule = np.array([[left, base], [left + bar, base]])
    strokes += [Stroke(TEXT, line) for line in (rule, *ends)]
    labels.append(Label(TEXT, f"{bar:g} mm", np.array([left + bar / 2, base + 1.2 * text]), text))
    whole = max(width, bar, 12 * text) + 2 * MARGIN
    return Sheet(whole, height + foot + 2 * MARGIN, tuple(strokes), tuple(labels))


def _find_midpoint(line: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the point halfway along a line by length, and the unit normal to the left at this point."""
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    reached = np.cumsum(step)
    k = min(int(np.searchsorted(reached, reached[-1] / 2)), len(step) - 1)
    share = (reached[-1] / 2 - reached[k] + step[k]) / max(step[k], np.finfo(float).tiny)
    along = (line[k + 1] - line[k]) / max(step[k], np.finfo(float).tiny)
    return line[k] + share * (line[k + 1] - line[k]), np.array([-along[1], along[0]])


def _draw_arrow(tail: FloatArray, head: FloatArray, size: float) -> list[FloatArray]:
    """Return the two polylines of an arrow: its shaft and its head."""
    along = (head - tail) / max(float(np.linalg.norm(head - tail)), np.finfo(float).tiny)
    aside = np.array([-along[1], along[0]])
    barb = np.array([head - size * (along + aside / 2), head, head - size * (along - aside / 2)])
    return [np.array([tail, head]), barb]


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

    for layer, colour in COLOURS.items():
        group = drawing.g(id=layer, stroke=colour, fill="none", stroke_width=LINE_WIDTH)
        for stroke in sheet.strokes:
            if stroke.layer == layer:
                shape = drawing.polygon if stroke.closed else drawing.polyline
                dashes = {"stroke_dasharray": "3,2"} if layer in DASHED else {}
                group.add(shape(flip_y(stroke.points), **dashes))
        drawing.add(group)
        texts = drawing.g(fill=colour, text_anchor="middle", font_family="sans-serif")
        for label in sheet.labels:
            if label.layer == layer:
                (x, y), size = flip_y(label.at[None])[0], label.height
                texts.add(drawing.text(label.text, insert=(x, y + 0.35 * size), font_size=size))
        drawing.add(texts)
    drawing.save()


def _save_dxf(path: str, sheet: Sheet, _: tuple[float, float]) -> None:
    ezdxf = import_optional("ezdxf", INSTALL_HINT)
    document = ezdxf.new("R2010", setup=True)
    document.units = ezdxf.units.MM
    model = document.modelspace()
    for layer, colour in COLOURS.items():
        made = document.layers.add(layer, linetype="DASHED" if layer in DASHED else "CONTINUOUS")
        made.rgb = tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5))
    for stroke in sheet.strokes:
        model.add_lwpolyline(stroke.points.tolist(), close=stroke.closed, dxfattribs={"layer": stroke.layer})
    middle = ezdxf.enums.TextEntityAlignment.MIDDLE_CENTER
    for label in sheet.labels:
        text = model.add_text(label.text, height=label.height, dxfattribs={"layer": label.layer})
        text.set_placement(label.at.tolist(), align=middle)
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
        style = (0, (6, 4)) if stroke.layer in DASHED else "-"
        (shape,) = axes.plot(
            *line.T, color=COLOURS[stroke.layer], linewidth=LINE_WIDTH * points, linestyle=style
        )
        shape.set_clip_path(frame)
    for label in sheet.labels:
        if (label.at >= corner).all() and (label.at <= corner + free).all():
            axes.text(*label.at, label.text, fontsize=label.height * points, color=COLOURS[label.layer],
                      ha="center", va="center")  # fmt: skip
    axes.text(corner[0], corner[1] - MARGIN / 2, name, fontsize=8, va="center")
    return figure


WRITERS: dict[str, Callable[[str, Sheet, tuple[float, float]], None]] = {
    ".svg": _save_svg,
    ".dxf": _save_dxf,
    ".pdf": _save_pdf,
}
PATTERN_SUFFIXES = tuple(WRITERS)
