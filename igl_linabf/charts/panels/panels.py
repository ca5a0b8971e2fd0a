"""Find panels, the regions between creases, flatten them, and join them edge to edge.

If all curved vertices of a component are on sharp creases, its panels are planes, cylinders and cones. A net
of the panels is built greedily: starting with the longest creases, two panels are joined along their common
crease unless faces would overlap. Creases along which panels are not joined are seams.

Machine parts also have fillets and chamfers. A fillet ends in corners whose curvature is spread over many
vertices, and no net passes through all of these vertices. However, the planes on the two sides of a fillet
are panels: each plane is extended by half of the fillet, and the middle of the fillet is a crease between the
two panels. A plane is likewise extended by its chamfers. Panels are joined along such rounded creases as
along sharp creases, but with larger tolerances. The curved vertices are then on the boundaries of charts, or
curved so little that a chamfer is hardly stretched beside its plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..._core import merge_regions
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import (
    NEXT,
    Submesh,
    connected_labels,
    cut_faces,
    drop_unused_vertices,
    label_face_components,
    sum_by_index,
)
from ..cut_graphs import ClosedSurface, join_terminals, open_handles
from ..features import TIP_CURVATURE, CreasedSurface
from . import constants
from .unfolding import compute_overlap_depths, find_joints, find_upright_turns, unfold_panels

# Minimum dihedral angle of an edge that separates panels. No regular prism has exactly this angle.
PANEL_ANGLE = np.deg2rad(4.9)
MAX_CREASE_GAP = 1e-5  # maximum gap between two panels joined at a crease, relative to the component's extent
# Overlaps of panels up to this depth, relative to the extent, are due to single-precision rounding.
MAX_OVERLAP_DEPTH = 2e-6
# Rigid motions that differ by less count as equal: rotation in radians, translation relative to the extent.
SAME_MOTION = 1e-3
PLANAR_SHARE_OF_ROUNDED = 0.3  # minimum share of a component's area in large planes, for rounded creases
ROUNDED_PLAY = 2e-3  # maximum gap and overlap depth at rounded creases, relative to the extent
ROUNDED_PLAY_OF_EDGE = 0.1  # maximum gap at an edge of a rounded crease, relative to the edge's length
ROUNDED_DEPTH_OF_HEIGHT = 0.3  # maximum overlap depth of a fillet's face, relative to the height of the face
SAME_ROUNDED_MOTION = 1e-2  # `SAME_MOTION` at rounded creases


@dataclass(frozen=True, eq=False)
class Panels:
    """The panels of a surface with sharp creases.

    Attributes
    ----------
    creased : CreasedSurface
    same_motion : float
        Maximum difference of two rigid motions that count as equal: of the rotation in radians, and of the
        translation relative to the extent.
    opens_handles : bool
        Whether panels may have handles. If so, seams cut the handles open.
    """

    creased: CreasedSurface
    same_motion: ClassVar[float] = SAME_MOTION
    opens_handles: ClassVar[bool] = False

    @cached_property
    def is_fold(self) -> BoolArray:
        """Mask of the inner edges that separate panels."""
        return np.asarray(self.creased.crease_angle >= PANEL_ANGLE)

    @cached_property
    def is_terminal(self) -> BoolArray:
        """Mask of the curved vertices, which seams have to reach."""
        return np.asarray(self.creased.vertex_curvature > 0)

    @cached_property
    def is_unclosed(self) -> BoolArray:
        """Mask of the inner edges where the two sides of an unfolded panel do not meet, as in a cylinder."""
        creased, rows = self.creased, np.flatnonzero(~self.is_fold)
        z = unfold_panels(creased, ~self.is_fold).ravel()
        one, other = creased.get_corners_at_edges(rows)
        made = np.zeros_like(self.is_fold)
        made[rows] = (np.abs(z[one] - z[other]) > self.get_max_gaps(rows)).any(axis=0)
        return made

    def get_max_gaps(self, rows: IntArray | BoolArray) -> FloatArray:
        """Return the maximum gap between the two sides of each of the joined edges `rows`."""
        return np.asarray(MAX_CREASE_GAP * self.creased.extent_at_edge[rows])

    def get_max_depths(self, z: ComplexArray) -> FloatArray:
        """Return the depth up to which overlaps of each face are ignored; `z` has the unfolded corners."""
        extent = self.creased.component_extent[self.creased.component_of_face]
        return compute_overlap_depths(z, extent, MAX_OVERLAP_DEPTH)

    def mask_panel_components(self) -> BoolArray:
        """Return a mask of the components that consist of panels: curved vertices are tips or on creases."""
        creased, bent = self.creased, self.creased.vertex_curvature
        smooth = (bent > 0) & ~creased.is_on_crease
        made = np.asarray(creased.sum_per_component(smooth & (bent <= TIP_CURVATURE)) == 0)
        if made.any():
            made &= creased.sum_per_component(smooth & ~creased.is_apex) == 0
        if made.any():
            made &= creased.may_have_panels
            made &= (creased.n_loops > 0) | (creased.sum_per_component(creased.is_on_sharp_crease) > 0)
        return made


@dataclass(frozen=True, eq=False)
class RoundedPanels(Panels):
    """The panels of a surface with rounded creases, such as the fillets and chamfers of machine parts."""

    same_motion: ClassVar[float] = SAME_ROUNDED_MOTION
    opens_handles: ClassVar[bool] = True

    @cached_property
    def is_fold(self) -> BoolArray:
        """Mask of the inner edges that separate panels: middles of fillets, and sharp creases elsewhere."""
        one, other = self.creased.nearest_large_plane[self.creased.faces_of_edges].T
        return np.asarray((one != other) | self.creased.is_sharp & (one < 0))

    @cached_property
    def is_unclosed(self) -> BoolArray:
        return np.asarray(
            ~self.is_fold & (self.creased.nearest_large_plane[self.creased.faces_of_edges] < 0).any(axis=1)
        )

    @cached_property
    def is_terminal(self) -> BoolArray:
        return np.asarray(self.creased.vertex_curvature > TIP_CURVATURE)

    def get_max_gaps(self, rows: IntArray | BoolArray) -> FloatArray:
        extent, length = self.creased.extent_at_edge[rows], self.creased.edge_length[rows]
        play = np.minimum(ROUNDED_PLAY * extent, ROUNDED_PLAY_OF_EDGE * length)
        return np.maximum(super().get_max_gaps(rows), play)

    def get_max_depths(self, z: ComplexArray) -> FloatArray:
        shallow = np.where(
            self.creased.is_in_large_plane, constants.MAX_DEPTH_OF_HEIGHT, ROUNDED_DEPTH_OF_HEIGHT
        )
        return compute_overlap_depths(
            z, self.creased.component_extent[self.creased.component_of_face], ROUNDED_PLAY, shallow
        )

    def mask_panel_components(self) -> BoolArray:
        """Return a mask of the components with creases and with much of their area in large planes."""
        creased = self.creased
        made = creased.may_have_panels
        if made.any():
            large = np.where(self.creased.is_in_large_plane, creased.surface.areas_and_products[0], 0.0)
            least = PLANAR_SHARE_OF_ROUNDED * creased.component_double_area
            made = made & (sum_by_index(creased.component_of_face, large, len(made)) >= least)
        if made.any():
            made &= (
                np.bincount(
                    creased.component_of_face[creased.faces_of_edges[self.is_fold, 0]], minlength=len(made)
                )
                > 0
            )
        return made


def find_panel_seams(panels: Panels, trade: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Return seams for components that consist of panels; after cutting, every panel can be flattened.

    No seam ends at a hole of a flat panel, and the seam of a cylinder or cone passes beside its holes. A seam
    that ends at a hole would be visible, and would weaken a sheet.

    Parameters
    ----------
    panels : Panels
    trade : float
        Seam length, in square roots of the area, that is worth a decrease of the L2 stretch by 1.

    Returns
    -------
    edges : (#E, 2) int64
        The edges of the seams, as pairs of input vertices.
    component : (#E,) int64
        The component of each edge.
    cost : (#C,) float64
        The price of the seams of each component, divided by `trade`; infinite if a panel has uncut handles.
    """
    creased, fold = panels.creased, panels.is_fold
    slit, handles = _find_slits(panels, fold, panels.is_unclosed)
    seam = (
        slit | find_unjoined_folds(panels, unfold_panels(creased, ~fold & ~slit), trade)
        if fold.any()
        else slit
    )
    if seam.any():
        # joined panels lie flat side by side, so the charts keep the holes between them
        seam |= _find_slits(panels, seam, np.zeros_like(slit))[0]
    component = creased.component_of_face[creased.faces_of_edges[seam, 0]]
    price = sum_by_index(component, creased.search_price[seam], len(creased.component_extent))
    cost = price / np.sqrt(creased.component_double_area / 2) / trade
    cost[creased.component_of_face[handles]] = np.inf
    return creased.surface.vertices[creased.edge_ends[seam]], component, cost


