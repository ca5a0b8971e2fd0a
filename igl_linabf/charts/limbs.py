"""Charts cut further for their pages: those larger than a page, and those of many limbs where that pays.

Charts that cover a share f of a page need 1 / f as many texels as they use. `trade` is the seam length that
lowering this by one is worth, as it is for the L2 stretch. The parts keep the chart's map, each at the scale
of its own area: so what is packed is what was tried.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import BoolArray, FloatArray, IntArray
from ..measures import overlapping_pairs_of_chart, quality_of
from ..surface import Parts, Submesh, centres, complex_positions, connected_labels
from .atlas import Chart
from .packing import Wish, expected_fill
from .pieces import cut_out, of_own_size, on_part
from .shelves import narrowest_turns

MOST_CUTS, MOST_IDLE = 8, 1  # of all cuts, and of those in a row that do not pay yet
DIRECTIONS, OFFSETS = 8, 7  # of the lines that are tried
TRIED = 4  # of them are packed
LOOSE = 1.25  # of the area of their convex hulls is what charts take on a page
SHORTEST = 0.7  # of a chart's diameter is the side of a page that has room for it
GRID = 64  # squares along a chart, of which connected cells are taken as one to look for lines
BAND = 0.04  # of the chart's width: within it the shortest seam is sought
MIDDLE = 0.15  # the same, where a chart is halved that is larger than a page
FITS = 0.98  # of a page's side is what cells of a grid leave to a chart
OUTWARDS = np.stack((np.cos(np.pi / 16 * np.arange(32)), np.sin(np.pi / 16 * np.arange(32))))
UNITS = 1 << 20  # of length: flows are integers


@dataclass(frozen=True, eq=False)
class Flat:
    """A chart with its map.

    Attributes
    ----------
    piece : Submesh
    uv : (#V, 2) float64
    parent : int
        The chart that it is a part of.
    """

    piece: Submesh
    uv: FloatArray
    parent: int


Charts = list[tuple[Chart, Submesh]]  # each with its piece of the surface


def cut_for_fill(done: Charts, wish: Wish, trade: float) -> Charts:
    """The charts, some of them cut along short seams, one after the other.

    One cut alone may not pay where two do: so some more are tried before the best ones so far are taken.
    """

    def filled(tried: list[Flat]) -> float:
        return expected_fill([(chart.uv, chart.piece.F) for chart in tried], wish)

    charts = _flat(done)
    fill = filled(charts)
    chosen, most, worth, idle = charts, 0.0, 0.0, 0
    for _ in range(MOST_CUTS):
        best: tuple[float, float, list[Flat]] | None = None
        for k, label, seam in _promising(charts, fill, trade):
            parts = _parts(charts[k], label)
            if len(parts) < 2:
                continue
            after = [*charts[:k], *parts, *charts[k + 1 :]]
            then = filled(after)
            gain = trade * (1 / fill - 1 / then) - seam
            if best is None or gain > best[0]:
                best = gain, then, after
        if best is None or idle > MOST_IDLE:
            break
        gain, fill, charts = best
        worth, idle = worth + gain, idle + 1
        if worth > most:
            chosen, most, idle = charts, worth, 0
    return _parted(done, chosen)


def cut_to_fit(done: Charts, wish: Wish) -> Charts:
    """Charts that fit on pages of the side that is asked for: larger ones are halved along short seams."""
    assert wish.side is not None
    most = FITS * wish.side * wish.spacing.inner
    waiting, small = _flat(done), list[Flat]()
    while waiting:
        chart = waiting.pop()
        z = complex_positions(chart.uv)
        turn = narrowest_turns(z, Parts.of_sizes([len(z)]))[0]
        wide, high = np.ptp((z * turn).real), np.ptp((z * turn).imag)
        along = (complex_positions(_centres(chart)) * (turn if wide > high else 1j * turn)).real
        longest = max(wide, high)
        if longest > most:
            along -= (along.min() + along.max()) / 2
            parts = _parts(chart, _shortest_between(along, MIDDLE * longest, *_inner_edges(chart)))
        if longest <= most or len(parts) == 1:
            small.append(chart)
        else:
            waiting += parts
    return _parted(done, sorted(small, key=lambda chart: (chart.parent, int(chart.piece.faces[0]))))


def _flat(done: Charts) -> list[Flat]:
    return [Flat(piece, chart.result.uv, i) for i, (chart, piece) in enumerate(done)]


def _parted(done: Charts, parts: list[Flat]) -> Charts:
    """The charts as they are, or their parts, with their maps."""
    numbers = np.bincount([part.parent for part in parts])
    return [
        (_part_of(*done[part.parent], part), part.piece) if numbers[part.parent] > 1 else done[part.parent]
        for part in parts
    ]


def _part_of(chart: Chart, piece: Submesh, part: Flat) -> Chart:
    result = cut_out(chart.result, piece, part.piece, part.uv)
    result = replace(result, message=f"{result.message}; one of the parts that its map is cut into")
    overlapping = len(overlapping_pairs_of_chart(part.piece.topology, part.uv)) if chart.overlapping else 0
    quality = quality_of(part.piece, part.uv)
    return replace(chart, faces=part.piece.faces, result=result, quality=quality, overlapping=overlapping)


def _centres(chart: Flat) -> FloatArray:
    """Of the cells, in the map."""
    return centres(chart.piece.cells[0], chart.uv[chart.piece.F].mean(axis=1))


def _inner_edges(chart: Flat) -> tuple[IntArray, IntArray, FloatArray]:
    """The cells on both sides of each edge that may be cut, and its length on the surface."""
    piece = chart.piece
    cell, inside = piece.cells
    right, left = cell[piece.topology.sides[:, inside] % len(piece.F)]
    ends = piece.topology.edges[inside]
    return right, left, np.linalg.norm(piece.V[ends[:, 0]] - piece.V[ends[:, 1]], axis=1)


def _promising(charts: list[Flat], fill: float, trade: float) -> Iterator[tuple[int, BoolArray, float]]:
    """Chart, side of each cell, and seam length over the square root of all area, of the best lines' cuts."""
    areas = np.array([_area(chart.uv[chart.piece.F]) for chart in charts])
    hulls = np.array([_hull(chart.uv) for chart in charts])
    wide = np.array([_diameter(chart.uv) for chart in charts])
    k = int(np.argmax(np.maximum(LOOSE * hulls, SHORTEST**2 * wide**2) - areas))
    chart, total = charts[k], float(areas.sum())
    right, left, length = _inner_edges(chart)
    length = length / np.sqrt(total)
    centre = _centres(chart)
    a, b, across, spots = _coarse(right, left, length, centre)
    rest_hull, rest_wide = float(np.delete(hulls, k).sum()), float(np.delete(wide, k).max(initial=0.0))
    ranked: list[tuple[float, FloatArray, float, float]] = []
    for angle in np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        direction = np.array([np.cos(angle), np.sin(angle)])
        along = spots @ direction
        low, high = along.min(), along.max()
        for share in (np.arange(OFFSETS) + 1) / (OFFSETS + 1):
            at = low + share * (high - low)
            side = along > at
            same = side[a] == side[b]
            label = connected_labels(np.column_stack((a[same], b[same])), len(spots))
            hull, widest = rest_hull, rest_wide
            for part in range(int(label.max()) + 1):
                points = spots[label == part]
                hull += _hull(points)
                widest = max(widest, _diameter(points))
            page = max(LOOSE * hull, SHORTEST**2 * widest**2, total)
            gain = trade * (1 / fill - page / total) - float(across[~same].sum())
            ranked.append((gain, direction, at, high - low))
    ranked.sort(key=lambda entry: -entry[0])
    for _, direction, at, width in ranked[:TRIED]:
        side = _shortest_between(centre @ direction - at, BAND * width, right, left, length)
        yield k, side, float(length[side[right] != side[left]].sum())


def _coarse(
    right: IntArray, left: IntArray, length: FloatArray, centre: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Connected cells of one square of a grid as one: the ends of edges, their lengths, the centres."""
    if len(centre) <= GRID**2:
        return right, left, length, centre
    square = np.floor(centre / (np.ptp(centre, axis=0).max() / GRID)).astype(np.int64)
    same = (square[right] == square[left]).all(axis=1)
    of = connected_labels(np.column_stack((right[same], left[same])), len(centre))
    return of[right[~same]], of[left[~same]], length[~same], centres(of, centre)


def _shortest_between(
    along: FloatArray, band: float, right: IntArray, left: IntArray, length: FloatArray
) -> BoolArray:
    """Cells on one side of the shortest seam in a band around a line: a minimum cut."""
    within = np.abs(along) <= band
    m = int(np.count_nonzero(within))
    node = np.where(along < 0, m, m + 1)  # what is beyond the band is one node on each side
    if len(np.unique(node[~within])) < 2:
        return along > 0
    node[within] = np.arange(m)
    i, j = node[right], node[left]
    capacity = np.maximum(np.rint(length / length.max() * UNITS).astype(np.int64), 1)
    values, index = np.tile(capacity, 2), (np.append(i, j), np.append(j, i))
    graph = sparse.csr_array((values, index), shape=(m + 2, m + 2))
    graph.data = np.minimum(graph.data, np.iinfo(np.int32).max)
    graph = graph.astype(np.int32)
    flow = csgraph.maximum_flow(graph, m, m + 1).flow
    left_over = sparse.csr_array(graph - flow)
    left_over.data[left_over.data <= 0] = 0
    left_over.eliminate_zeros()
    side = np.ones(m + 2, dtype=bool)
    side[csgraph.breadth_first_order(left_over, m, return_predecessors=False)] = False
    return np.asarray(side[node])


def _parts(chart: Flat, side: BoolArray) -> list[Flat]:
    """The chart cut between its cells of two sides."""
    piece = chart.piece
    return [
        Flat(part, of_own_size(on_part(chart.uv, piece, part), part), chart.parent)
        for part in piece.divided(side[piece.cells[0]])
    ]


def _hull(points: FloatArray) -> float:
    """The area of the convex hull of those points that are farthest out in 32 directions."""
    x, y = points[(points @ OUTWARDS).argmax(axis=0)].T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def _diameter(points: FloatArray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _area(corner: FloatArray) -> float:
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    return float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2)
