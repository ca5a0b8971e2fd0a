"""What the angles draw around holes and along closed paths."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .. import _core
from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..surface import Parts, Topology


@dataclass(frozen=True, eq=False)
class ClosedPath:
    """A closed path of edges, along which scale and direction are to come back.

    The path's *left fans* are the corners to its left at its vertices. Over them the logarithms of the
    next edge's length over the last one's sum to zero, so the path ends at the scale at which it
    begins. The exterior angles, pi - the sum of the left fan, sum to `turning`.

    Attributes
    ----------
    corner : (#c,) int64
        The corners of the left fans, numbered k #F + t.
    size : int
        Number of the path's vertices.
    turning : float
        Sum of the exterior angles, radians; NaN if it may be any.
    """

    corner: IntArray
    size: int
    turning: float = np.nan


@dataclass(frozen=True, eq=False)
class Closure:
    """By how much loops and closed paths drawn from the angles fail to close (docs/holes.md).

    Loops of holes: first the exterior angles are shifted to sum to -2 pi, and the logarithms of the
    length ratios to sum to 0, evenly over a loop. The derivative is averaged over all starting
    vertices, so the result does not depend on the start.

    Attributes
    ----------
    gap : (#holes + #paths,) complex128
        For each hole tau: vector from the start to the end of its loop, in units of its length. For
        each path the sum of the logarithms + i (sum of the exterior angles - `turning`).
    site, row : (#L,) int64
        The *sites* of all these, and the entry of `gap` that each adds to. Site v is vertex v; after
        the vertices come the paths.
    q : (#L,) complex128
        Derivative of the gap with respect to log_ratio + i turning at the site. At a hole's vertex it
        is the vector from the vertex to the loop's end, minus its mean over the loop; at a path it
        is 1.
    asked : (#holes + #paths, 2) bool
        Whether the real and the imaginary part of each gap is to vanish.
    """

    gap: ComplexArray
    site: IntArray
    row: IntArray
    q: ComplexArray
    asked: BoolArray

    def of_paths(self, n: int) -> Closure:
        """Only that of the paths, the last `n`."""
        asked = self.asked.copy()
        asked[: len(asked) - n] = False
        return replace(self, asked=asked)


def closure_of(
    topology: Topology,
    turning: FloatArray,
    log_ratio: FloatArray,
    paths: tuple[ClosedPath, ...] = (),
    drawn: ComplexArray | None = None,
) -> Closure:
    """Draw each hole's loop; `turning` and `log_ratio` as in `Residual`.

    `drawn` has the sum of the logarithms + i angles over the left fans of each path.
    """
    holes = topology.holes
    if not holes and not paths:
        none, nowhere = np.empty(0, dtype=np.complex128), np.empty(0, dtype=np.int64)
        return Closure(none, nowhere, nowhere, none, np.empty((0, 2), dtype=bool))
    parts = Parts.of_sizes([len(loop) for loop in holes])
    site = np.concatenate((*holes, topology.n + np.arange(len(paths))))
    gap, q = _core.drawn_loops(site[: parts.start[-1]], parts.start, turning, log_ratio)
    asked = np.ones((len(holes) + len(paths), 2), dtype=bool)
    if paths:
        assert drawn is not None
        wanted = np.array([path.size * np.pi - path.turning for path in paths])
        asked[len(holes) :, 1] = ~np.isnan(wanted)
        beyond = np.where(np.isnan(wanted), 0.0, wanted - drawn.imag)
        gap = np.concatenate((gap, drawn.real + 1j * beyond))
        q = np.append(q, np.ones(len(paths)))
    row = np.repeat(np.arange(len(gap)), np.append(parts.sizes, np.ones(len(paths), dtype=np.int64)))
    return Closure(gap, site, row, q, asked)
