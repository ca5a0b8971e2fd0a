"""Charts with their maps, which are cut further: polygons, which stay whole, and the edges between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..._core import narrowest_turns
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged, Submesh, centres, complex_positions, connected_labels, signed_double_areas
from ..atlas import scaled_to_surface, uv_of_part
from ..least_cuts import edges_between_polygons, sides_of_least_cut, terminals_beside_line
from .constants import HULL_DIRECTIONS, MIN_MAP_AREA
from .outlines import Outline, rectangles

_angle = 2 * np.pi / HULL_DIRECTIONS * np.arange(HULL_DIRECTIONS)
OUTWARDS = np.stack((np.cos(_angle), np.sin(_angle)))  # directions, (2, HULL_DIRECTIONS)


@dataclass(frozen=True, eq=False)
class FlatChart:
    """A chart, or a part of one, with its map.

    Attributes
    ----------
    piece : Submesh
    uv : (#V, 2) float64
    parent : int
        The number of the chart.
    """

    piece: Submesh
    uv: FloatArray
    parent: int

    @cached_property
    def z(self) -> ComplexArray:
        """The map, (#V,)."""
        return complex_positions(self.uv)

    @cached_property
    def centre(self) -> FloatArray:
        """Of the polygons in the map, (#P, 2)."""
        a, b, c = self.uv[self.piece.topology.corner]
        return centres(self.piece.polygon_labels, (a + b + c) / 3)

    @cached_property
    def _between(self) -> tuple[IntArray, FloatArray]:
        return edges_between_polygons(self.piece)

    @property
    def sides(self) -> IntArray:
        """The polygons on both sides of each edge between two of them, (2, #E)."""
        return self._between[0]

    @property
    def lengths(self) -> FloatArray:
        """Of these edges on the surface, (#E,)."""
        return self._between[1]

    @cached_property
    def ends(self) -> IntArray:
        """The vertices of these edges, (#E, 2); the first polygon is on the left."""
        return np.asarray(self.piece.topology.edges[self.piece.cuttable_edges])

    @cached_property
    def rim(self) -> tuple[IntArray, IntArray]:
        """The vertices of the boundary edges, (#B, 2), and the polygon on the left of each."""
        topology = self.piece.topology
        at = topology.sides[1] < 0
        return topology.edges[at], self.piece.polygon_labels[topology.sides[0, at] % len(self.piece.F)]

    @cached_property
    def areas(self) -> FloatArray:
        """Of the polygons on the surface and in the map, (2, #P)."""
        mapped = np.abs(signed_double_areas(self.z, self.piece.topology.corner))
        polygon = self.piece.polygon_labels
        return np.stack([np.bincount(polygon, double) / 2 for double in (self.piece.measured[0], mapped)])

    @property
    def area(self) -> float:
        """Of the map."""
        return float(self.areas[1].sum())

    @cached_property
    def hull(self) -> float:
        """The area of the convex hull of those points of the map that are farthest out in some directions."""
        rim = self.uv[self.rim[0][:, 0]]
        x, y = rim[(rim @ OUTWARDS).argmax(axis=0)].T
        return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2

    @cached_property
    def diagonal(self) -> float:
        """Of the upright rectangle around the map."""
        return float(np.linalg.norm(np.ptp(self.uv, axis=0)))

    def divided_near(self, along: FloatArray, band: float) -> BoolArray:
        """The polygons on one side of the shortest seam near a line, by signed distances from it, (#P,)."""
        return sides_of_least_cut(self.sides, self.lengths, terminals_beside_line(along, band))

    def parts(self, side: BoolArray) -> list["FlatChart"]:
        """The chart cut between its polygons of two sides, (#P,); each part at the scale of its own area.

        They are in the order of their first faces, as those of `PolygonGroups.outlines`.
        """
        piece = self.piece
        parts = sorted(piece.divided(side[piece.polygon_labels]), key=lambda part: int(part.faces[0]))
        return [
            FlatChart(part, scaled_to_surface(uv_of_part(self.uv, piece, part), part), self.parent)
            for part in parts
        ]

    def polygons(self) -> "PolygonGroups":
        """Each a group of its own."""
        polygons = np.arange(len(self.centre))
        return PolygonGroups(self, polygons, self.centre, np.ones(len(self.sides[0]), dtype=bool))

    def groups(self, squares: int) -> "PolygonGroups":
        """The connected polygons in each square of a grid, so many along the chart; if these are fewer."""
        centre, sides = self.centre, self.sides
        if len(centre) <= squares**2:
            return self.polygons()
        square = np.floor(centre / (np.ptp(centre, axis=0).max() / squares)).astype(np.int64)
        same = (square[sides[0]] == square[sides[1]]).all(axis=1)
        group = connected_labels(sides[:, same].T, len(centre))
        return PolygonGroups(self, group, centres(group, centre), ~same)


@dataclass(frozen=True, eq=False)
class PolygonGroups:
    """Groups of connected polygons of a chart.

    Attributes
    ----------
    chart : FlatChart
    of : (#P,) int64
        The group of each polygon.
    centre : (#G, 2) float64
        Of the groups, in the map.
    between : (#E,) bool
        Which of the chart's edges are between two groups.
    """

    chart: FlatChart
    of: IntArray
    centre: FloatArray
    between: BoolArray

    @cached_property
    def sides(self) -> IntArray:
        """The groups on both sides of each of these edges, (2, #between)."""
        return np.asarray(self.of[self.chart.sides[:, self.between]])

    @cached_property
    def lengths(self) -> FloatArray:
        """Of these edges on the surface, (#between,)."""
        return np.asarray(self.chart.lengths[self.between])

    @cached_property
    def outer(self) -> BoolArray:
        """Which groups are at the boundary, (#G,)."""
        outer = np.zeros(len(self.centre), dtype=bool)
        outer[self.of[self.chart.rim[1]]] = True
        return outer

    @cached_property
    def areas(self) -> FloatArray:
        """Of the groups on the surface and in the map, (2, #G)."""
        return np.stack([np.bincount(self.of, area) for area in self.chart.areas])

    def outlines(self, beyond: BoolArray) -> list[list[Outline]]:
        """The outlines of the parts that several cuts leave; `beyond`, (#cuts, #G), is one side of each.

        They are as those of `whole_outlines`: a cut that leaves a part without area in the map has none.
        """
        n, cuts = len(self.centre), len(beyond)
        cut = beyond[:, self.sides[0]] != beyond[:, self.sides[1]]
        ends = np.empty((*cut.shape, 2), dtype=np.int64)
        ends[...] = self.sides.T + n * np.arange(cuts)[:, None, None]
        by, edge = np.nonzero(cut)
        ends[by, edge, 1] = ends[by, edge, 0]  # an edge that is cut joins nothing
        part = connected_labels(ends.reshape(-1, 2), n * cuts)
        rim, polygon = self.chart.rim
        seam = self.chart.ends[self.between][edge]
        around = np.concatenate((np.tile(rim, (cuts, 1)), seam, seam[:, ::-1]))
        at_rim = self.of[polygon] + n * np.arange(cuts)[:, None]
        of = part[np.concatenate((at_rim.ravel(), *(self.sides[:, edge] + n * by)))]
        order = np.argsort(of, kind="stable")
        own, mapped = np.stack([np.bincount(part, np.tile(area, cuts)) for area in self.areas])
        sides = Ragged.of_sizes(np.bincount(of, minlength=len(own)))
        made = _outlines(self.chart.z[around[order].T], sides, own, mapped)
        begin = [*part[::n].tolist(), len(made)]  # parts are numbered cut by cut
        return [_all_or_none(made[i:j]) for i, j in pairwise(begin)]


def whole_outlines(charts: Sequence[FlatChart]) -> list[Outline]:
    """The outlines of charts, each at the scale of its own area, turned to its narrowest rectangle.

    The rectangle's lower left corner is at the origin. If a chart has no area in the map, there are none.
    """
    sides = Ragged.of_sizes([len(chart.rim[0]) for chart in charts])
    ends = np.concatenate([chart.z[chart.rim[0]] for chart in charts])
    own, mapped = np.array([chart.areas.sum(axis=1) for chart in charts]).T
    return _all_or_none(_outlines(ends.T, sides, own, mapped))


def _all_or_none(outlines: list[Outline | None]) -> list[Outline]:
    has = [outline for outline in outlines if outline is not None]
    return has if len(has) == len(outlines) else []


def _outlines(ends: ComplexArray, sides: Ragged, own: FloatArray, mapped: FloatArray) -> list[Outline | None]:
    """The outlines of parts with these sides, (2, #S), of their own areas and those in the map."""
    kept = mapped > MIN_MAP_AREA * own
    scale = np.sqrt(np.where(kept, own, 0) / np.where(kept, mapped, 1))
    start, end = ends * sides.repeat(scale)
    turn = sides.repeat(narrowest_turns(start, sides.start))
    low = sides.repeat(rectangles(start * turn, sides)[0])
    weight = np.ones(len(start), dtype=np.int64)
    rows = (sides.split(values) for values in (start * turn - low, end * turn - low, weight))
    each = zip(*rows, own.tolist(), kept.tolist(), strict=True)
    return [Outline(start, end, weight, area) if has else None for start, end, weight, area, has in each]
