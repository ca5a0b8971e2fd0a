"""Find seams, the edges along which a surface is cut open before it is flattened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..._types import FloatArray, IntArray
from ...errors import SingularSystemError, is_number, takes_vertices_and_faces
from ...flattening import Isometric, Method, resolve_method
from ...measures import find_overlapping_pairs_of_chart, measure_change
from ...surface import (
    Submesh,
    build_manifold_topology,
    cut_faces,
    drop_unused_vertices,
    face_array,
    make_seam_mask,
    vertex_array,
)
from ..atlas import compute_division_price, flatten_piece
from ..cut_graphs import ClosedSurface, Levels, get_stretch_weight
from ..features import CreasedSurface, Hiding, compute_flat_shares, compute_hiding_weights
from ..panels import Panels, RoundedPanels, find_panel_seams
from ..splitting import split_overlaps
from . import constants
from .growth import compute_seam_cost, grow_seam, keep_seam_if_worth, shorten_seam
from .small_bodies import SmallBodies

# Factor on `trade` for surfaces contracted to clusters, whose seams are later pulled tight and get shorter.
CLUSTER_TRADE_FACTOR = 1.6
CHEAP_PANELS = 0.1  # accept seams around panels up to this cost without searching for cheaper seams
MAX_FACES_OF_SMALL_BODY = 100  # maximum number of faces of a small component
MIN_SMALL_BODIES = 8  # minimum number of small components that are processed in one batch
MAX_FACES_OF_MEDIUM_BODY = 2_000  # maximum number of faces of a medium-sized component
MIN_MEDIUM_BODIES = 100  # number of components from which medium-sized components are batched, too
MAX_FLAT_SHARE_OF_SMOOTH_BODY = 0.1  # maximum flat share of the area of a batched medium-sized component


@takes_vertices_and_faces
def cut(V: ArrayLike, F: ArrayLike, seams: ArrayLike) -> tuple[FloatArray, IntArray, IntArray]:
    """Cut a surface along edges, as `igl.cut_mesh` does, with checked input.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, loops and handles.
    seams : (#E, 2) int, or (#F, 3) bool
        The edges, as pairs of vertices, or a mask: `[f, k]` is True if the edge from `F[f, k]` to
        `F[f, k + 1]` is a seam. It suffices to mark one of the edge's two sides. Boundary edges have no
        effect, and neither does a single edge between interior vertices.

    Returns
    -------
    V : (#V', 3) float64
        The given vertices, then the copies made along the seams.
    F : (#F, 3) int64
        The same faces, with corners in the same order.
    origin : (#V',) int64
        The original vertex of each new vertex.

    Raises
    ------
    MeshError
        The arrays are malformed, the surface is not an oriented manifold, or a pair is not an edge.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> V_cut, F_cut, origin = cut(V, F, find_seams(V, F))
    >>> len(igl.boundary_loop_all(F_cut)), igl.euler_characteristic(F_cut)
    (1, 1)
    >>> bool((V_cut == V[origin]).all())
    True
    """
    positions, faces = vertex_array(V), face_array(F)
    vertices, packed = drop_unused_vertices(faces, len(positions))
    sides, n = build_manifold_topology(packed, vertices).sides, len(positions)
    F_cut, origin = cut_faces(faces, n, sides, make_seam_mask(seams, faces, n))
    return positions[origin], F_cut, origin


@takes_vertices_and_faces
def find_seams(
    V: ArrayLike,
    F: ArrayLike,
    *,
    method: str | Method = "isometric",
    trade: float = constants.TRADE,
    keep_holes: bool = False,
    disks: bool = False,
    hide: Hiding | None = None,
) -> IntArray:
    """Find the short seams along which `unwrap` cuts a surface.

    A component that consists of panels (planes, cylinders and cones between creases, and planes with rounded
    creases) is cut along seams that let all panels lie flat, if these seams cost less than a tree of seams.

    On every other component a tree of seams is grown. Handles are opened along short loops through one point
    (shortest-path tree and cotree of Erickson, Whittlesey 2005). Holes are joined by a tree of shortest
    paths. Then branches are added one by one. Each branch is a shortest path from the seam to the point where
    the scale of the conformal map is farthest from 1, such as a tip that would shrink (one Laplace system per
    branch, as in boundary first flattening). With "isometric", it leads to the point where the stretch
    decreases most relative to the length of the branch. A branch is kept if the stretch that it saves is
    worth its length. Finally, branch points move if a shorter seam is worth the change of stretch. A surface
    of more than 6,000 vertices is first contracted to clusters of vertices, on which the seam is found; the
    seam is then pulled tight along the edges of the surface.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, loops and handles.
    method : str or method object
        The method that `unwrap` will use. With "isometric", the stretch of the isometric map counts six
        times, because it is about a sixth of the stretch of the conformal map.
    trade : float
        Seam length, in units of the square root of the component's area, that is worth a decrease of the L2
        stretch by 1. Edges along creases count less: a crease of 90 degrees counts half and, on bodies with
        planes, a sharp crease (40 degrees or more) 0.15 of that. With 0, only the seams are cut that are
        needed to obtain disks. With a large value, branches are added as long as the expected stretch falls,
        at most 100 per component.
    keep_holes : bool
        Do not cut from hole to hole: each component becomes a disk with holes, and planes keep their holes.
    disks : bool
        Also cut components that are disks if the saved stretch is worth the seam, as `unwrap` does. By
        default disks stay whole.
    hide : (3,) or (#F,) float, or "back", optional
        Where seams are hidden: a direction in which hidden faces look, such as `[0, 0, -1]` for the underside
        if z is up, or a weight for each face, larger where a seam is hidden better. Weights are scaled to the
        range from -1 to 1. An edge in full view counts three times its length, and a hidden edge a third of
        its length. "back" is the side of each body with the least detail, such as the back of a head. An edge
        in front then counts twice its length.

    Returns
    -------
    seams : (#E, 2) int64
        Vertices of the edges, in the form that `cut` takes. Each component is cut into pieces that can be
        flattened: panels joined edge to edge, or one disk. A smooth component without handles becomes one
        disk.

    Raises
    ------
    MeshError
        The arrays are malformed, the surface is not an oriented manifold, or a face is degenerate.
    ValueError
        `trade` is negative or not a number.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> find_seams(V, F[1:]).shape  # a disk
    (0, 2)
    >>> find_seams(V, F, trade=0).shape  # a path from one vertex to the opposite one
    (3, 2)
    """
    check_trade(trade)
    surface = Submesh.manifold_from_input(V, F)
    hidden = compute_hiding_weights(surface, hide, np.arange(len(surface.F)))
    search = SeamSearch(trade, resolve_method(method), keep_holes, hidden)
    return search.find_seams(surface) if disks else search.find_needed_seams(surface)


def check_trade(trade: float) -> None:
    """Raise a `ValueError` if `trade` is not a number of at least 0."""
    if not is_number(trade, 0):
        raise ValueError(f"trade is {trade!r}: use a number, 0 (shortest seams) or larger")


Shape = tuple[Submesh, int, int]  # a component, its number of boundary loops, and its number of handles


@dataclass(frozen=True, eq=False)
class SeamSearch:
    """The search for the seams of a surface.

    Attributes
    ----------
    trade : float
        Seam length, in square roots of the area, that is worth a decrease of the L2 stretch by 1.
    keep_holes : bool
        Whether holes stay uncut.
    method : Method
        The method that will flatten the surface.
    hidden : (#F,) float64 or None
        How well each input face hides a seam, from -1 to 1 (see `compute_hiding_weights`).
    """

    trade: float
    method: Method
    keep_holes: bool = False
    hidden: FloatArray | None = None

    def find_seams(self, surface: Submesh) -> IntArray:
        """Return the seam edges of a checked manifold, (#E, 2), as pairs of input vertices.

        A disk is cut only if the saved stretch exceeds the price of the seam by `DISK_GAIN`. A component that
        keeps its holes is cut only around panels.
        """
        return self._find_seams(surface, only_needed=False)

    def find_needed_seams(self, surface: Submesh) -> IntArray:
        """Return the same edges as `find_seams`, but without the seams of components that are disks."""
        return self._find_seams(surface, only_needed=True)

    def _find_seams(self, surface: Submesh, only_needed: bool) -> IntArray:
        shapes, creased = _list_shapes(surface), CreasedSurface(surface, self.hidden)
        panels = self._find_panel_seams(creased, len(shapes))
        found, small = [panels.edges[:0]], list[int]()
        is_small = _find_small_components(surface, shapes)
        for k, (component, loops, genus) in enumerate(shapes):
            is_open = genus == 0 and (loops == 1 or (self.keep_holes and loops > 1))
            if is_open and (only_needed or not self.trade):
                continue
            if panels.cost[k] <= CHEAP_PANELS:
                found.append(panels.select_component(k))
                continue
            if is_small[k] and not (is_open and loops > 1):
                small.append(k)
                continue
            own = creased if component is surface else CreasedSurface(component, self.hidden)
            if is_open and loops > 1:
                if panels.cost[k] < np.inf and panels.cost[k] < self._measure_cost(own, panels.edges[:0]):
                    found.append(panels.select_component(k))
            else:
                found.append(self._find_seam_of_component(own, is_open, panels, k))
        if small:
            rows = np.concatenate([shapes[k][0].faces for k in small])
            bodies = SmallBodies(
                surface.select_faces(np.searchsorted(surface.faces, np.sort(rows))), self.hidden
            )
            edges, body, costs = bodies.find_seams(self.trade, self.keep_holes)
            in_panels = panels.cost[small] < costs
            found += [panels.select_component(small[b]) for b in np.flatnonzero(in_panels).tolist()]
            found.append(edges[~in_panels[body]])
        return np.concatenate(found)

    def _make_closed_surface(self, creased: CreasedSurface) -> ClosedSurface:
        return ClosedSurface.from_creased_surface(creased, isinstance(self.method, Isometric))

    def _find_seam_of_component(
        self, creased: CreasedSurface, is_open: bool, panels: _PanelSeams, k: int
    ) -> IntArray:
        """Return the seam edges of component k: a tree of seams or, if it costs less, seams around panels.

        On large components, the tree is found on clusters of nodes. If the component `is_open`, it could stay
        whole, and the tree is discarded unless it is worth its price.
        """
        closed = self._make_closed_surface(creased)
        levels = Levels.from_surface(closed)
        trade = self.trade * (CLUSTER_TRADE_FACTOR if levels.steps else 1.0)
        coarse, leaves = grow_seam(levels.coarse, trade, self.keep_holes)
        coarse = shorten_seam(levels.coarse, coarse, trade)
        if is_open:
            coarse = keep_seam_if_worth(levels.coarse, coarse, trade)
        seam = levels.lift(coarse, np.intersect1d(leaves, levels.coarse.graph.ends[coarse]))
        edges = creased.surface.vertices[closed.edges[seam]]
        if panels.cost[k] == np.inf:
            return edges
        if panels.cost[k] <= compute_seam_cost(levels.coarse, coarse, self.trade):
            return panels.select_component(k)
        # corners in the interior of a chart and fillets stretch a chart more than expected
        return min(panels.select_component(k), edges, key=lambda seams: self._measure_cost(creased, seams))

    def _measure_cost(self, creased: CreasedSurface, edges: IntArray) -> float:
        """Flatten the pieces between seams, cut their overlaps apart, and return the cost of the result.

        The cost includes conformal distortion, because large triangles at a flattened corner are sheared.
        """
        parts, area, squared, shear = list[Submesh](), 0.0, 0.0, 0.0
        for piece in creased.surface.cut_along(edges):
            try:
                result = flatten_piece(piece, self.method)
            except SingularSystemError:
                return np.inf
            if len(result.flipped):
                return np.inf
            pairs = find_overlapping_pairs_of_chart(piece.topology, result.uv)
            parts += split_overlaps(piece, piece.faces[pairs]) if len(pairs) else [piece]
            change = measure_change(piece, result.uv)
            area += float(change.double_area.sum())
            squared += float(change.double_area @ change.squared_stretch)
            shear += float(change.double_area @ (change.conformal - 1))
        price = compute_division_price(creased, parts) / float(np.sqrt(area / 2))
        stretch = get_stretch_weight(self.method) * (float(np.sqrt(squared / area)) - 1)
        return stretch + shear / area + price / self.trade

    def _find_panel_seams(self, creased: CreasedSurface, number: int) -> _PanelSeams:
        """Return the seams of the components that consist of panels, and their costs."""
        found = _PanelSeams.make_empty(number)
        if not self.trade:
            return found
        for kind in (Panels, RoundedPanels):
            made = kind(creased).mask_panel_components()
            if made.any():
                own = creased
                if not made.all():
                    rows = np.flatnonzero(made[creased.component_of_face])
                    own = CreasedSurface(creased.surface.select_faces(rows), self.hidden)
                edges, label, cost = find_panel_seams(kind(own), self.trade)
                rivals = np.flatnonzero((cost < found.cost[made]) & np.isfinite(found.cost[made])).tolist()
                bodies = own.surface.split_components() if rivals else []
                for (
                    k
                ) in rivals:  # the first panels preserve all lengths, but fillets and chamfers are stretched
                    cost[k] = self._measure_cost(CreasedSurface(bodies[k], self.hidden), edges[label == k])
                found.add_if_cheaper(np.flatnonzero(made), edges, label, cost)
        return found


@dataclass(eq=False)
class _PanelSeams:
    """Seams around panels.

    Attributes
    ----------
    edges : (#E, 2) int64
        The edges of the seams, as pairs of input vertices.
    component : (#E,) int64
        The component of each edge.
    cost : (#C,) float64
        The cost of the seams of each component; infinite if the component does not consist of panels.
    """

    edges: IntArray
    component: IntArray
    cost: FloatArray

    @classmethod
    def make_empty(cls, number: int) -> _PanelSeams:
        edges = np.zeros((0, 2), dtype=np.int64)
        return cls(edges, edges[:, 0], np.full(number, np.inf))

    def add_if_cheaper(
        self, components: IntArray, edges: IntArray, label: IntArray, cost: FloatArray
    ) -> None:
        """Replace the known seams of each given component if its new seams cost less.

        `label` gives, for each edge of the new seams, the index of its component in `components`.
        """
        is_cheaper = cost < self.cost[components]
        self.cost[components[is_cheaper]] = cost[is_cheaper]
        kept, added = ~np.isin(self.component, components[is_cheaper]), is_cheaper[label]
        self.edges = np.concatenate((self.edges[kept], edges[added]))
        self.component = np.concatenate((self.component[kept], components[label[added]]))

    def select_component(self, component: int) -> IntArray:
        return np.asarray(self.edges[self.component == component])


def _find_small_components(surface: Submesh, shapes: list[Shape]) -> list[bool]:
    """Mark the components of genus 0 that are small enough to be processed in one batch."""
    components, _, genus = zip(*shapes, strict=True)
    sizes = np.array([len(component.F) for component in components])
    small = (sizes <= MAX_FACES_OF_SMALL_BODY) & (len(shapes) >= MIN_SMALL_BODIES)
    medium = (sizes > MAX_FACES_OF_SMALL_BODY) & (sizes <= MAX_FACES_OF_MEDIUM_BODY)
    if len(shapes) >= MIN_MEDIUM_BODIES and medium.any():
        of = np.empty(len(surface.F), dtype=np.int64)
        for i, component in enumerate(components):
            of[np.searchsorted(surface.faces, component.faces)] = i
        small |= medium & (compute_flat_shares(surface, of) < MAX_FLAT_SHARE_OF_SMOOTH_BODY)
    return list((small & (np.array(genus) == 0)).tolist())


def _list_shapes(surface: Submesh) -> list[Shape]:
    """Return the components with their numbers of boundary loops and handles."""
    components, topology = surface.split_components(), surface.topology
    if len(components) == 1:
        return [(surface, len(topology.loops), topology.genus)]
    label = np.empty(len(surface.V), dtype=np.int64)
    label[surface.F.ravel()] = np.repeat(surface.component_of_face, 3)
    loops, edges, vertices, faces = (
        np.bincount(label[of], minlength=len(components))
        for of in (
            np.array([loop[0] for loop in topology.loops], dtype=np.int64),
            topology.edges[:, 0],
            np.arange(len(surface.V)),
            surface.F[:, 0],
        )
    )
    genus = (2 - loops - (vertices - edges + faces)) // 2
    return list(zip(components, loops.tolist(), genus.tolist(), strict=True))
