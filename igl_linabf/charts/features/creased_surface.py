"""A surface with creases: its dihedral angles, its sharp creases, and where it is curved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._core import lengths
from ..._types import BoolArray, FloatArray, IntArray
from ...surface import NEXT, PREV, Submesh, sum_by
from . import constants
from .curvature import apexes, component_extents, dihedral_angles, flat_shares
from .visibility import hiding_factor_between


@dataclass(frozen=True, eq=False)
class CreasedSurface:
    """A surface of several components, its creases and its curvature.

    Attributes
    ----------
    surface : Submesh
    hidden : (#F',) float64 or None
        How well each of the caller's faces hides a seam: `hiding_weights`.
    """

    surface: Submesh
    hidden: FloatArray | None = None

    @property
    def label(self) -> IntArray:
        """The component of each face."""
        return self.surface.label

    @cached_property
    def extent(self) -> FloatArray:
        """The longest side of the bounding box of each component."""
        return component_extents(self.surface, self.label)

    @property
    def inside(self) -> IntArray:
        """The edges with two faces, as rows of the topology's edges, (#E,)."""
        return self.surface.topology.inside

    @property
    def faces(self) -> IntArray:
        """The two faces of each of them, (#E, 2)."""
        return self.surface.topology.faces_inside

    @property
    def ends(self) -> IntArray:
        """The vertices of each, (#E, 2)."""
        return self.surface.topology.edges_inside

    def sides(self, rows: IntArray | BoolArray) -> tuple[IntArray, IntArray]:
        """The ends of such edges as rows of the raveled corners of all faces: (2, #E) in either face."""
        corner, face = np.divmod(self.surface.topology.sides[:, self.inside[rows]], len(self.surface.F))
        a, b = (3 * face + (corner + k) % 3 for k in (1, 2))
        return np.stack((a[0], b[0])), np.stack((b[1], a[1]))

    def side_mask(self, rows: IntArray | BoolArray | slice) -> BoolArray:
        """Which sides, from corner k to k + 1 of a face, are such edges: (#F, 3) bool."""
        surface = self.surface
        corner, face = np.divmod(surface.topology.sides[:, self.inside[rows]], len(surface.F))
        sides = np.zeros(surface.F.shape, dtype=bool)
        sides[face, np.array(NEXT)[corner]] = True  # half-edge (k, t) is the side k + 1 of t
        return sides

    @cached_property
    def boundary_sides(self) -> BoolArray:
        """Which sides are on the boundary, (#F, 3)."""
        return ~self.side_mask(slice(None))

    @cached_property
    def length(self) -> FloatArray:
        """The lengths of the edges with two faces."""
        return lengths(self.surface.V, self.ends)

    @cached_property
    def visible_length(self) -> FloatArray:
        """The lengths that count for seams: shorter where the two faces hide them."""
        if self.hidden is None:
            return self.length
        return np.asarray(self.length * hiding_factor_between(self.hidden[self.surface.faces[self.faces]]))

    @cached_property
    def dihedral(self) -> FloatArray:
        """The `dihedral_angles` at the edges with two faces."""
        return dihedral_angles(self.surface, self.extent[self.label])

    @cached_property
    def crease_angle(self) -> FloatArray:
        """Their absolute values; 0 at the diagonals of polygons."""
        size = np.abs(self.dihedral)
        if self.surface.inner is not None:
            size[~np.isin(self.inside, self.surface.cuttable_edges)] = 0.0
        return np.asarray(size)

    @cached_property
    def in_one_plane(self) -> BoolArray:
        """Which edges have two faces in one plane, as far as coordinates tell."""
        double_area, dot = self.surface.measured
        height = double_area / np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
        noise = constants.COORDINATE_NOISE * self.edge_extent / np.minimum(*height[self.faces.T])
        most = np.minimum(np.maximum(constants.PLANE_BEND, 4 * noise), constants.MAX_BEND_ROUNDING)
        return np.asarray(self.crease_angle <= most)

    @cached_property
    def sharp(self) -> BoolArray:
        """Which edges are sharp creases."""
        return np.asarray(self.crease_angle >= constants.SHARP_CREASE_ANGLE)

    @cached_property
    def curvature(self) -> FloatArray:
        """The absolute angle defect of each vertex; 0 on the boundary, and where rounding may make it."""
        surface, n = self.surface, len(self.surface.V)
        size = np.abs(2 * np.pi - surface.angle_sums)
        size[np.concatenate([*surface.topology.loops, np.zeros(0, dtype=np.int64)])] = 0.0
        turned = constants.COORDINATE_NOISE * self.edge_extent / np.maximum(self.length, np.finfo(float).tiny)
        noise = np.bincount(self.ends.ravel(), np.repeat(turned, 2), n)
        return np.where(size > noise, size, 0.0)

    @cached_property
    def edge_extent(self) -> FloatArray:
        """The extent of the component of each edge."""
        return np.asarray(self.extent[self.label[self.faces[:, 0]]])

    @cached_property
    def on_sharp(self) -> BoolArray:
        """Which vertices are on sharp creases."""
        on_sharp = np.zeros(len(self.surface.V), dtype=bool)
        on_sharp[self.ends[self.sharp]] = True
        return on_sharp

    @cached_property
    def is_apex(self) -> BoolArray:
        """Which vertices off sharp creases are tips: `apexes`."""
        return apexes(self.curvature, self.ends, self.on_sharp, self.on_crease)

    @cached_property
    def on_crease(self) -> BoolArray:
        """Which vertices are on creases."""
        on_crease = np.zeros(len(self.surface.V), dtype=bool)
        on_crease[self.ends[self.crease_angle > constants.CREASE_ANGLE]] = True
        return on_crease

    @cached_property
    def double_area(self) -> FloatArray:
        """Twice the area of each component."""
        return sum_by(self.label, self.surface.measured[0], len(self.extent))

    @cached_property
    def flat_share(self) -> FloatArray:
        """The `flat_shares` of the components."""
        return flat_shares(self.surface, self.label)

    def per_component(self, vertices: BoolArray, weight: FloatArray | None = None) -> FloatArray:
        """How many of some vertices each component has, or the sum of their weights."""
        own = None if weight is None else weight[vertices]
        return np.asarray(np.bincount(self._of_vertex[vertices], own, len(self.extent)))

    @cached_property
    def _of_vertex(self) -> IntArray:
        """The component of each vertex."""
        of = np.empty(len(self.surface.V), dtype=np.int64)
        of[self.surface.F] = self.label[:, None]
        return of

    @cached_property
    def n_loops(self) -> IntArray:
        """The number of boundary loops of each component."""
        first = np.array([loop[0] for loop in self.surface.topology.loops], dtype=np.int64)
        return np.asarray(np.bincount(self._of_vertex[first], minlength=len(self.extent)))

    @cached_property
    def is_disk(self) -> BoolArray:
        """Which components are disks."""
        edges = np.bincount(self._of_vertex[self.surface.topology.edges[:, 0]], minlength=len(self.extent))
        vertices = self.per_component(np.ones(len(self.surface.V), dtype=bool))
        return np.asarray(vertices - edges + np.bincount(self.label) == 1)

    @cached_property
    def may_fall_apart(self) -> BoolArray:
        """Which components may fall into panels: those without needles, that are no nearly flat disks.

        A disk that is not curved at all may, too.
        """
        surface, everywhere = self.surface, np.ones(len(self.surface.V), dtype=bool)
        gain = self.per_component(everywhere, (self.curvature / (2 * np.pi)) ** 2)
        double_area, dot = surface.measured
        needle = double_area <= constants.MIN_CHART_HEIGHT * (dot[NEXT] + dot[PREV]).max(axis=0)
        may = (self.n_loops != 1) | (gain == 0) | (gain > constants.MIN_DISK_CURVATURE)
        may &= np.bincount(self.label[needle], minlength=len(self.extent)) == 0
        return np.asarray(may)
