"""Write patterns: laid out on a sheet, in millimetres; SVG by svgwrite, DXF by ezdxf, PDF by matplotlib."""

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
from ..errors import MeshError
from ..io import import_optional, replacing
from .constants import BAR_LENGTHS, LINE_WIDTH, MARGIN
from .pieces import MILLIMETRES, Pattern, pattern_of

PAPERS = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "A0": (841.0, 1189.0), "letter": (215.9, 279.4)}
EXTRA = "patterns need pip install 'igl-linabf[patterns]'"

OUTLINE, SEAM, FOLD, TEXT, GRAIN = "outline", "seam", "fold", "text", "grain"
COLOURS = {OUTLINE: "#000000", SEAM: "#c02020", FOLD: "#2050c0", TEXT: "#000000", GRAIN: "#208040"}
DASHED = {FOLD}
Units = Literal["mm", "cm", "m", "in", "ft", "um"]


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line through points (n, 2)."""

    layer: str
    points: FloatArray
    closed: bool = False


@dataclass(frozen=True, eq=False)
class Label:
    """A text with its middle at a place."""

    layer: str
    text: str
    at: FloatArray
    height: float


@dataclass(frozen=True, eq=False)
class Sheet:
    """All there is to draw; the lower left corner is at 0, 0."""

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

    Each seam has one number on both of its sides, at a notch in their middle. Creases are dashed fold
    lines. An arrow on each piece shows the grain, and a bar below has a known length. A PDF is tiled
    into pages, which overlap by a centimetre.

    Pieces of an `Atlas` that fit along a seam are one piece, and a slit whose sides lie on each other is
    none: a hole in a plate stays a hole. Seams that were given to `unwrap` stay. All pieces are turned so
    that their arrows point up.

    Parameters
    ----------
    path : path of an SVG, DXF or PDF file
        A unit of SVG and DXF is a millimetre.
    V : (#V, 3) float
    F : (#F, 3) int, or polygons
    atlas : Atlas, or (#V, 2) float
        What `unwrap` made of V and F, or a flat map. `method="isometric"` keeps lengths best.
    units : {"mm", "cm", "m", "in", "ft", "um"}, optional
        Of V; by default "mm". A file may say it: `read_file(path).units`. `units` of the pattern is what was
        taken.
    crease : float
        Degrees between neighbouring faces from which their edge is a fold line.
    grain : (3,) float
        Direction in space along which the arrows point. On a piece on which it points nowhere, the arrow
        lies along the piece.
    up : (3,) float, optional
        Direction in space that points up on the pieces; by default that of the grain. If it points nowhere
        on any piece, they lie across; a single flat piece has its sides upright.
    paper : {"A4", "A3", "A0", "letter"}
        Of a PDF.

    Returns
    -------
    Pattern
        The lines that were drawn. `print(pattern)` lists both lengths of each seam.

    Raises
    ------
    MeshError
        The suffix is unknown, or the arrays do not fit together.
    ValueError
        `units`, `grain`, `up` or `paper` is none of the above.
    ImportError
        The package that writes this format is missing; the text names the pip command.
    OSError
        The file cannot be written. In that case nothing is left behind.

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
        raise MeshError(f"{path} is no pattern file: use one that ends in {', '.join(WRITERS)}")
    if paper not in PAPERS:
        raise ValueError(f"paper is {paper!r}: use one of {', '.join(PAPERS)}")
    pattern = pattern_of(V, F, atlas, units, crease, grain, up)
    with writing_pattern(path, pattern, paper):
        return pattern


@contextmanager
def writing_pattern(path: str | os.PathLike[str], pattern: Pattern, paper: str) -> Iterator[None]:
    """Write a pattern; the file takes its place when the block succeeds. The suffix chooses the format."""
    with replacing(path) as temporary:
        WRITERS[Path(path).suffix.lower()](temporary, _sheet_of(pattern), PAPERS[paper])
        yield


def _sheet_of(pattern: Pattern) -> Sheet:
    """Outlines, marked seams, folds, arrows, names, and a bar of a known length below."""
    width, height = pattern.size
    text = float(np.clip(max(width, height) / 60, 0.5, 5.0))
    foot = 4 * text + MARGIN
    shift = np.array([MARGIN, MARGIN + foot])
    strokes = [Stroke(OUTLINE, line + shift, closed=True) for line in pattern.outlines]
    strokes += [Stroke(FOLD, fold + shift) for fold in pattern.folds]
    labels = []
    for seam in pattern.seams:
        small = float(np.clip(0.4 * min(seam.lengths), 0.3 * text, text))  # that neighbours do not touch
        for side, towards in zip(seam.sides, (1.0, 1.0 if seam.twisted else -1.0), strict=True):
            at, normal = _midpoint(side)
            notch = np.array([at, at + 0.8 * small * towards * normal])
            strokes.append(Stroke(SEAM, notch + shift))
            labels.append(Label(SEAM, str(seam.number), at + 1.6 * small * towards * normal + shift, small))
    for i, (tail, head) in enumerate(pattern.grain):
        strokes += [Stroke(GRAIN, line + shift) for line in _arrow(tail, head, text)]
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


def _midpoint(line: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The point in the middle of a line, by length, and the unit normal to its left there."""
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    reached = np.cumsum(step)
    k = min(int(np.searchsorted(reached, reached[-1] / 2)), len(step) - 1)
    share = (reached[-1] / 2 - reached[k] + step[k]) / max(step[k], np.finfo(float).tiny)
    along = (line[k + 1] - line[k]) / max(step[k], np.finfo(float).tiny)
    return line[k] + share * (line[k + 1] - line[k]), np.array([-along[1], along[0]])


