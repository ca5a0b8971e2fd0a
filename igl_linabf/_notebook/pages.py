"""Format results as HTML tables, and maps as small SVG pictures."""

from collections.abc import Iterable, Sequence
from html import escape
from itertools import groupby

import numpy as np

from .._types import FloatArray, IntArray
from ..errors import escape_control_characters
from ..surface import NEXT, PREV, cycles

PICTURE_SIDE = 260  # length of a picture's longer side, pixels
MAX_DRAWN_TRIANGLES = 2_000  # larger maps show only the outlines of charts
MAX_DRAWN_CHARTS = MAX_DRAWN_TRIANGLES // 4  # in SVG, an outline takes about as much text as four triangles
COLOURS = ("#4c78a8", "#f58518", "#54a24b", "#b279a2", "#e45756", "#72b7b2", "#9d755d", "#bab0ac")


def format_html_table(rows: Sequence[Sequence[str]], header: bool = True) -> str:
    """Format rows as an HTML table; with `header`, the first row is the header of right-aligned columns."""
    lines = []
    for i, row in enumerate(rows):
        tag = "th" if header and i == 0 else "td"
        sides = ["left", *["right" if header else "left"] * (len(row) - 1)]
        cells = (
            f'<{tag} style="text-align: {side}">{escape(escape_control_characters(cell))}</{tag}>'
            for side, cell in zip(sides, row, strict=True)
        )
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def arrange_html_row(parts: Iterable[tuple[str, str]]) -> str:
    """Arrange blocks of HTML, given as (title, content), side by side with their titles above them."""
    blocks = []
    for title, content in parts:
        head = f"<div>{escape(escape_control_characters(title))}</div>" if title else ""
        blocks.append(f'<div style="margin: 0 1em 0.5em 0">{head}{content}</div>')
    return f'<div style="display: flex; flex-wrap: wrap; align-items: flex-start">{"".join(blocks)}</div>'


def draw_map_as_svg(uv: FloatArray, F: IntArray, piece: IntArray | None = None) -> str:
    """Draw the outlines of a map, and its triangles if there are at most `MAX_DRAWN_TRIANGLES`.

    Parameters
    ----------
    uv : (#V, 2) float64
        The map; NaN at vertices that no face uses.
    F : (#F, 3) int64
    piece : (#F,) int64, optional
        The chart of each face, which determines its colour; by default, all faces are one chart.
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
    at = np.column_stack((uv[:, 0] - low[0], high[1] - uv[:, 1])) * scale + 2  # SVG's y axis points down
    drawn = [
        f'<path d="{_format_closed_path(at, loops)}" fill="{COLOURS[i % len(COLOURS)]}" fill-opacity="0.35" '
        f'fill-rule="evenodd" stroke="#333" stroke-width="0.8"/>'
        for i, loops in _find_chart_loops(F, piece)
    ]
    if len(F) <= MAX_DRAWN_TRIANGLES:
        triangles = _format_closed_path(at, F.tolist())
        drawn.append(f'<path d="{triangles}" fill="none" stroke="#333" stroke-width="0.25"/>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.1f} {height:.1f}" role="img" aria-label="the flat map">{"".join(drawn)}</svg>'
    )


def _find_chart_loops(F: IntArray, piece: IntArray) -> list[tuple[int, list[list[int]]]]:
    """Return the boundary loops of each chart, up to `MAX_DRAWN_CHARTS` charts with the most faces."""
    tail, head, of = F[:, NEXT].ravel(), F[:, PREV].ravel(), np.repeat(piece, 3)
    n = int(F.max()) + 1
    single = ~np.isin(tail * n + head, head * n + tail)
    tail, head, of = tail[single], head[single], of[single]
    # if loops touch at a vertex, any continuation gives the same outline under the even-odd fill rule
    following = np.empty(len(tail), np.int64)
    following[np.lexsort((head, of))] = np.lexsort((tail, of))
    loops: dict[int, list[list[int]]] = {}
    for loop in cycles(following):
        loops.setdefault(int(of[loop[0]]), []).append(tail[loop].tolist())
    largest = np.argsort(-np.bincount(piece), kind="stable")[:MAX_DRAWN_CHARTS]
    return [(int(i), loops[i]) for i in sorted(largest.tolist()) if i in loops]


def _format_closed_path(at: FloatArray, loops: list[list[int]]) -> str:
    """Format closed polygons as an SVG path, in tenths of pixels."""
    text = []
    for loop in loops:
        points = [f"{x:.1f} {y:.1f}" for x, y in at[loop]]
        text.append(f"M{'L'.join(point for point, _ in groupby(points))}Z")
    return "".join(text)
