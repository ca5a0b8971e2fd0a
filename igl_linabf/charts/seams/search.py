"""Seams: the edges along which a surface is cut open, so that it can be flattened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..._types import FloatArray, IntArray
from ...errors import is_number
from ...flattening import Isometric, Method, method_of
from ...surface import Submesh, compact, cut_faces, face_array, manifold_topology, seam_mask, vertex_array
from ..cut_graphs import MAX_DIRECT_NODES, ClosedSurface, Levels, log_scale, slide_into_valleys
from ..features import (
    PLANAR_SHARE,
    CreasedSurface,
    Hiding,
    dihedral_angles,
    flat_share,
    flat_shares,
    hiding_weights,
)
from ..panels import FLAT_SHARE_OF_LARGE_NETS, MOST_HANDLES_OF_NETS, Nets, Panels, RoundedPanels, panel_seams
from ..splitting import coarse_mesh, predicted_seams
from . import constants
from .growth import grown_seam, if_it_pays, seam_of_clusters, shorter_seam, symmetric_seam, with_branches
from .small_bodies import SmallBodies


def cut(V: ArrayLike, F: ArrayLike, seams: ArrayLike) -> tuple[FloatArray, IntArray, IntArray]:
    """Cut a surface along edges, as `igl.cut_mesh` does, with checked input.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, loops and handles.
    seams : (#E, 2) int, or (#F, 3) bool
        The edges, as pairs of vertices. Or a mask: `[f, k]` is True if the edge from `F[f, k]` to
        `F[f, k + 1]` is a seam; one of the edge's two sides is enough. Boundary edges have no
        effect, nor has a single edge between interior vertices.

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
    vertices, packed = compact(faces, len(positions))
    sides, n = manifold_topology(packed, vertices).sides, len(positions)
    F_cut, origin = cut_faces(faces, n, sides, seam_mask(seams, faces, n))
    return positions[origin], F_cut, origin


def find_seams(
    V: ArrayLike,
    F: ArrayLike,
    *,
    method: str | Method = "linabf",
    trade: float = constants.TRADE,
    holes: bool = False,
    disks: bool = False,
    hide: Hiding | None = None,
) -> IntArray:
    """Find short seams that make every component a disk of low distortion.

    Handles are opened along short loops through one point (shortest-path tree and cotree of
    Erickson, Whittlesey 2005). Holes are joined by a tree of shortest paths. Then branches grow on
    the seam. Each is a shortest path from the point where the conformal map's scale is farthest
    from one, that is, from a tip that would shrink (one Laplace system a branch, as in boundary
    first flattening); or with "isometric" from where the stretch falls most for the branch's length.
    Branches are kept as long as the lower stretch is worth their length. Finally, branch points move if a
    shorter seam is worth the change of stretch, and the seam is straightened and slides into valleys
    nearby. On surfaces of more than 10,000 vertices all this is done on clusters of vertices, and the seam
    is then drawn tight along the edges.

    Where faces meet in creases, the seam is compared with nets: trees through all that is curved at
    creases. Cut along one, planes, cylinders and cones are laid flat exactly; overlapping parts of a net
    are for `unwrap` to split.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, loops and handles.
    method : str or method object
        Of `unwrap`, that the seams are for. With "isometric" what counts is the stretch of that map, times
        6: it has about a sixth of the conformal one's, and who asks for it wants little of that.
    trade : float
        Seam length, in units of the square root of the component's area, that lowering the L2
        stretch by 1 is worth. Edges along a crease of a right angle or more count half, and sharp
        creases on a net are free up to a length of `trade`. 0: only what is needed to make disks.
        Large: branches grow as long as the expected stretch falls, at most 100 a component.
    holes : bool
        Do not cut from hole to hole: each component becomes a disk with holes.
    disks : bool
        Also grow branches on components that need no seam; by default these are not cut.
    hide : (3,) or (#F,) float, or "back", optional
        Where seams may lie: the direction in which faces look that are not seen, as `[0, 0, -1]` for the
        underside if z is up; or a weight for each face, larger where a seam is hidden better. Weights
        count by where they are between the least and the largest. An edge in full view counts three
        times its length, a hidden one a third. "back": the side of each body that least detail looks to, as
        of a head without its face; an edge in front then counts twice its length.

    Returns
    -------
    seams : (#E, 2) int64
        Vertices of the edges, as `cut` takes them.

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
    surface = Submesh.checked_manifold(V, F)
    hidden = hiding_weights(surface, hide, np.arange(len(surface.F)))
    isometric = isinstance(method_of(method), Isometric)
    return seams_of(surface, trade, holes=holes, disks=disks, hidden=hidden, isometric=isometric)


def check_trade(trade: float) -> None:
    """Refuse what is no price of seams."""
    if not is_number(trade, 0):
        raise ValueError(f"trade is {trade!r}: use a number, 0 (shortest seams) or larger")


def seams_of(
    surface: Submesh,
    trade: float,
    *,
    holes: bool = False,
    disks: bool = False,
    gain: float = 0.0,
    hidden: FloatArray | None = None,
    isometric: bool = False,
    part_overlaps: bool = False,
    panels: bool = False,
) -> IntArray:
    """`find_seams` of a checked manifold or a part of one; edges by the caller's vertices.

    A component that needs no seam gets one only if it saves at least `gain` of L2 stretch beyond its price.
    `hidden` as of `hiding_weights`.
    `isometric`: for maps that keep lengths; the small ones among many are found as for others.
    `part_overlaps`: large components are also cut between sheets that would lie over each other in a map.
    `panels`: so are those that are made of panels; with rounded creases only if no seams are to be hidden.
    """
    found, known = [np.zeros((0, 2), dtype=np.int64)], None
    if panels and trade > 0 and not holes:
        of_panels, creased = _of_panels(CreasedSurface(surface, hidden), trade)
        found += of_panels
        if creased is None:
            return np.concatenate(found)
        surface, known = creased.surface, creased.dihedral
    small, shapes = [], _shapes(surface)
    is_large = len(shapes) > 1 and len(surface.F) >= constants.MIN_FACES_OF_LARGE_SURFACE
    most = constants.MAX_DIRECT_NODES_OF_PART if is_large else MAX_DIRECT_NODES
    task = _Task(trade, holes, part_overlaps, most)
    for (component, loops, genus), is_small in zip(shapes, _are_small(surface, shapes), strict=True):
        open_ = genus == 0 and (loops == 1 or (holes and loops > 1))
        if not open_ or (disks and trade > 0):
            if is_small:
                small.append(component.faces)
            else:
                bend = dihedral_angles(component) if known is None or component is not surface else known
                closed = ClosedSurface.of(component, hidden, isometric, bend)
                seam = _cheapest_seam(component, closed, bend, gain if open_ else None, task)
                found.append(component.vertices[closed.edges[seam]])
    if small:
        rows = np.searchsorted(surface.faces, np.sort(np.concatenate(small)))
        found.append(SmallBodies(surface.of_faces(rows), hidden).seams(trade, holes, gain))
    return np.concatenate(found)


def _of_panels(creased: CreasedSurface, trade: float) -> tuple[list[IntArray], CreasedSurface | None]:
    """The seams of the components that are made of panels; and the other components, if there are any."""
    found = list[IntArray]()
    for kind in (Panels, RoundedPanels):
        panels = kind(creased)
        made = panels.made(trade)[creased.label]
        if not made.any():
            continue
        surface, rows = creased.surface, np.flatnonzero(made)
        own = panels if made.all() else kind(CreasedSurface(surface.of_faces(rows), creased.hidden))
        seams, left = panel_seams(own, trade)
        found.append(seams)
        made[rows[left]] = False
        if made.all():
            return found, None
        if made.any():
            creased = CreasedSurface(surface.of_faces(np.flatnonzero(~made)), creased.hidden)
    return found, creased


Shape = tuple[Submesh, int, int]  # a component, its numbers of boundary loops and handles


def _are_small(surface: Submesh, shapes: list[Shape]) -> list[bool]:
    """Of which components the seams are found together: small ones among many, without handles."""
    components, _, genus = zip(*shapes, strict=True)
    sizes = np.array([len(component.F) for component in components])
    small = (sizes <= constants.MAX_FACES_OF_SMALL_BODY) & (len(shapes) >= constants.MIN_SMALL_BODIES)
    medium = (sizes > constants.MAX_FACES_OF_SMALL_BODY) & (sizes <= constants.MAX_FACES_OF_MEDIUM_BODY)
    if len(shapes) >= constants.MIN_MEDIUM_BODIES and medium.any():
        of = np.empty(len(surface.F), dtype=np.int64)
        for i, component in enumerate(components):
            of[np.searchsorted(surface.faces, component.faces)] = i
        small |= medium & (flat_shares(surface, of) < constants.MAX_FLAT_SHARE_OF_SMOOTH_BODY)
    return list((small & (np.array(genus) == 0)).tolist())


def _shapes(surface: Submesh) -> list[Shape]:
    """The components, their numbers of boundary loops and handles."""
    components, topology = surface.components(), surface.topology
    if len(components) == 1:
        return [(surface, len(topology.loops), topology.genus)]
    label = np.empty(len(surface.V), dtype=np.int64)
    label[surface.F.ravel()] = np.repeat(surface.label, 3)
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


@dataclass(frozen=True)
class _Task:
    """What seams of components are sought: options of `seams_of`.

    On up to `max_direct_nodes` nodes they are found on the component itself, on more on clusters of them.
    """

    trade: float
    holes: bool
    part_overlaps: bool
    max_direct_nodes: int


def _cheapest_seam(
    component: Submesh, closed: ClosedSurface, bend: FloatArray, gain: float | None, task: _Task
) -> IntArray:
    """The seam that grows by leaves, or a net, if there are creases and it costs less.

    With a `gain`, no seam is needed, and one has to save this.
    """
    none, trade, holes = np.zeros(0, dtype=np.int64), task.trade, task.holes
    with_nets = trade > 0 and not (holes and closed.graph.n_holes > 1)
    nets = Nets(
        closed, trade, lambda seam: log_scale(closed, closed.graph.boundary_nodes(seam), closed.curvature)
    )
    few = closed.graph.n <= MAX_DIRECT_NODES
    # whether it is a hard-surface body; a net opens every handle, and many lay sheets over each other in it
    hard = with_nets and (few or closed.graph.genus <= MOST_HANDLES_OF_NETS)
    least_flat = PLANAR_SHARE if few else FLAT_SHARE_OF_LARGE_NETS
    hard = hard and (nets.creased or (nets.angular and flat_share(component, bend) >= least_flat))
    # on a large surface without planes no net is free, and finding that out takes as long as all the rest
    if with_nets and (few or hard) and (net := nets.settled(hard)) is not None:
        if gain is None or nets.cost(none) - nets.cost(net) >= gain:
            return net
        if not hard:
            return none

    def parts(seam: IntArray) -> list[Submesh]:
        return component.cut_along(component.vertices[closed.edges[seam]])

    def cheaper(seam: IntArray) -> IntArray | None:
        return nets.cheaper(seam, gain, parts, lambda net: with_branches(closed, net, trade)[0])

    if closed.graph.n > task.max_direct_nodes:
        levels = Levels.of(closed, constants.MAX_CLUSTERS)
        coarse = levels.coarse
        seam, leaves = seam_of_clusters(coarse, trade, holes, gain)
        if hard and (net := cheaper(levels.lift(seam, leaves))) is not None:
            return net
        if not task.part_overlaps:
            return levels.lift(seam, leaves)
        mesh = coarse_mesh(coarse.graph, levels.label(closed.node[component.F]))
        if mesh is not None:
            more, ends = predicted_seams(coarse.graph, mesh, seam, trade * constants.CLUSTER_TRADE_FACTOR)
            leaves = np.union1d(leaves, ends)  # what is cut off would shrink if its ends were free to move
            seam = np.append(seam, more)
        return levels.lift(seam, leaves)
    seam = grown_seam(closed, trade, holes)[0]
    if hard and (net := cheaper(seam)) is not None:
        return net
    seam, cost = shorter_seam(closed, seam, trade)
    most = cost(seam) + constants.VALLEY_COST
    seam = slide_into_valleys(closed, seam, lambda moved: cost(moved) < most)
    if trade > 0 and not closed.graph.genus:
        seam = symmetric_seam(component, closed, seam, trade, holes)
    return if_it_pays(closed, seam, trade, gain)
