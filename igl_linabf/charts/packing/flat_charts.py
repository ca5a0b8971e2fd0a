"""Represent a chart by its map so that it can be cut along edges between polygons."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..._core import min_rectangle_rotations
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import (
    Ragged,
    Submesh,
    complex_positions,
    compute_group_centres,
    connected_labels,
    signed_double_areas,
)
from ..atlas import restrict_uv, scale_to_surface
from ..features import CreasedSurface
from ..least_cuts import divide_at_least_cut, find_terminals_beside_line
from .outlines import Outline, find_bounding_rectangles

MIN_MAP_AREA = 1e-12  # a part with a smaller ratio of map area to surface area gets no outline
HULL_DIRECTIONS = 32  # directions whose extreme points approximate the convex hull of a chart

_angle = 2 * np.pi / HULL_DIRECTIONS * np.arange(HULL_DIRECTIONS)
OUTWARDS = np.stack((np.cos(_angle), np.sin(_angle)))  # unit vectors around the circle, (2, HULL_DIRECTIONS)


@dataclass(frozen=True, eq=False)
class FlatChart:
    """A chart, or a part of a chart, with a map that can be cut between atoms.

    An atom is a polygon or, on a body with planes, the faces of the chart in one plane.

    Attributes
    ----------
    creased : CreasedSurface
        The surface.
    piece : Submesh
        The faces of the chart.
    uv : (#V, 2) float64
    parent : int
        The index of the original chart.
    """

    creased: CreasedSurface
    piece: Submesh
    uv: FloatArray
    parent: int

    @cached_property
    def _interior_edges(self) -> IntArray:
        """The inner edges of the piece, as indices of inner edges of the surface."""
        return self.creased.find_edges_of_piece(self.piece)

    @cached_property
    def atom_of_face(self) -> IntArray:
        """The atom (polygon or plane) of each face, (#F,)."""
        within = self.creased.is_in_atom[self._interior_edges]
        return connected_labels(self.piece.topology.interior_edge_faces[within], len(self.piece.F))

    @cached_property
    def _is_between_atoms(self) -> BoolArray:
        """Mask of the inner edges that separate two atoms (polygons or planes)."""
        one, other = self.atom_of_face[self.piece.topology.interior_edge_faces].T
        return np.asarray(one != other)

    @cached_property
    def positions(self) -> ComplexArray:
        """The positions of the vertices in the map, as complex numbers, (#V,)."""
        return complex_positions(self.uv)

    @cached_property
    def atom_centres(self) -> FloatArray:
        """Centres of the atoms (polygons or planes) in the map, (#P, 2)."""
        a, b, c = self.uv[self.piece.topology.corner]
        return compute_group_centres(self.atom_of_face, (a + b + c) / 3)

    @cached_property
    def atoms_beside_edges(self) -> IntArray:
        """The atoms (polygons or planes) on both sides of each edge that may be cut, (2, #E)."""
        return np.asarray(
            self.atom_of_face[self.piece.topology.interior_edge_faces[self._is_between_atoms]].T
        )

    @cached_property
    def edge_prices(self) -> FloatArray:
        """Price of a seam along each edge that may be cut, (#E,), in units of length on the surface."""
        return np.asarray(self.creased.edge_price[self._interior_edges[self._is_between_atoms]])

    @cached_property
    def edge_ends(self) -> IntArray:
        """The vertices of each edge that may be cut, (#E, 2), with the atom `sides[0]` on the left."""
        return np.asarray(self.piece.topology.interior_edge_ends[self._is_between_atoms])

    @cached_property
    def boundary_edges(self) -> tuple[IntArray, IntArray]:
        """The vertices of the boundary edges, (#B, 2), and the atom (polygon or plane) left of each edge."""
        topology = self.piece.topology
        at = topology.sides[1] < 0
        return topology.edges[at], self.atom_of_face[topology.sides[0, at] % len(self.piece.F)]

    @cached_property
    def atom_areas(self) -> FloatArray:
        """Areas of the atoms (polygons or planes) on the surface and in the map, (2, #P)."""
        mapped = np.abs(signed_double_areas(self.positions, self.piece.topology.corner))
        return np.stack(
            [
                np.bincount(self.atom_of_face, double) / 2
                for double in (self.piece.areas_and_products[0], mapped)
            ]
        )

    @property
    def map_area(self) -> float:
        """Area of the chart in the map."""
        return float(self.atom_areas[1].sum())

    @cached_property
    def hull_area(self) -> float:
        """Area of the convex hull of the map's extreme points in `HULL_DIRECTIONS` directions."""
        rim = self.uv[self.boundary_edges[0][:, 0]]
        x, y = rim[(rim @ OUTWARDS).argmax(axis=0)].T
        return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2

    @cached_property
    def bounding_diagonal(self) -> float:
        """Diagonal of the map's axis-aligned bounding rectangle."""
        return float(np.linalg.norm(np.ptp(self.uv, axis=0)))

    def divide_at_line(self, along: FloatArray, band: float) -> BoolArray:
        """Return a mask, (#P,), of the atoms (polygons or planes) beyond the cheapest seam near a line.

        `along` has the signed distance of each atom from the line, (#P,).
        """
        return divide_at_least_cut(
            self.atoms_beside_edges, self.edge_prices, find_terminals_beside_line(along, band)
        )

    def cut_into_parts(self, side: BoolArray) -> list["FlatChart"]:
        """Cut the chart along the border of the atoms in the mask `side`, (#P,), and return the parts.

        The map of each part is scaled to the part's area on the surface. Parts are sorted by their first
        faces, in the same order as in `FaceGroups.make_outlines_of_parts`.
        """
        piece = self.piece
        parts = sorted(piece.cut_between_labels(side[self.atom_of_face]), key=lambda part: int(part.faces[0]))
        return [
            FlatChart(
                self.creased, part, scale_to_surface(restrict_uv(self.uv, piece, part), part), self.parent
            )
            for part in parts
        ]

    def make_groups_of_one(self) -> "FaceGroups":
        """Return `FaceGroups` with one atom, a polygon or a plane, in each group."""
        alone = np.arange(len(self.atom_centres))
        return FaceGroups(
            self, alone, self.atom_centres, np.ones(len(self.atoms_beside_edges[0]), dtype=bool)
        )

    def group_by_square(self, squares: int) -> "FaceGroups":
        """Group the connected atoms in each square of a grid that divides the chart's side into `squares`.

        If there are at most as many atoms as squares, each atom is a group.
        """
        centre, sides = self.atom_centres, self.atoms_beside_edges
        if len(centre) <= squares**2:
            return self.make_groups_of_one()
        square = np.floor(centre / (np.ptp(centre, axis=0).max() / squares)).astype(np.int64)
        same = (square[sides[0]] == square[sides[1]]).all(axis=1)
        group = connected_labels(sides[:, same].T, len(centre))
        return FaceGroups(self, group, compute_group_centres(group, centre), ~same)


@dataclass(frozen=True, eq=False)
class FaceGroups:
    """Groups of connected atoms of a chart.

    Attributes
    ----------
    chart : FlatChart
    label : (#P,) int64
        The group of each atom.
    centre : (#G, 2) float64
        Centres of the groups in the map.
    is_border : (#E,) bool
        Whether each of the chart's edges is between two groups.
    """

    chart: FlatChart
    label: IntArray
    centre: FloatArray
    is_border: BoolArray

    @cached_property
    def groups_beside_edges(self) -> IntArray:
        """The groups on both sides of each edge between two groups, (2, #B)."""
        return np.asarray(self.label[self.chart.atoms_beside_edges[:, self.is_border]])

    @cached_property
    def edge_prices(self) -> FloatArray:
        """Prices of seams along the edges between two groups, (#B,), in units of length on the surface."""
        return np.asarray(self.chart.edge_prices[self.is_border])

    @cached_property
    def is_at_boundary(self) -> BoolArray:
        """Mask of the groups at the boundary of the chart, (#G,)."""
        outer = np.zeros(len(self.centre), dtype=bool)
        outer[self.label[self.chart.boundary_edges[1]]] = True
        return outer

    @cached_property
    def group_areas(self) -> FloatArray:
        """Areas of the groups on the surface and in the map, (2, #G)."""
        return np.stack([np.bincount(self.label, area) for area in self.chart.atom_areas])

    def make_outlines_of_parts(self, beyond: BoolArray) -> list[list[Outline]]:
        """Return the outlines of the chart's parts for each of several alternative cuts.

        `beyond`, (#cuts, #G), is a mask of the groups on one side of each cut. If a part is a single
        triangle, or has no area in the map, the list of its cut is empty.
        """
        n, cuts = len(self.centre), len(beyond)
        cut = beyond[:, self.groups_beside_edges[0]] != beyond[:, self.groups_beside_edges[1]]
        ends = np.empty((*cut.shape, 2), dtype=np.int64)
        ends[...] = self.groups_beside_edges.T + n * np.arange(cuts)[:, None, None]
        by, edge = np.nonzero(cut)
        ends[by, edge, 1] = ends[by, edge, 0]  # a self-loop, because the cut separates the two groups
        part = connected_labels(ends.reshape(-1, 2), n * cuts)
        rim, atom = self.chart.boundary_edges
        seam = self.chart.edge_ends[self.is_border][edge]
        around = np.concatenate((np.tile(rim, (cuts, 1)), seam, seam[:, ::-1]))
        at_rim = self.label[atom] + n * np.arange(cuts)[:, None]
        of = part[np.concatenate((at_rim.ravel(), *(self.groups_beside_edges[:, edge] + n * by)))]
        order = np.argsort(of, kind="stable")
        totals = *self.group_areas, np.bincount(self.label[self.chart.atom_of_face])
        own, mapped, faces = np.stack([np.bincount(part, np.tile(total, cuts)) for total in totals])
        sides = Ragged.from_sizes(np.bincount(of, minlength=len(own)))
        made = _make_outlines(
            self.chart.positions[around[order].T], sides, own, np.where(faces > 1, mapped, 0)
        )
        begin = [*part[::n].tolist(), len(made)]  # the parts of each cut have consecutive numbers
        return [_discard_if_incomplete(made[i:j]) for i, j in pairwise(begin)]


def make_chart_outlines(charts: Sequence[FlatChart]) -> list[Outline]:
    """Return the outlines of charts, scaled to their areas on the surface and turned to narrow rectangles.

    The lower left corner of each chart's rectangle is at the origin. If any chart has no area in its map, the
    list is empty.
    """
    sides = Ragged.from_sizes([len(chart.boundary_edges[0]) for chart in charts])
    ends = np.concatenate([chart.positions[chart.boundary_edges[0]] for chart in charts])
    own, mapped = np.array([chart.atom_areas.sum(axis=1) for chart in charts]).T
    return _discard_if_incomplete(_make_outlines(ends.T, sides, own, mapped))


def _discard_if_incomplete(outlines: list[Outline | None]) -> list[Outline]:
    """Return the outlines, or an empty list if any of them is None."""
    has = [outline for outline in outlines if outline is not None]
    return has if len(has) == len(outlines) else []


def _make_outlines(
    ends: ComplexArray, sides: Ragged, own: FloatArray, mapped: FloatArray
) -> list[Outline | None]:
    """Return the outlines of parts with the given boundary, (2, #S), scaled to their areas on the surface.

    The outline of a part without area in the map is None.
    """
    kept = mapped > MIN_MAP_AREA * own
    scale = np.sqrt(np.where(kept, own, 0) / np.where(kept, mapped, 1))
    start, end = ends * sides.repeat(scale)
    turn = sides.repeat(min_rectangle_rotations(start, sides.start))
    low = sides.repeat(find_bounding_rectangles(start * turn, sides)[0])
    weight = np.ones(len(start), dtype=np.int64)
    rows = (sides.split(values) for values in (start * turn - low, end * turn - low, weight))
    each = zip(*rows, own.tolist(), kept.tolist(), strict=True)
    return [Outline(start, end, weight, area) if has else None for start, end, weight, area, has in each]
