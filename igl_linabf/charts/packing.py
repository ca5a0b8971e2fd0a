"""Charts side by side in the unit square, at one common scale.

Each chart is turned to the rectangle of least area around it. rectpack packs the rectangles of a few
charts, and those of many go on shelves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import rectpack
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from ..errors import MeshError
from ..surface import Parts, Submesh, complex_positions, coordinates, signed_double_areas
from .shelves import areas, extents, narrowest_turns, on_shelves

UNITS = 1 << 20  # along the square's side: rectpack counts in integers
SCALE_TRIALS = 16  # by each rule, halving the interval
RULES = (rectpack.MaxRectsBssf, rectpack.MaxRectsBaf, rectpack.SkylineBl)
FEW_CHARTS = 60  # up to which rectpack tries every rule; more charts are put on shelves, which is fast
SOME_CHARTS = 250  # up to which rectpack's last rule is tried, too

Shelves = Callable[[IntArray, int], tuple[IntArray, IntArray, BoolArray] | None]
Rule = type | Shelves
Place = tuple[int, int, int, int, bool]  # left, bottom, width, height in grid units; whether it is turned


@dataclass(frozen=True, eq=False)
class Placed:
    """A chart in the unit square: `ratio * (u + iv) + shift` of what it was.

    Attributes
    ----------
    ratio : complex
        Turn and scale. Its absolute value is the common scale, the same for all charts.
    shift : complex
    uv : (#V, 2) float64
        The chart's coordinates there; NaN at vertices that no face refers to.
    area : float
        Its area there; the sum over the charts is the share of the square that is filled.
    """

    ratio: complex
    shift: complex
    uv: FloatArray
    area: float


@dataclass(frozen=True, eq=False)
class _TurnedChart:
    """A chart turned to its narrowest rectangle, its lower left corner at 0."""

    z: ComplexArray
    turn: complex
    origin: complex
    extent: complex
    area: float


def pack(charts: Sequence[tuple[ArrayLike, ArrayLike]], *, margin: float = 0.005) -> list[Placed]:
    """Pack charts into the unit square by similarities of one common scale, without mirroring.

    Parameters
    ----------
    charts : sequence of (uv, F)
        Coordinates (#V, 2) float and triangles (#F, 3) int of each chart, at the relative scale
        they shall keep (that of their 3-D areas).
    margin : float
        Smallest distance between two charts and to the border, as a share of the square's side.

    Returns
    -------
    list of Placed
        In the order of `charts`; the same for the same input.

    Raises
    ------
    MeshError
        A chart has no area or coordinates that are not finite, or there are too many charts for
        the margin.
    ValueError
        The margin is not within [0, 0.1].

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), np.array([[0, 1, 2], [0, 2, 3]])
    >>> placed = pack([square] * 4)
    >>> sum(chart.area for chart in placed) > 0.95
    True
    """
    given = []
    for i, (uv, F) in enumerate(charts):
        try:
            given.append(Submesh.checked(uv, F, 2, "uv"))
        except MeshError as error:
            raise MeshError(f"chart {i}: {error}") from None
    placed = pack_maps([(chart.V, chart.F) for chart in given], margin)
    return [replace(p, uv=chart.scatter(p.uv)) for chart, p in zip(given, placed, strict=True)]


def pack_maps(
    maps: Sequence[tuple[FloatArray, IntArray]], margin: float, upright: bool = False
) -> list[Placed]:
    """`pack` of charts that are checked; every vertex has a face.

    With `upright`, several charts are only turned by quarter turns.
    """
    if not 0 <= margin <= 0.1:
        raise ValueError(f"margin is {margin!r}: give a share of the square's side, from 0 to 0.1")
    many = len(maps) > FEW_CHARTS
    if upright and len(maps) > 1:
        given = _turned_many(maps, upright)
    elif many:
        given = _turned_many(maps)
    else:
        given = [_turned(*pair, i, len(maps) == 1) for i, pair in enumerate(maps)]
    if not given:
        return []
    sizes = np.array([chart.extent for chart in given])
    inner = 1 - margin  # each rectangle brings the margin on two of its sides
    longest = max(sizes.real.max(), sizes.imag.max())
    high = min((1 - 2 * margin) / longest, inner / np.sqrt(sum(chart.area for chart in given)))
    high *= 1 - 8 / UNITS  # rectangles are rounded up to the grid
    scale, places = 0.0, None
    for rule in _rules(len(given)):
        top, trial = high, high
        for _ in range(SCALE_TRIALS):
            found = _attempt(sizes * trial, margin, rule)
            if found is None:
                top = trial
            else:
                scale, places = trial, found
            trial = (scale + top) / 2
            if scale == high:
                break
        if scale == high:
            break
    if places is None:
        raise MeshError(f"{len(given)} charts do not fit with a margin of {margin}: use a smaller one")
    # to the very border: the gaps only become wider
    right = max(max(x + w, y + h) for x, y, w, h, _ in places) / UNITS - margin
    grow = (1 - 2 * margin) / right
    return [
        _placed(chart, scale * grow, place, margin, grow) for chart, place in zip(given, places, strict=True)
    ]


def _rules(charts: int) -> tuple[Rule, ...]:
    """How so many charts are packed; of several rules the one that leaves them largest counts."""
    if charts <= FEW_CHARTS:
        return RULES
    return (on_shelves, RULES[-1]) if charts <= SOME_CHARTS else (on_shelves,)


def _attempt(charts: ComplexArray, margin: float, rule: Rule) -> list[Place] | None:
    """Places for all charts of these sizes, each with the margin above and right of it."""
    units = np.ceil((np.column_stack((charts.real, charts.imag)) + margin) * UNITS).astype(np.int64)
    side, sizes = int((1 - margin) * UNITS), units.tolist()
    if not isinstance(rule, type):
        shelved = rule(units, side)
        if shelved is None:
            return None
        turned = shelved[2]
        lying = np.where(turned[:, None], units[:, ::-1], units)
        columns = (shelved[0], shelved[1], lying[:, 0], lying[:, 1], turned)
        return list(zip(*(column.tolist() for column in columns), strict=True))
    packer = rectpack.newPacker(
        mode=rectpack.PackingMode.Offline, bin_algo=rectpack.PackingBin.BNF, pack_algo=rule, rotation=True
    )
    packer.add_bin(side, side)
    for i, (width, height) in enumerate(sizes):
        packer.add_rect(width, height, i)
    packer.pack()
    found = {i: (x, y, w, h) for _, x, y, w, h, i in packer.rect_list()}
    if len(found) < len(sizes):
        return None
    return [(*found[i], list(found[i][2:]) != size) for i, size in enumerate(sizes)]


def _placed(chart: _TurnedChart, scale: float, place: Place, margin: float, grow: float) -> Placed:
    x, y, _, _, lies = place
    corner = complex(x, y) / UNITS * grow + complex(margin, margin)
    # a quarter turn about the lower left corner, and back into the rectangle
    turn, back = (1j, chart.extent.imag) if lies else (1 + 0j, 0.0)
    new = (chart.z * turn + back) * scale + corner
    ratio = scale * turn * chart.turn
    shift = corner + scale * (back - turn * chart.origin)
    return Placed(ratio, shift, coordinates(new), float(chart.area * scale**2))


def _turned_many(maps: Sequence[tuple[FloatArray, IntArray]], upright: bool = False) -> list[_TurnedChart]:
    """`_turned` of many charts; with `upright`, they stay as they are turned."""
    vertices, faces = (Parts.of_sizes([len(pair[k]) for pair in maps]) for k in (0, 1))
    z = complex_positions(np.concatenate([uv for uv, _ in maps]))
    F = np.concatenate([F for _, F in maps]) + faces.spread(vertices.start[:-1])[:, None]
    area = areas(signed_double_areas(z, np.ascontiguousarray(F.T)), faces)
    size = extents(z, vertices)[1]
    size = np.maximum(size.real, size.imag)
    flat = ~(area > 4 * np.finfo(float).eps * size * np.maximum(size, vertices.max(np.abs(z))))
    if flat.any():
        i = int(np.argmax(flat))
        raise _without_area(i, len(maps[i][1]))
    turn = np.ones(len(maps), dtype=np.complex128) if upright else narrowest_turns(z, vertices)
    z = z * vertices.spread(turn)
    origin, extent = extents(z, vertices)
    z -= vertices.spread(origin)
    rows = zip(turn.tolist(), origin.tolist(), extent.tolist(), area.tolist(), strict=True)
    bounds = pairwise(vertices.start.tolist())
    return [_TurnedChart(z[slice(*at)], *row) for at, row in zip(bounds, rows, strict=True)]


def _without_area(i: int, n_faces: int) -> MeshError:
    return MeshError(f"chart {i} has no area (its {n_faces} faces lie on a line): leave it out")


def _turned(uv: FloatArray, F: IntArray, i: int, single: bool) -> _TurnedChart:
    z = complex_positions(uv)
    area = float(np.abs(signed_double_areas(z, np.ascontiguousarray(F.T))).sum()) / 2
    size = max(float(np.ptp(z.real)), float(np.ptp(z.imag)))
    if not area > 4 * np.finfo(float).eps * size * max(size, float(np.abs(z).max())):
        raise _without_area(i, len(F))
    turn = _best_turn(z, single)
    z = z * turn
    origin = complex(z.real.min(), z.imag.min())
    z -= origin
    return _TurnedChart(z, turn, origin, complex(z.real.max(), z.imag.max()), area)


def _best_turn(z: ComplexArray, single: bool) -> complex:
    """The turn to the rectangle of least area around `z`; to the least square for a single chart."""
    points = np.column_stack((z.real, z.imag)) - [z.real.mean(), z.imag.mean()]
    axes, sizes, _ = np.linalg.svd(points.T, full_matrices=False)
    # Qhull takes long thin charts as flat: whiten them, which does not change what is on the hull
    hull = z[ConvexHull(points @ (axes / sizes)).vertices]
    edges = np.roll(hull, -1) - hull
    turns = edges.conj() / np.abs(edges)
    turns = turns[:: -(-len(turns) // 1000)]
    if single:
        turns = np.concatenate((turns, np.exp(0.5j * np.pi * np.linspace(0, 1, 1000, endpoint=False))))
    best = (np.inf, 1 + 0j)
    for part in np.array_split(turns, -(-len(turns) * len(hull) // 1_000_000)):
        turned = part[:, None] * hull
        width, height = np.ptp(turned.real, axis=1), np.ptp(turned.imag, axis=1)
        cost = np.maximum(width, height) if single else width * height
        k = int(cost.argmin())
        best = min(best, (float(cost[k]), complex(part[k])), key=lambda pair: pair[0])
    return best[1]
