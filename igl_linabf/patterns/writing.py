"""Write patterns: SVG by svgwrite, DXF by ezdxf, PDF by matplotlib."""

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
from ..errors import MeshError
from ..io import needed, replacing
from .drawing import COLOURS, DASHED, Sheet, sheet_of
from .pieces import Pattern, pattern_of

PAPERS = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "A0": (841.0, 1189.0), "letter": (215.9, 279.4)}
OVERLAP = 10.0  # of neighbouring pages, and the frame around what is printed on each
INCH = 25.4
WIDTH = 0.25  # of lines
EXTRA = "patterns need pip install 'igl-linabf[patterns]'"

Units = Literal["mm", "cm", "m", "in"]


def write_pattern(
    path: str | os.PathLike[str],
    V: ArrayLike,
    F: ArrayLike,
    atlas: Atlas | ArrayLike,
    units: Units = "mm",
    *,
    crease: float = 30.0,
    grain: ArrayLike = (0.0, 0.0, 1.0),
    paper: str = "A4",
) -> Pattern:
    """Write the pieces of a flattened surface at true scale, to be cut out and joined.

    Each seam has one number on both of its sides, at a notch in their middle. Creases are dashed fold
    lines. An arrow on each piece shows the grain, and a bar below has a known length. A PDF is tiled
    into pages, which overlap by a centimetre.

    Parameters
    ----------
    path : path of an SVG, DXF or PDF file
        A unit of SVG and DXF is a millimetre.
    V : (#V, 3) float
    F : (#F, 3) int, or polygons
    atlas : Atlas, or (#V, 2) float
        What `unwrap` made of V and F, or a flat map. `method="isometric"` keeps lengths best.
    units : {"mm", "cm", "m", "in"}
        Of V.
    crease : float
        Degrees between neighbouring faces from which their edge is a fold line.
    grain : (3,) float
        Direction in space along which the arrows point.
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
        `units`, `grain` or `paper` is none of the above.
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
    (1, 5, 5)
    >>> bool(pattern.error < 1e-6)
    True
    """
    path = Path(path)
    if path.suffix.lower() not in WRITERS:
        raise MeshError(f"{path} is no pattern file: use one that ends in {', '.join(WRITERS)}")
    if paper not in PAPERS:
        raise ValueError(f"paper is {paper!r}: use one of {', '.join(PAPERS)}")
    pattern = pattern_of(V, F, atlas, units, crease, grain)
    with drawn(path, pattern, paper):
        return pattern


@contextmanager
def drawn(path: str | os.PathLike[str], pattern: Pattern, paper: str) -> Iterator[None]:
    """Write a pattern; the file takes its place when the block succeeds. The suffix chooses the format."""
    with replacing(path) as temporary:
        WRITERS[Path(path).suffix.lower()](temporary, sheet_of(pattern), PAPERS[paper])
        yield


def _save_svg(path: str, sheet: Sheet, _: tuple[float, float]) -> None:
    svgwrite = needed("svgwrite", EXTRA)
    drawing = svgwrite.Drawing(
        path,
        size=(f"{sheet.width!r}mm", f"{sheet.height!r}mm"),
        viewBox=f"0 0 {sheet.width!r} {sheet.height!r}",
        debug=False,  # its checks of each number take longer than the rest
    )

    def downwards(points: FloatArray) -> list[tuple[float, float]]:
        return [(x, sheet.height - y) for x, y in points.tolist()]

    for layer, colour in COLOURS.items():
        group = drawing.g(id=layer, stroke=colour, fill="none", stroke_width=WIDTH)
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
    ezdxf = needed("ezdxf", EXTRA)
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
    """One page where the sheet fits on it, else tiles that overlap, with their row and column."""
    figures, pages = (needed(f"matplotlib.{name}", EXTRA) for name in ("figure", "backends.backend_pdf"))
    free = np.array(paper) - 2 * OVERLAP
    if sheet.width > sheet.height and (sheet.width > free[0]):
        free, paper = free[::-1], (paper[1], paper[0])
    columns, rows = (max(1, int(np.ceil((size - OVERLAP) / (room - OVERLAP) - 1e-9)))
                     for size, room in zip((sheet.width, sheet.height), free, strict=True))  # fmt: skip
    with pages.PdfPages(path, metadata={"Creator": "igl_linabf", "CreationDate": None}) as file:
        for row in range(rows):
            for column in range(columns):
                corner = np.array([column, rows - 1 - row]) * (free - OVERLAP)
                name = f"row {row + 1} of {rows}, column {column + 1} of {columns}"
                file.savefig(_page(figures, sheet, corner, free, paper, name))


def _page(
    module: Any, sheet: Sheet, corner: FloatArray, free: FloatArray, paper: tuple[float, float], name: str
) -> Any:
    """A page of the sheet whose frame has its lower left corner at `corner`."""
    figure = module.Figure(figsize=(paper[0] / INCH, paper[1] / INCH))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(corner[0] - OVERLAP, corner[0] - OVERLAP + paper[0])
    axes.set_ylim(corner[1] - OVERLAP, corner[1] - OVERLAP + paper[1])
    points = 72 / INCH
    frame = needed("matplotlib.patches", EXTRA).Rectangle(
        (corner[0], corner[1]), *free, fill=False, linewidth=0.5, edgecolor="#888888"
    )
    axes.add_patch(frame)
    for stroke in sheet.strokes:
        line = np.vstack((stroke.points, stroke.points[:1])) if stroke.closed else stroke.points
        if (line.max(axis=0) < corner).any() or (line.min(axis=0) > corner + free).any():
            continue
        style = (0, (6, 4)) if stroke.layer in DASHED else "-"
        (drawn,) = axes.plot(*line.T, color=COLOURS[stroke.layer], linewidth=WIDTH * points, linestyle=style)
        drawn.set_clip_path(frame)
    for label in sheet.labels:
        if (label.at >= corner).all() and (label.at <= corner + free).all():
            axes.text(*label.at, label.text, fontsize=label.height * points, color=COLOURS[label.layer],
                      ha="center", va="center")  # fmt: skip
    axes.text(corner[0], corner[1] - OVERLAP / 2, name, fontsize=8, va="center")
    return figure


WRITERS: dict[str, Callable[[str, Sheet, tuple[float, float]], None]] = {
    ".svg": _save_svg,
    ".dxf": _save_dxf,
    ".pdf": _save_pdf,
}
PATTERN_SUFFIXES = tuple(WRITERS)
