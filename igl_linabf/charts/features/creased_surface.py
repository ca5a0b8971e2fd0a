"""A surface with creases: its dihedral angles, sharp creases, planes and curved vertices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._core import lengths, nearest_sources, normals, shortest_edges
from ..._types import BoolArray, FloatArray, IntArray
from ...surface import NEXT, PREV, Ragged, Submesh, connected_labels, sum_by_index
from ..cost import CREASE_ANGLE, SHARP_CREASE_ANGLE, compute_edge_prices
from . import constants
from .curvature import compute_dihedral_angles, compute_flat_shares, find_apexes, measure_component_extents
from .visibility import compute_visibility_factors

FLAT_HOLE_TURN = 1e-3  # maximum deviation from -2 pi, radians, of the total turning of a flat hole's boundary
MAX_FLAT_HOLES = 300  # with more flat holes than this, seams do not avoid them
PLANE_BEND = 1e-3  # maximum dihedral angle, radians, between coplanar faces
MIN_CHART_HEIGHT = 1e-12  # minimum ratio of a face's height to its longest side, for faces of panels
MIN_DISK_CURVATURE = 0.02  # a curved disk has panels if its sum of (angle defect / 2 pi)^2 is larger

MIN_PLANE_SHARE = 1e-3  # minimum area of a large plane, as a share of the component's area
PLANE_OVER_NEIGHBOURS = 2.0  # minimum ratio of a large plane's area to that of a smoothly adjacent plane
TURN_OF_EXTENT = 1e-3  # turning, radians, that counts as much as a path of one extent in distances to planes
MAX_CHAMFER_ANGLE = np.deg2rad(50.0)  # maximum dihedral angle between a plane and its chamfer
MAX_FILLET_ANGLE = np.deg2rad(60.0)  # maximum angle between a plane and a face of its fillets and chamfers


@dataclass(frozen=True, eq=False)
class CreasedSurface:
    """A surface of several components, its creases and its curvature.

    Attributes
    ----------
    surface : Submesh
    hidden : (#F',) float64 or None
        How well each input face hides a seam, from -1 to 1 (see `compute_hiding_weights`).
    """

    surface: Submesh
    hidden: FloatArray | None = None

    @property
    def component_of_face(self) -> IntArray:
        """The connected component of each face, (#F,)."""
        return self.surface.component_of_face

    @cached_property
    def component_extent(self) -> FloatArray:
        """The longest side of the bounding box of each component."""
        return measure_component_extents(self.surface, self.component_of_face)

    @property
    def interior_edges(self) -> IntArray:
        """The inner edges (with two faces), as rows of the topology's edges, (#E,)."""
        return self.surface.topology.interior_edges

    @property
    def faces_of_edges(self) -> IntArray:
        """The two faces of each inner edge, (#E, 2)."""
        return self.surface.topology.interior_edge_faces

    @property
    def edge_ends(self) -> IntArray:
        """The vertices of each inner edge, (#E, 2)."""
        return self.surface.topology.interior_edge_ends

    def get_corners_at_edges(self, rows: IntArray | BoolArray) -> tuple[IntArray, IntArray]:
        """Return the corners at both ends of the inner edges `rows`, (2, #E), in the first and second face.

        Corner k of face t has the number 3 t + k.
        """
        corner, face = np.divmod(
            self.surface.topology.sides[:, self.interior_edges[rows]], len(self.surface.F)
        )
        a, b = (3 * face + (corner + k) % 3 for k in (1, 2))
        return np.stack((a[0], b[0])), np.stack((b[1], a[1]))

    def mask_sides(self, rows: IntArray | BoolArray | slice) -> BoolArray:
        """Return a mask, (#F, 3): `[f, k]` is True if side k to k + 1 of face f is an edge of `rows`."""
        surface = self.surface
        corner, face = np.divmod(surface.topology.sides[:, self.interior_edges[rows]], len(surface.F))
        sides = np.zeros(surface.F.shape, dtype=bool)
        sides[face, np.array(NEXT)[corner]] = True  # half-edge k of a face starts at corner k + 1
        return sides

    @cached_property
    def _edge_of_side(self) -> IntArray:
        """The inner edge of each half-edge, (3 #F,); -1 at the boundary."""
        row = np.full(3 * len(self.surface.F), -1)
        row[self.surface.topology.sides[:, self.interior_edges]] = np.arange(len(self.interior_edges))
        return row

    def find_edges_of_piece(self, piece: Submesh) -> IntArray:
        """Return the inner edges of a piece of the surface as rows of `interior_edges`."""
        corner, face = np.divmod(piece.topology.sides[0, piece.topology.interior_edges], len(piece.F))
        own = np.searchsorted(self.surface.faces, piece.faces[face])
        return np.asarray(self._edge_of_side[corner * len(self.surface.F) + own])

    @cached_property
    def is_in_atom(self) -> BoolArray:
        """Mask of the inner edges that page cuts do not use.

        These are the diagonals of polygons and, on a body with planes, the edges within a plane or within the
        fillets and chamfers around a large plane.
        """
        component = self.component_of_face[self.faces_of_edges[:, 0]]
        within, is_hard = self.is_coplanar, self.is_hard_surface[component]
        if is_hard.any():
            one, other = self.nearest_large_plane[self.faces_of_edges].T
            within = within | (one == other) & (one >= 0) & self.has_narrow_fillets[component]
        return np.asarray(is_hard & within | self._is_diagonal)

    @cached_property
    def _is_diagonal(self) -> BoolArray:
        """Mask of the inner edges that are diagonals of polygons."""
        if self.surface.inner is None:
            return np.zeros(len(self.interior_edges), dtype=bool)
        return ~np.isin(self.interior_edges, self.surface.cuttable_edges)

    @cached_property
    def is_boundary_side(self) -> BoolArray:
        """Mask, (#F, 3): `[f, k]` is True if the side from corner k to k + 1 of face f is on the boundary."""
        return ~self.mask_sides(slice(None))

    @cached_property
    def edge_length(self) -> FloatArray:
        """The length of each inner edge."""
        return lengths(self.surface.V, self.edge_ends)

    @cached_property
    def visible_length(self) -> FloatArray:
        """The length of each inner edge times its visibility factor, which is below 1 if a seam is hidden."""
        return np.asarray(self.edge_length * self.visibility_factor)

    @cached_property
    def search_price(self) -> FloatArray:
        """The `edge_price` of each inner edge in a search for seams.

        Cutting into a flat hole saves no stretch. Therefore the extent of the component is added to the price
        of an edge for each end at a flat hole, and the search finds seams that pass beside the hole.
        """
        if not len(self.flat_holes):
            return self.edge_price
        at_hole = np.zeros(len(self.surface.V), dtype=bool)
        at_hole[np.concatenate([self.surface.topology.loops[i] for i in self.flat_holes.tolist()])] = True
        return np.asarray(self.edge_price + at_hole[self.edge_ends].sum(axis=1) * self.extent_at_edge)

    @cached_property
    def flat_holes(self) -> IntArray:
        """The boundary loops of holes that would be flat if they were filled, as indices of `topology.loops`.

        By Gauss-Bonnet, the boundary of a hole in a developable surface turns by -2 pi. With more than
        `MAX_FLAT_HOLES` such holes, the array is empty, because the memory for a map grows with the number of
        uncut holes.
        """
        loops = self.surface.topology.loops
        if not loops:
            return np.zeros(0, dtype=np.int64)
        turning = np.pi - self.surface.angle_sums[np.concatenate(loops)]
        turns = Ragged.from_sizes(list(map(len, loops))).sum(turning)
        flat = np.flatnonzero(np.abs(turns + 2 * np.pi) < FLAT_HOLE_TURN)
        return flat if len(flat) <= MAX_FLAT_HOLES else flat[:0]

    @cached_property
    def visibility_factor(self) -> FloatArray:
        """Factor on each inner edge's length: above 1 if a seam there is visible, below 1 if it is hidden."""
        if self.hidden is None:
            return np.ones(len(self.faces_of_edges))
        return compute_visibility_factors(self.surface, self.edge_ends, self.edge_length, self.hidden)

    @cached_property
    def edge_price(self) -> FloatArray:
        """The prices of seams along the inner edges, see `compute_edge_prices`.

        An edge halfway between two planes, for example in the middle of a fillet, counts as a crease whose
        dihedral angle is the angle between the planes.
        """
        bend, is_hard = (
            self.crease_angle,
            self.is_hard_surface[self.component_of_face[self.faces_of_edges[:, 0]]],
        )
        if is_hard.any():
            one, other = self.nearest_large_plane[self.faces_of_edges].T
            rows = np.flatnonzero(is_hard & (one >= 0) & (other >= 0) & (one != other))
            cosine = (self._plane_normals[one[rows]] * self._plane_normals[other[rows]]).sum(axis=1)
            bend = bend.copy()
            bend[rows] = np.maximum(bend[rows], np.arccos(np.clip(cosine, -1, 1)))
        return compute_edge_prices(self.visible_length, bend, is_hard)

    @cached_property
    def is_hard_surface(self) -> BoolArray:
        """Mask of the components with a large share of flat area, such as machine parts."""
        return np.asarray(self.flat_share >= constants.PLANAR_SHARE)

    @cached_property
    def plane_of_face(self) -> IntArray:
        """The number of the plane that contains each face. Connected coplanar faces are in one plane."""
        return connected_labels(self.faces_of_edges[self.is_coplanar], len(self.surface.F))

    @cached_property
    def is_in_large_plane(self) -> BoolArray:
        """Mask of the faces in large planes, which are larger than all smoothly adjacent planes."""
        number = int(self.plane_of_face.max()) + 1
        area, whole = (
            sum_by_index(self.plane_of_face, self.surface.areas_and_products[0], number),
            np.empty(number),
        )
        whole[self.plane_of_face] = self.component_double_area[self.component_of_face]
        pairs = self.plane_of_face[self.faces_of_edges[~self.is_sharp]]
        pairs, beside = pairs[pairs[:, 0] != pairs[:, 1]], np.zeros(number)
        for one, other in (pairs.T, pairs[:, ::-1].T):
            np.maximum.at(beside, one, area[other])
        least = np.maximum(MIN_PLANE_SHARE * whole, PLANE_OVER_NEIGHBOURS * beside)
        return np.asarray((area >= least)[self.plane_of_face])

    @cached_property
    def nearest_large_plane(self) -> IntArray:
        """The large plane that each face can be reached from with the least turning of the normal, or -1."""
        blunt, m = self.crease_angle <= MAX_CHAMFER_ANGLE, len(self.surface.F)
        turn = (self.crease_angle + TURN_OF_EXTENT * self.edge_length / self.extent_at_edge)[blunt]
        indptr, indices, edge = shortest_edges(self.faces_of_edges[blunt], turn, m)
        everywhere, planes = np.ones(m, dtype=bool), np.flatnonzero(self.is_in_large_plane)
        _, _, source = nearest_sources(indptr, indices, turn[edge], planes, everywhere, np.pi)
        nearest = np.where(source >= 0, self.plane_of_face[source], -1)
        normal = normals(self.surface.V, self.surface.topology.corner)
        cosine = (normal * self._plane_normals[nearest]).sum(axis=1)
        return np.where(cosine >= np.cos(MAX_FILLET_ANGLE), nearest, -1)

    @cached_property
    def has_narrow_fillets(self) -> BoolArray:
        """Mask of the components whose large planes are larger than the fillets and chamfers around them."""
        planes, near = (
            sum_by_index(
                self.component_of_face, mask * self.surface.areas_and_products[0], len(self.component_extent)
            )
            for mask in (self.is_in_large_plane, self.nearest_large_plane >= 0)
        )
        return np.asarray(2 * planes > near)

    @cached_property
    def _plane_normals(self) -> FloatArray:
        """The mean normal of each plane."""
        normal, number = (
            normals(self.surface.V, self.surface.topology.corner),
            int(self.plane_of_face.max()) + 1,
        )
        double_area = self.surface.areas_and_products[0]
        summed = np.stack(
            [sum_by_index(self.plane_of_face, double_area * x, number) for x in normal.T], axis=1
        )
        return np.asarray(summed / np.maximum(np.linalg.norm(summed, axis=1), np.finfo(float).tiny)[:, None])

    @cached_property
    def dihedral_angle(self) -> FloatArray:
        """The dihedral angles at the inner edges, see `compute_dihedral_angles`."""
        return compute_dihedral_angles(self.surface, self.component_extent[self.component_of_face])

    @cached_property
    def crease_angle(self) -> FloatArray:
        """The absolute dihedral angle at each inner edge; 0 at the diagonals of polygons."""
        return np.where(self._is_diagonal, 0.0, np.abs(self.dihedral_angle))

    @cached_property
    def is_coplanar(self) -> BoolArray:
        """Mask of the inner edges whose two faces are coplanar up to rounding of the coordinates."""
        double_area, dot = self.surface.areas_and_products
        height = double_area / np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
        noise = constants.COORDINATE_NOISE * self.extent_at_edge / np.minimum(*height[self.faces_of_edges.T])
        most = np.minimum(np.maximum(PLANE_BEND, 4 * noise), constants.MAX_BEND_ROUNDING)
        return np.asarray(self.crease_angle <= most)

    @cached_property
    def is_sharp(self) -> BoolArray:
        """Mask of the inner edges that are sharp creases."""
        return np.asarray(self.crease_angle >= SHARP_CREASE_ANGLE)

    @cached_property
    def vertex_curvature(self) -> FloatArray:
        """The absolute angle defect of each vertex; 0 on the boundary and where rounding may cause it."""
        surface, n = self.surface, len(self.surface.V)
        size = np.abs(2 * np.pi - surface.angle_sums)
        size[np.concatenate([*surface.topology.loops, np.zeros(0, dtype=np.int64)])] = 0.0
        turned = (
            constants.COORDINATE_NOISE
            * self.extent_at_edge
            / np.maximum(self.edge_length, np.finfo(float).tiny)
        )
        noise = np.bincount(self.edge_ends.ravel(), np.repeat(turned, 2), n)
        return np.where(size > noise, size, 0.0)

    @cached_property
    def extent_at_edge(self) -> FloatArray:
        """The extent of the component of each inner edge, (#E,)."""
        return np.asarray(self.component_extent[self.component_of_face[self.faces_of_edges[:, 0]]])

    @cached_property
    def is_on_crease(self) -> BoolArray:
        """Mask of the vertices on sharp creases, or on any creases of a body with planes."""
        crease = (
            self.is_sharp
            | (self.crease_angle >= CREASE_ANGLE)
            & self.is_hard_surface[self.component_of_face[self.faces_of_edges[:, 0]]]
        )
        on_crease = np.zeros(len(self.surface.V), dtype=bool)
        on_crease[self.edge_ends[crease]] = True
        return on_crease

    @cached_property
    def is_on_sharp_crease(self) -> BoolArray:
        """Mask of the vertices on sharp creases."""
        on_sharp = np.zeros(len(self.surface.V), dtype=bool)
        on_sharp[self.edge_ends[self.is_sharp]] = True
        return on_sharp

    @cached_property
    def is_apex(self) -> BoolArray:
        """Mask of the vertices that are tips and not on sharp creases, see `find_apexes`."""
        on_soft = np.zeros(len(self.surface.V), dtype=bool)
        on_soft[self.edge_ends[self.crease_angle > CREASE_ANGLE]] = True
        return find_apexes(self.vertex_curvature, self.edge_ends, self.is_on_sharp_crease, on_soft)

    @cached_property
    def component_double_area(self) -> FloatArray:
        """Twice the area of each component."""
        return sum_by_index(
            self.component_of_face, self.surface.areas_and_products[0], len(self.component_extent)
        )

    @cached_property
    def flat_share(self) -> FloatArray:
        """The share of each component's area that is flat, see `compute_flat_shares`."""
        return compute_flat_shares(self.surface, self.component_of_face, self.dihedral_angle)

    def sum_per_component(self, vertices: BoolArray, weight: FloatArray | None = None) -> FloatArray:
        """Return for each component the number of vertices in a mask, or the sum of their weights."""
        own = None if weight is None else weight[vertices]
        return np.asarray(np.bincount(self._component_of_vertex[vertices], own, len(self.component_extent)))

    @cached_property
    def _component_of_vertex(self) -> IntArray:
        """The component of each vertex."""
        of = np.empty(len(self.surface.V), dtype=np.int64)
        of[self.surface.F] = self.component_of_face[:, None]
        return of

    @cached_property
    def n_loops(self) -> IntArray:
        """The number of boundary loops of each component."""
        first = np.array([loop[0] for loop in self.surface.topology.loops], dtype=np.int64)
        return np.asarray(np.bincount(self._component_of_vertex[first], minlength=len(self.component_extent)))

    @cached_property
    def may_have_panels(self) -> BoolArray:
        """Mask of the components that may be divided into panels.

        Components with needle-shaped faces are excluded, as are disks that are nearly but not exactly flat.
        """
        surface, everywhere = self.surface, np.ones(len(self.surface.V), dtype=bool)
        gain = self.sum_per_component(everywhere, (self.vertex_curvature / (2 * np.pi)) ** 2)
        double_area, dot = surface.areas_and_products
        needle = double_area <= MIN_CHART_HEIGHT * (dot[NEXT] + dot[PREV]).max(axis=0)
        may = (self.n_loops != 1) | (gain == 0) | (gain > MIN_DISK_CURVATURE)
        may &= np.bincount(self.component_of_face[needle], minlength=len(self.component_extent)) == 0
        return np.asarray(may)
