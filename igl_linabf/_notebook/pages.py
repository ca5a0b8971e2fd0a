"""HTML tables, and maps as small pictures in SVG."""

from collections.abc import Iterable, Sequence
from html import escape
from itertools import groupby

import numpy as np

from .._types import FloatArray, IntArray
from ..surface import NEXT, PREV, cycles

# Pixels along the longer side of a picture. In fewer, triangles cannot be told apart; more fill the notebook.
# demos/ and tests/_notebook/test_pages.py make such pictures.
PICTURE_SIDE = 260

# Triangles that are drawn at most: their sides then have some eight pixels. Of more, only the outlines of the
# charts are drawn; of fewer, nobody needs the outlines alone (tests/_notebook/test_pages.py).
MOST_DRAWN_TRIANGLES = 2_000
MOST_DRAWN_CHARTS = MOST_DRAWN_TRIANGLES // 4  # an outline is as long as several triangles
COLOURS = ("#4c78a8", "#f58518", "#54a24b", "#b279a2", "#e45756", "#72b7b2", "#9d755d", "#bab0ac")


def html_table(rows: Sequence[Sequence[str]], header: bool = True) -> str:
    """A table; the first row is the header of columns of figures, if it has one."""
    lines = []
    for i, row in enumerate(rows):
        tag = "th" if header and i == 0 else "td"
        sides = ["left", *["right" if header else "left"] * (len(row) - 1)]
        cells = (
            f'<{tag} style="text-align: {side}">{escape(cell)}</{tag}>'
            for side, cell in zip(sides, row, strict=True)
        )
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def html_row(parts: Iterable[tuple[str, str]]) -> str:
    """Blocks of HTML in a row, each with its title above it."""
    blocks = [
        f'<div style="margin: 0 1em 0.5em 0">{f"<div>{escape(title)}</div>" if title else ""}{content}</div>'
        for title, content in parts
    ]
    return f'<div style="display: flex; flex-wrap: wrap; align-items: flex-start">{"".join(blocks)}</div>'


def map_svg(uv: FloatArray, F: IntArray, piece: IntArray | None = None) -> str:
    """A picture of a map: its outlines, and its triangles where they are few enough to be told apart.

    Parameters
    ----------
    uv : (#V, 2) float64
        NaN at vertices that no face uses.
    F : (#F, 3) int64
    piece : (#F,) int64, optional
        The chart of each face, which gives it its colour; one chart by default.
    """
    piece = np.zeros(len(F), np.int64) if piece is None else piece
    corners = uv[F]
    shown = np.isfinite(corners).all(axis=(1, 2))
    F, piece = F[shown], piece[shown]
    if not len(F):
        return ""
    low, high = corners[shown].min(axis=(0, 1)), corners[shown].max(axis=(0, 1))
    scale = (PICTURE_SIDE - 4) / max(float((high - low).max()), float(np.finfo(float).tiny))
    width, height = (high - low) * scale + 4
    at = np.column_stack((uv[:, 0] - low[0], high[1] - uv[:, 1])) * scale + 2  # v points up
    drawn = [
        f'<path d="{_closed_path(at, loops)}" fill="{COLOURS[i % len(COLOURS)]}" fill-opacity="0.35" '
        f'fill-rule="evenodd" stroke="#333" stroke-width="0.8"/>'
        for i, loops in _chart_loops(F, piece)
    ]
    if len(F) <= MOST_DRAWN_TRIANGLES:
        triangles = _closed_path(at, F.tolist())
        drawn.append(f'<path d="{triangles}" fill="none" stroke="#333" stroke-width="0.25"/>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.1f} {height:.1f}" role="img" aria-label="the flat map">{"".join(drawn)}</svg>'
    )


def _chart_loops(F: IntArray, piece: IntArray) -> list[tuple[int, list[list[int]]]]:
    """The boundary loops of each chart; of thousands of charts, those of the ones with the most faces."""
    tail, head, of = F[:, NEXT].ravel(), F[:, PREV].ravel(), np.repeat(piece, 3)
    n = int(F.max()) + 1
    single = ~np.isin(tail * n + head, head * n + tail)
    tail, head, of = tail[single], head[single], of[single]
    # where loops touch at a vertex, any way through it gives the same outline, filled by even and odd
    following = np.empty(len(tail), np.int64)
    following[np.lexsort((head, of))] = np.lexsort((tail, of))
    loops: dict[int, list[list[int]]] = {}
    for loop in cycles(following):
        loops.setdefault(int(of[loop[0]]), []).append(tail[loop].tolist())
    largest = np.argsort(-np.bincount(piece), kind="stable")[:MOST_DRAWN_CHARTS]
    return [(int(i), loops[i]) for i in sorted(largest.tolist()) if i in loops]


def _closed_path(at: FloatArray, loops: list[list[int]]) -> str:
    """The path of closed polygons, in tenths of pixels."""
    text = []
    for loop in loops:
        points = [f"{x:.1f} {y:.1f}" for x, y in at[loop]]
        text.append(f"M{'L'.join(point for point, _ in groupby(points))}Z")
    return "".join(text)
