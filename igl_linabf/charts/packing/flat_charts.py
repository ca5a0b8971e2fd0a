"""Charts with their maps, which are cut further: the cells that stay whole, and the edges between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..._core import lengths, narrowest_turns
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged, Submesh, centres, complex_positions, connected_labels, signed_double_areas
from ..atlas import scaled_to_surface, uv_of_part
from .outlines import Outline, extents

OUTWARDS = np.stack((np.cos(np.pi / 16 * np.arange(32)), np.sin(np.pi / 16 * np.arange(32))))

LEAST = 1e-12  # of the area of a surface is what a map of it has


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

    @cached_property
    def z(self) -> ComplexArray:
        """The map."""
        return complex_positions(self.uv)

    @cached_property
    def centre(self) -> FloatArray:
        """Of the cells, in the map."""
        a, b, c = self.uv[self.piece.topology.corner]
        return centres(self.piece.polygon_labels, (a + b + c) / 3)

    @cached_property
    def sides(self) -> IntArray:
        """The cells (2, #C) on both sides of each edge that may be cut."""
        cell, inside = self.piece.polygon_labels, self.piece.cuttable_edges
        return np.asarray(cell[self.piece.topology.sides[:, inside] % len(self.piece.F)])

    @cached_property
    def ends(self) -> IntArray:
        """The vertices (#C, 2) of these edges; the first cell is on the left."""
        return np.asarray(self.piece.topology.edges[self.piece.cuttable_edges])

    @cached_property
    def lengths(self) -> FloatArray:
        """Of these edges, on the surface."""
        return lengths(self.piece.V, self.ends)

    @cached_property
    def rim(self) -> tuple[IntArray, IntArray]:
        """The vertices (#R, 2) of the edges at the boundary, and the cell on the left of each."""
        topology = self.piece.topology
        at = topology.sides[1] < 0
        return topology.edges[at], self.piece.polygon_labels[topology.sides[0, at] % len(self.piece.F)]

    @cached_property
    def areas(self) -> FloatArray:
        """(2, #cells) float64. Of the cells on the surface, and in the map."""
        mapped = np.abs(signed_double_areas(self.z, self.piece.topology.corner))
        cell = self.piece.polygon_labels
        return np.stack([np.bincount(cell, double) / 2 for double in (self.piece.measured[0], mapped)])

    @property
    def area(self) -> float:
        """Of the map."""
        return float(self.areas[1].sum())

    @cached_property
    def hull(self) -> float:
        """The area of the convex hull of those points that are farthest out in some directions."""
        rim = self.uv[self.rim[0][:, 0]]
        x, y = rim[(rim @ OUTWARDS).argmax(axis=0)].T
        return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2

    @cached_property
    def diameter(self) -> float:
        """The diagonal of the upright rectangle around the map."""
        return float(np.linalg.norm(np.ptp(self.uv, axis=0)))

    def parts(self, side: BoolArray) -> list["Flat"]:
        """The chart cut between its cells of two sides, each part as large as its surface.

        They are in the order of their first faces, as those of `Cells.outlines`.
        """
        piece = self.piece
        parts = sorted(piece.divided(side[piece.polygon_labels]), key=lambda part: int(part.faces[0]))
        return [
            Flat(part, scaled_to_surface(uv_of_part(self.uv, piece, part), part), self.parent)
            for part in parts
        ]

    def cells(self) -> "Cells":
        """All of them."""
        cells = np.arange(len(self.centre))
        return Cells(self, cells, self.centre, np.ones(len(self.sides[0]), dtype=bool))


@dataclass(frozen=True, eq=False)
class Cells:
    """A chart's cells, or groups of connected ones.

    Attributes
    ----------
    chart : Flat
    of : (#cells,) int64
        The group of each cell.
    centre : (#G, 2) float64
        Of the groups, in the map.
    between : (#C,) bool
        Which edges that may be cut have two groups.
    """

    chart: Flat
    of: IntArray
    centre: FloatArray
    between: BoolArray

    @classmethod
    def grouped(cls, chart: Flat, squares: int) -> "Cells":
        """Connected cells in one square of a grid, so many along the chart, are one, if they are many."""
        centre, sides = chart.centre, chart.sides
        if len(centre) <= squares**2:
            return chart.cells()
        square = np.floor(centre / (np.ptp(centre, axis=0).max() / squares)).astype(np.int64)
        same = (square[sides[0]] == square[sides[1]]).all(axis=1)
        of = connected_labels(sides[:, same].T, len(centre))
        return cls(chart, of, centres(of, centre), ~same)

    @cached_property
    def sides(self) -> IntArray:
        """The groups on both sides of these edges."""
        return np.asarray(self.of[self.chart.sides[:, self.between]])

    @cached_property
    def lengths(self) -> FloatArray:
        """Of these edges, on the surface."""
        return np.asarray(self.chart.lengths[self.between])

    @cached_property
    def outer(self) -> BoolArray:
        """The groups at the boundary."""
        outer = np.zeros(len(self.centre), dtype=bool)
        outer[self.of[self.chart.rim[1]]] = True
        return outer

    @cached_property
    def areas(self) -> FloatArray:
        """(2, #G) float64. On the surface, and in the map."""
        return np.stack([np.bincount(self.of, area) for area in self.chart.areas])

    def outlines(self, beyond: BoolArray) -> list[list[Outline]]:
        """For each of several cuts, (#cuts, #G) the groups on one side, those of the parts that it leaves.

        Each part is as large as its surface, turned to its narrowest rectangle, its lower left corner at 0. A
        cut that leaves a part without area in the map has none.
        """
        n, cuts = len(self.centre), len(beyond)
        cut = beyond[:, self.sides[0]] != beyond[:, self.sides[1]]
        ends = np.empty((*cut.shape, 2), dtype=np.int64)
        ends[...] = self.sides.T + n * np.arange(cuts)[:, None, None]
        by, edge = np.nonzero(cut)
        ends[by, edge, 1] = ends[by, edge, 0]  # an edge that is cut joins nothing
        part = connected_labels(ends.reshape(-1, 2), n * cuts)
        rim, cell = self.chart.rim
        seam = self.chart.ends[self.between][edge]
        around = np.concatenate((np.tile(rim, (cuts, 1)), seam, seam[:, ::-1]))
        at_rim = self.of[cell] + n * np.arange(cuts)[:, None]
        of = part[np.concatenate((at_rim.ravel(), *(self.sides[:, edge] + n * by)))]
        order = np.argsort(of, kind="stable")
        own, mapped = np.stack([np.bincount(part, np.tile(area, cuts)) for area in self.areas])
        sides = Ragged.of_sizes(np.bincount(of, minlength=len(own)))
        made = _outlines(self.chart.z[around[order].T], sides, own, mapped)
        begin = [*part[::n].tolist(), len(made)]  # parts are numbered cut by cut
        return [_all_or_none(made[i:j]) for i, j in pairwise(begin)]


def whole_outlines(charts: Sequence[Flat]) -> list[Outline]:
    """Those of whole charts, each as large as its surface and turned to its narrowest rectangle.

    None at all if one has no area in the map.
    """
    sides = Ragged.of_sizes([len(chart.rim[0]) for chart in charts])
    ends = np.concatenate([chart.z[chart.rim[0]] for chart in charts])
    own, mapped = np.array([chart.areas.sum(axis=1) for chart in charts]).T
    return _all_or_none(_outlines(ends.T, sides, own, mapped))


def _all_or_none(outlines: list[Outline | None]) -> list[Outline]:
    has = [outline for outline in outlines if outline is not None]
    return has if len(has) == len(outlines) else []


def _outlines(ends: ComplexArray, sides: Ragged, own: FloatArray, mapped: FloatArray) -> list[Outline | None]:
    """Outlines of the sides (2, #S), part by part, with their own areas instead of those in the map."""
    kept = mapped > LEAST * own
    scale = np.sqrt(np.where(kept, own, 0) / np.where(kept, mapped, 1))
    start, end = ends * sides.repeat(scale)
    turn = sides.repeat(narrowest_turns(start, sides.start))
    low = sides.repeat(extents(start * turn, sides)[0])
    weight = np.ones(len(start), dtype=np.int64)
    rows = (sides.split(values) for values in (start * turn - low, end * turn - low, weight))
    each = zip(*rows, own.tolist(), kept.tolist(), strict=True)
    return [Outline(start, end, weight, area) if has else None for start, end, weight, area, has in each]