def _arrow(tail: FloatArray, head: FloatArray, size: float) -> list[FloatArray]:
    along = (head - tail) / max(float(np.linalg.norm(head - tail)), np.finfo(float).tiny)
    aside = np.array([-along[1], along[0]])
    barb = np.array([head - size * (along + aside / 2), head, head - size * (along - aside / 2)])
    return [np.array([tail, head]), barb]


def _save_svg(path: str, sheet: Sheet, _: tuple[float, float]) -> None:
    svgwrite = import_optional("svgwrite", EXTRA)
    drawing = svgwrite.Drawing(
        path,
        size=(f"{sheet.width!r}mm", f"{sheet.height!r}mm"),
        viewBox=f"0 0 {sheet.width!r} {sheet.height!r}",
        debug=False,  # its checks of each number take longer than the rest
    )

    def downwards(points: FloatArray) -> list[tuple[float, float]]:
        return [(x, sheet.height - y) for x, y in points.tolist()]

    for layer, colour in COLOURS.items():
        group = drawing.g(id=layer, stroke=colour, fill="none", stroke_width=LINE_WIDTH)
        for stroke in sheet.strokes:
            if stroke.layer == layer:
                shape = drawing.polygon if stroke.closed else drawing.polyline
                dashes = {"stroke_dasharray": "3,2"} if layer in DASHED else {}
                group.add(shape(downwards(stroke.points), **dashes))
        drawing.add(group)
        texts = drawing.g(fill=colour, text_anchor="middle", font_family="sans-serif")
        for label in sheet.labels:
            if label.layer == layer:
                (x, y), size = downwards(label.at[None])[0], label.height
                texts.add(drawing.text(label.text, insert=(x, y + 0.35 * size), font_size=size))
        drawing.add(texts)
    drawing.save()


def _save_dxf(path: str, sheet: Sheet, _: tuple[float, float]) -> None:
    ezdxf = import_optional("ezdxf", EXTRA)
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
    """One page where the sheet fits on it, else tiles that overlap, with their row and column.

    Pages lie across where fewer of them do.
    """
    figures = import_optional("matplotlib.figure", EXTRA)
    pages = import_optional("matplotlib.backends.backend_pdf", EXTRA)
    paper = min((paper, paper[::-1]), key=lambda size: int(np.prod(_tiles(sheet, size))))
    free, (columns, rows) = np.array(paper) - 2 * MARGIN, _tiles(sheet, paper)
    with pages.PdfPages(path, metadata={"Creator": "igl_linabf", "CreationDate": None}) as file:
        for row in range(rows):
            for column in range(columns):
                corner = np.array([column, rows - 1 - row]) * (free - MARGIN)
                name = f"row {row + 1} of {rows}, column {column + 1} of {columns}"
                file.savefig(_page(figures, sheet, corner, free, paper, name))


def _tiles(sheet: Sheet, paper: tuple[float, float]) -> tuple[int, int]:
    """The columns and rows of pages of this size that a sheet takes."""
    columns, rows = (
        max(1, int(np.ceil((size - MARGIN) / (room - 3 * MARGIN) - 1e-9)))
        for size, room in zip((sheet.width, sheet.height), paper, strict=True)
    )
    return columns, rows


def _page(
    module: Any, sheet: Sheet, corner: FloatArray, free: FloatArray, paper: tuple[float, float], name: str
) -> Any:
    """A page of the sheet whose frame has its lower left corner at `corner`."""
    figure = module.Figure(figsize=(paper[0] / MILLIMETRES["in"], paper[1] / MILLIMETRES["in"]))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(corner[0] - MARGIN, corner[0] - MARGIN + paper[0])
    axes.set_ylim(corner[1] - MARGIN, corner[1] - MARGIN + paper[1])
    points = 72 / MILLIMETRES["in"]
    frame = import_optional("matplotlib.patches", EXTRA).Rectangle(
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