def find_unjoined_folds(panels: Panels, z: ComplexArray, trade: float) -> BoolArray:
    """Return a mask of the creases that become seams, because the panels on both sides are not joined.

    `z` has the positions of the corners of each face, (#F, 3), in the unfolded panel.
    """
    creased, fold = panels.creased, panels.is_fold
    panel = connected_labels(creased.faces_of_edges[~fold], len(creased.surface.F))
    order = np.argsort(panel, kind="stable")
    start = np.searchsorted(panel[order], np.arange(int(panel.max()) + 2))
    z = z * find_upright_turns(z, order, panel)[panel, None]
    joins = find_joints(creased, fold, panel, z, panels.same_motion, trade)
    chart, turn, shift = merge_regions(z[order], panels.get_max_depths(z)[order], start, *joins)
    z = turn[panel, None] * z + shift[panel, None]
    one, other = creased.get_corners_at_edges(fold)
    a, b = creased.faces_of_edges[fold].T
    fits = chart[panel[a]] == chart[panel[b]]
    fits &= (np.abs(z.ravel()[one] - z.ravel()[other]) <= panels.get_max_gaps(fold)).all(axis=0)
    seam = np.zeros_like(fold)
    seam[np.flatnonzero(fold)[~fits]] = True
    return seam


def _find_slits(panels: Panels, cut: BoolArray, unclosed: BoolArray) -> tuple[BoolArray, IntArray]:
    """Return a mask of the edges that cut the panels into disks with all terminals on the boundary.

    `cut` marks the edges between panels. Panels without an edge in `unclosed` keep their holes. Also return
    the faces of the panels whose handles are not cut open.
    """
    creased, surface = panels.creased, panels.creased.surface
    slit, handles = np.zeros(len(cut), dtype=bool), np.zeros(0, dtype=np.int64)
    sides = creased.mask_sides(cut)
    F, origin = cut_faces(surface.F, len(surface.V), surface.topology.sides, sides)
    n, sides = len(origin), sides | creased.is_boundary_side
    label = label_face_components(F, n)
    of_vertex, tip = np.empty(n, dtype=np.int64), panels.is_terminal[origin]
    of_vertex[F], tip[F[sides]], tip[F[:, NEXT][sides]] = label[:, None], False, False
    vertices, faces, rim, tips = (
        np.bincount(of, minlength=int(label.max()) + 1)
        for of in (of_vertex, label, label[np.nonzero(sides)[0]], of_vertex[tip])
    )
    characteristic = vertices - (3 * faces + rim) // 2 + faces
    wanted = (characteristic != 1) | (tips > 0)
    if not wanted.any():
        return slit, handles
    rows = np.flatnonzero(wanted[label])
    used, F = drop_unused_vertices(F[rows], n)
    inner = None if surface.inner is None else surface.inner[rows]
    part = Submesh(surface.V[origin[used]], F, rows, used, n, inner)
    first = used[np.array([loop[0] for loop in part.topology.loops], dtype=np.int64)]
    loops = np.bincount(of_vertex[first], minlength=len(vertices))
    handled, closed = wanted & (characteristic + loops != 2), loops == 0
    if panels.opens_handles:
        alone, stays = np.flatnonzero(handled), closed & ~handled
    else:
        alone, stays = np.zeros(0, dtype=np.int64), closed | handled
    handles, of = rows[stays[label[rows]]], label[rows]
    opened = ~np.isin(of, alone)
    flat = ~handled & ~closed & (tips == 0)
    flat[label[creased.faces_of_edges[unclosed]]] = False
    opened &= ~flat[of]
    parts = [part.select_faces(np.flatnonzero(of == k)) for k in alone]
    if opened.any():
        parts.append(part if opened.all() else part.select_faces(np.flatnonzero(opened)))
    if not parts:
        return slit, handles
    ends, n = (
        origin[np.concatenate([_find_opening(part, tip, creased.hidden) for part in parts])],
        len(surface.V),
    )
    known, given = (np.minimum(*e.T) * n + np.maximum(*e.T) for e in (creased.edge_ends, ends))
    slit[np.searchsorted(known, given)] = True
    return slit, handles


def _find_opening(part: Submesh, tip: BoolArray, hidden: FloatArray | None) -> IntArray:
    """Return the edges, (#E, 2), that cut all components of `part` open; only a single one may have handles.

    `tip` is a mask of the vertices, (n,), that the edges have to reach. The edges pass beside flat holes.
    """
    creased = CreasedSurface(part, hidden)
    piece = ClosedSurface.from_creased_surface(creased)
    loops = open_handles(piece, 1) if piece.graph.genus else np.zeros(0, dtype=np.int64)
    seam = join_terminals(piece.graph, loops, piece.node[tip[part.vertices]], creased.flat_holes)
    return part.vertices[piece.edges[seam]]
