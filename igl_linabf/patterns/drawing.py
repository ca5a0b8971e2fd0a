"""A pattern as lines and texts on a sheet, in millimetres, whatever file it goes to."""

from dataclasses import dataclass

import numpy as np

from .._types import FloatArray
from .pieces import Pattern

MARGIN = 10.0  # around the pieces
OUTLINE, SEAM, FOLD, TEXT, GRAIN = "outline", "seam", "fold", "text", "grain"
COLOURS = {OUTLINE: "#000000", SEAM: "#c02020", FOLD: "#2050c0", TEXT: "#000000", GRAIN: "#208040"}
DASHED = {FOLD}
NICE = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # lengths of the bar


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


def sheet_of(pattern: Pattern) -> Sheet:
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
            at, normal = _middle(side)
            notch = np.array([at, at + 0.8 * small * towards * normal])
            strokes.append(Stroke(SEAM, notch + shift))
            labels.append(Label(SEAM, str(seam.number), at + 1.6 * small * towards * normal + shift, small))
    for i, (tail, head) in enumerate(pattern.grain):
        strokes += [Stroke(GRAIN, line + shift) for line in _arrow(tail, head, text)]
        labels.append(Label(TEXT, f"piece {i}", 0.4 * tail + 0.6 * head + shift + [0, 1.5 * text], text))
    bar = float(max((length for length in NICE if length <= 0.6 * max(width, 10 * text)), default=NICE[0]))
    left, base = MARGIN, MARGIN + 1.5 * text
    ends = [np.array([[x, base - text / 2], [x, base + text / 2]]) for x in (left, left + bar)]
    rule = np.array([[left, base], [left + bar, base]])
    strokes += [Stroke(TEXT, line) for line in (rule, *ends)]
    labels.append(Label(TEXT, f"{bar:g} mm", np.array([left + bar / 2, base + 1.2 * text]), text))
    whole = max(width, bar, 12 * text) + 2 * MARGIN
    return Sheet(whole, height + foot + 2 * MARGIN, tuple(strokes), tuple(labels))


def _middle(line: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The point in the middle of a line, by length, and the unit normal to its left there."""
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    reached = np.cumsum(step)
    k = min(int(np.searchsorted(reached, reached[-1] / 2)), len(step) - 1)
    share = (reached[-1] / 2 - reached[k] + step[k]) / max(step[k], 1e-300)
    along = (line[k + 1] - line[k]) / max(step[k], 1e-300)
    return line[k] + share * (line[k + 1] - line[k]), np.array([-along[1], along[0]])


def _arrow(tail: FloatArray, head: FloatArray, size: float) -> list[FloatArray]:
    along = (head - tail) / max(float(np.linalg.norm(head - tail)), 1e-300)
    aside = np.array([-along[1], along[0]])
    barb = np.array([head - size * (along + aside / 2), head, head - size * (along - aside / 2)])
    return [np.array([tail, head]), barb]
