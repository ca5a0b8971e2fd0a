"""Keep pinned texture coordinates unchanged, and pack all charts without pins beside them."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from .objects import CannotUnwrapError
from .scene import Part
from .surface import Surface

SAME_POINT = 1e-5  # maximum distance between pins that are considered equal, in the UV square
CELLS = 64  # cells per side of the page in the search for the largest empty rectangle
MIN_ROOM = 10  # minimum width of a rectangle for packing, in units of the margin, as `Packing` requires
MIN_SHARE = 0.5  # minimum texel density of charts without pins, relative to the pinned charts


def split_locked(part: Part) -> tuple[Part, Part]:
    """Return the faces whose UVs may change, and the faces of completely pinned UV islands."""
    if not part.pinned.any():
        return part, part.select(np.zeros(len(part.polygons), dtype=bool))
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    points = np.column_stack((part.corners.astype(np.float64), part.uv))
    point = np.unique(points, axis=0, return_inverse=True)[1].ravel()
    face = np.repeat(np.arange(len(part.polygons)), part.sizes)
    n = len(part.polygons) + int(point.max()) + 1
    graph = coo_array((np.ones(len(face)), (face, len(part.polygons) + point)), shape=(n, n))
    island = connected_components(graph, directed=False)[1][face]
    free = np.unique(island[~part.pinned])
    locked = ~np.isin(island[part.starts], free)
    return part.select(~locked), part.select(locked)


@dataclass(frozen=True)
class PinnedMap:
    """The texture coordinates of the atlas after charts with pins have been flattened again.

    Attributes
    ----------
    TC : (#TC, 2) float64, the new texture coordinates of the atlas
    fixed : (#charts,) bool, the charts with pins
    faulty : (#charts,) bool, the charts whose pins force flips or overlaps
    """

    TC: np.ndarray
    fixed: np.ndarray
    faulty: np.ndarray


def keep_pins(surface: Surface, atlas: Any, rows: np.ndarray, method: str) -> PinnedMap:
    """Flatten the charts with pinned corners again, with the pins fixed.

    `rows` has the row of `TC` at each corner.
    """
    pinned = surface.join("pinned")
    target, number = np.zeros(atlas.TC.shape), np.zeros(len(atlas.TC), dtype=bool)
    uv = surface.join("uv").astype(np.float64)[pinned]
    target[rows[pinned]], number[rows[pinned]] = uv, True
    apart = (np.abs(target[rows[pinned]] - uv) > SAME_POINT).any(axis=1)
    if apart.any():
        raise CannotUnwrapError(
            f"{np.count_nonzero(apart)} pins share a point with a pin at another position, because no seam "
            "separates them: mark the seam there, or unpin one side"
        )
    V, aspect = surface.join("V"), [1, atlas.report.aspect]
    TC, spans = atlas.TC.copy(), _list_chart_ranges(atlas)
    fixed, faulty = np.zeros((2, len(spans)), dtype=bool)
    for i, (a, b) in enumerate(spans):
        pins = np.flatnonzero(number[a:b])
        if not len(pins):
            continue
        fixed[i], goal = True, target[a:b][pins]
        if len(pins) == b - a:
            TC[a:b] = goal
        elif len(pins) == 1:
            TC[a:b] += goal - TC[a:b][pins]
        else:
            uv, faulty[i] = _flatten_pinned(
                V[atlas.origin[a:b]], atlas.charts[i], pins, goal * aspect, method
            )
            TC[a:b] = uv / aspect
    return PinnedMap(TC, fixed, faulty)


def _list_chart_ranges(atlas: Any) -> list[tuple[int, int]]:
    """Return the range of rows of `TC` of each chart: the first row, and the end (exclusive)."""
    ends = np.cumsum([0, *(len(chart.result.uv) for chart in atlas.charts)])
    return list(pairwise(ends.tolist()))


def _flatten_pinned(
    V: np.ndarray, chart: Any, pins: np.ndarray, goal: np.ndarray, method: str
) -> tuple[np.ndarray, bool]:
    """Return the map of a chart with pins, and whether it has flips or overlaps."""
    from igl_linabf import MeshError, OutcomeWarning, flatten, overlaps

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OutcomeWarning)  # the caller reports flips and overlaps
            result = flatten(V, chart.result.F, pins, goal, method=method, progress=False)
    except MeshError as error:
        raise CannotUnwrapError(f"a chart with {len(pins)} pins cannot be flattened: {error}") from None
    uv = result.uv.copy()
    uv[pins] = goal
    return uv, bool(len(result.flipped) or len(overlaps(uv, chart.result.F)))


def pack_beside(
    surface: Surface, atlas: Any, pinned: PinnedMap, rows: np.ndarray, locked: list[Part], settings: Any
) -> bool:
    """Pack the charts without pins into the largest empty rectangle beside the pinned charts, in place.

    The packed charts get the requested texel density (by default, the density of the pinned charts), or a
    smaller density if the rectangle is small. Return True if the charts do not fit and are placed on the next
    UDIM tile.
    """
    free = [
        chart.result.F + start
        for chart, (start, _), fixed in zip(
            atlas.charts, _list_chart_ranges(atlas), pinned.fixed, strict=True
        )
        if not fixed
    ]
    if not free:
        return False
    triangles = np.concatenate(free)
    V, size = (
        surface.join("V")[atlas.origin],
        np.array([settings.resolution, settings.height or settings.resolution]),
    )
    boxes, density = _measure_fixed(surface, atlas, pinned, rows, locked)
    wanted = settings.texel_density / size[0] if settings.texel_density else density
    corner, share = find_empty_rectangle(boxes, settings.margin / 2 / size)
    texels = np.floor(share * size).astype(int)
    packed = _pack_charts(V, triangles, atlas.TC * size, texels, settings.margin)
    beside = packed is not None and packed[1] >= MIN_SHARE * wanted * size[0]
    if not beside:
        corner, packed = (
            np.array([1.0, 0.0]),
            _pack_charts(V, triangles, atlas.TC * size, size, settings.margin),
        )
    uv, scale = packed
    pinned.TC[triangles.ravel()] = corner + uv * min(1.0, wanted * size[0] / scale) / size
    return not beside


def _pack_charts(
    V: np.ndarray, F: np.ndarray, uv: np.ndarray, texels: np.ndarray, margin: int
) -> tuple[np.ndarray, float] | None:
    """Pack charts into a rectangle; return the corners of triangles in texels, and texels per unit of length.

    Return None if the rectangle is too small for the margins.
    """
    from igl_linabf import Packing
    from igl_linabf.uv import pack

    if texels.min() < max(MIN_ROOM * margin, 1):
        return None
    packing = Packing(resolution=(int(texels[0]), int(texels[1])), padding=margin)
    packed = pack(V, F, uv / texels, F, packing)
    return packed.TC[packed.FTC.ravel()] * texels, packed.scale * texels[0]


def _measure_fixed(
    surface: Surface, atlas: Any, pinned: PinnedMap, rows: np.ndarray, locked: list[Part]
) -> tuple[np.ndarray, float]:
    """Return the bounding boxes of the pinned faces, (#f, 2, 2), and their density.

    The density is the number of page widths per unit of length; it is infinite if the faces have no area in
    the map or in space.
    """
    fixed = np.isin(np.asarray(atlas.chart), np.flatnonzero(pinned.fixed))
    own = zip(surface.split_corners(pinned.TC[rows]), surface.split_faces(fixed), strict=True)
    kept = [(part.select(chosen), uv[np.repeat(chosen, part.sizes)]) for (part, uv), (_, chosen) in own]
    kept += [(part, part.uv.astype(np.float64)) for part in locked]
    kept = [(part, uv) for part, uv in kept if len(uv)]
    boxes = [
        np.stack([f.reduceat(uv, part.starts) for f in (np.minimum, np.maximum)], axis=1) for part, uv in kept
    ]
    flat = sum(_measure_area(part, uv * [1, atlas.report.aspect]) for part, uv in kept)
    area = sum(_measure_area(part, part.V[part.corners]) for part, _ in kept)
    density = float(np.sqrt(flat / area)) if flat > 0 and area > 0 else np.inf
    return np.concatenate(boxes), density


def _measure_area(part: Part, points: np.ndarray) -> float:
    """Return the area of the faces of a part whose corners are at the given 2D or 3D points."""
    first, second = (np.pad(p, ((0, 0), (0, 3 - p.shape[1]))) for p in (points, points[part.next_corners]))
    doubled = np.add.reduceat(np.cross(first, second), part.starts)
    return float(np.linalg.norm(doubled, axis=1).sum() / 2)


def find_empty_rectangle(boxes: np.ndarray, margin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower left corner and the size of the largest empty rectangle between boxes in a square.

    If a rectangle is longer than twice its width, only the area of a part with that shape is counted.
    """
    low = np.clip(np.floor((boxes[:, 0] - margin) * CELLS), 0, CELLS).astype(int)
    high = np.clip(np.ceil((boxes[:, 1] + margin) * CELLS), 0, CELLS).astype(int)
    covered = np.zeros((CELLS + 1, CELLS + 1), dtype=int)  # second differences of the counts, summed below
    for i, j, sign in ((low, low, 1), (low, high, -1), (high, low, -1), (high, high, 1)):
        np.add.at(covered, (i[:, 0], j[:, 1]), sign)
    below = np.pad((covered.cumsum(0).cumsum(1)[:CELLS, :CELLS] > 0).cumsum(1), ((0, 0), (1, 0)))
    best, found = 0.0, (np.zeros(2), np.zeros(2))
    for bottom in range(CELLS):
        for top in range(bottom + 1, CELLS + 1):
            blocked = np.flatnonzero(below[:, top] > below[:, bottom])
            ends = np.concatenate(([-1], blocked, [CELLS]))
            longest = int(np.argmax(np.diff(ends)))
            width, height = int(np.diff(ends)[longest]) - 1, top - bottom
            worth = min(width, 2 * height) * min(height, 2 * width)
            if worth > best:
                best = worth
                found = np.array([ends[longest] + 1, bottom]) / CELLS, np.array([width, height]) / CELLS
    return found
