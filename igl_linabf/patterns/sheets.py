"""Draw a pattern on a sheet: lines and texts in millimetres, independent of the file format."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .._types import FloatArray
from ..surface import normalize_vectors
from .folds import join_segments
from .pattern import Pattern

MARGIN = 10.0  # margin of the sheet and of each page, and overlap of pages, in mm
BAR_LENGTHS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # possible lengths of the scale bar, in mm
MIN_SAMPLE = 17.0  # minimum length of a line in the legend, in mm: two periods of each dash pattern
LETTER_WIDTH = 0.6  # mean width of a letter, relative to the height of the text

OUTLINE, SEWING, TAB, MOUNTAIN, VALLEY = "outline", "sewing", "tab", "mountain", "valley"
SEAM, GRAIN, TEXT, LEGEND = "seam", "grain", "text", "legend"


@dataclass(frozen=True)
class LineStyle:
    """The appearance of a layer.

    Attributes
    ----------
    colour : str
    dashes : tuple of float
        Lengths of dashes and gaps in turn, in millimetres; empty for a continuous line.
    """

    colour: str
    dashes: tuple[float, ...] = ()


STYLES = {
    OUTLINE: LineStyle("#000000"),
    SEWING: LineStyle("#707070", (1.5, 1.0)),
    TAB: LineStyle("#707070", (0.5, 1.0)),
    SEAM: LineStyle("#c02020"),
    MOUNTAIN: LineStyle("#c06000", (5.0, 1.0, 1.0, 1.0)),
    VALLEY: LineStyle("#2050c0", (3.0, 2.0)),
    GRAIN: LineStyle("#208040"),
    TEXT: LineStyle("#000000"),
    LEGEND: LineStyle("#000000"),
}


@dataclass(frozen=True, eq=False)
class Stroke:
    """A polyline through points (n, 2), open or closed.

    A line in the legend has the style of the layer `sample_of`.
    """

    layer: str
    points: FloatArray
    closed: bool = False
    sample_of: str | None = None

    @property
    def style(self) -> LineStyle:
        """The appearance of the line."""
        return STYLES[self.sample_of or self.layer]


@dataclass(frozen=True, eq=False)
class Label:
    """A text centred at a point, or to the right of it."""

    layer: str
    text: str
    at: FloatArray
    height: float
    centred: bool = True


@dataclass(frozen=True, eq=False)
class Sheet:
    """All lines and texts of a drawing, whose lower left corner is at (0, 0)."""

    width: float
    height: float
    strokes: tuple[Stroke, ...]
    labels: tuple[Label, ...]


def build_sheet(pattern: Pattern) -> Sheet:
    """Return a sheet with the pieces and their marks, a scale bar and a legend."""
    width, height = pattern.size
    text = float(np.clip(max(width, height) / 60, 0.5, 5.0))
    strokes, labels = _draw_pieces(pattern, text)
    legend, legend_labels, legend_width = _draw_legend(pattern, {s.layer for s in strokes}, text)
    foot = (4 + 2 * len(legend_labels)) * text + MARGIN
    shift = np.array([MARGIN, MARGIN + foot])
    strokes = [replace(stroke, points=stroke.points + shift) for stroke in strokes]
    labels = [replace(label, at=label.at + shift) for label in labels]
    longest = 0.6 * max(width, 10 * text)
    bar = max((length for length in BAR_LENGTHS if length <= longest), default=BAR_LENGTHS[0])
    left, base = MARGIN, MARGIN + 1.5 * text
    ends = [np.array([[x, base - text / 2], [x, base + text / 2]]) for x in (left, left + bar)]
    rule = np.array([[left, base], [left + bar, base]])
    strokes += [*(Stroke(TEXT, line) for line in (rule, *ends)), *legend]
    labels += [
        Label(TEXT, f"{bar:g} mm", np.array([left + bar / 2, base + 1.2 * text]), text),
        *legend_labels,
    ]
    whole = max(width, bar, 12 * text, legend_width) + 2 * MARGIN
    return Sheet(whole, height + foot + 2 * MARGIN, tuple(strokes), tuple(labels))


def _draw_pieces(pattern: Pattern, text: float) -> tuple[list[Stroke], list[Label]]:
    """Return outlines, sewing lines, tabs, folds, seam marks, arrows and names of the pieces."""
    strokes = [Stroke(OUTLINE, line, closed=True) for line in pattern.cut_lines]
    if pattern.report.allowance:
        strokes += [Stroke(SEWING, line, closed=True) for line in pattern.outlines]
    strokes += [
        Stroke(_choose_layer_of_tab(tab.angle, pattern.report.crease), tab.base) for tab in pattern.tabs
    ]
    for layer, kind in ((MOUNTAIN, pattern.fold_angles > 0), (VALLEY, pattern.fold_angles <= 0)):
        strokes += [Stroke(layer, line) for line in join_segments(pattern.folds[kind])]
    labels = []
    for seam in pattern.seams:
        small = float(
            np.clip(0.4 * min(seam.lengths), 0.3 * text, text)
        )  # smaller on short seams, so that neighbouring labels do not overlap
        for side, towards in zip(seam.sides, (1.0, 1.0 if seam.twisted else -1.0), strict=True):
            at, normal = _find_midpoint(side)
            inward = towards * normal
            strokes.append(
                Stroke(SEAM, np.array([at - pattern.report.allowance * inward, at + 0.8 * small * inward]))
            )
            labels.append(Label(SEAM, str(seam.number), at + 1.6 * small * inward, small))
    for i, (tail, head) in enumerate(pattern.grain):
        strokes += [Stroke(GRAIN, line) for line in _draw_arrow(tail, head, text)]
        labels.append(Label(TEXT, f"piece {i}", 0.4 * tail + 0.6 * head + [0, 1.5 * text], text))
    return strokes, labels


def _choose_layer_of_tab(angle: float, crease: float) -> str:
    """Return the layer of the base of a tab: a fold if the surface has a crease there."""
    if abs(angle) < crease:
        return TAB
    return MOUNTAIN if angle > 0 else VALLEY


def _draw_legend(pattern: Pattern, used: set[str], text: float) -> tuple[list[Stroke], list[Label], float]:
    """Return the lines and texts that explain the layers in use, from the bottom up, and their width."""
    meanings = {
        VALLEY: "valley fold: towards you",
        MOUNTAIN: "mountain fold: away from you",
        TAB: "edge of a glue tab, not to be cut",
        SEWING: "sewing line",
    }
    rows = []
    if pattern.report.compensation != (1, 1):
        factors = "enlarged by {:g} across and {:g} along the arrows".format(*pattern.report.compensation)
        rows.append(("", factors))
    rows += [(layer, meaning) for layer, meaning in meanings.items() if layer in used]
    if pattern.report.allowance:
        rows.append((OUTLINE, f"cutting line, with an allowance of {pattern.report.allowance:g} mm"))
    sample, strokes, labels = max(6 * text, MIN_SAMPLE), [], []
    for k, (layer, meaning) in enumerate(rows):
        at = np.array([MARGIN, MARGIN + (4.2 + 2 * k) * text])
        if layer:
            strokes.append(Stroke(LEGEND, at + np.array([[0, 0], [sample, 0]]), sample_of=layer))
        place = at + np.array([sample + text if layer else 0, 0])
        labels.append(Label(LEGEND, meaning, place, text, centred=False))
    widths = (sample + (1 + LETTER_WIDTH * len(meaning)) * text for _, meaning in rows)
    return strokes, labels, max(widths, default=0.0)


def _find_midpoint(line: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the point halfway along a line by length, and the unit normal to the left at this point."""
    step = np.diff(line, axis=0)
    length = np.linalg.norm(step, axis=1)
    reached = np.cumsum(length)
    k = int(np.searchsorted(reached, reached[-1] / 2))
    along = normalize_vectors(step[k])
    return line[k + 1] - (reached[k] - reached[-1] / 2) * along, np.array([-along[1], along[0]])


def _draw_arrow(tail: FloatArray, head: FloatArray, size: float) -> list[FloatArray]:
    """Return the two polylines of an arrow: its shaft and its head."""
    along = normalize_vectors(head - tail)
    aside = np.array([-along[1], along[0]])
    barb = np.array([head - size * (along + aside / 2), head, head - size * (along - aside / 2)])
    return [np.array([tail, head]), barb]
