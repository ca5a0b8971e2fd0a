"""Seams: the edges along which a surface is cut open, so that it can be flattened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..._types import FloatArray, IntArray
from ...errors import is_number
from ...flattening import Isometric, Method, method_of
from ...surface import Submesh, compact, cut_faces, face_array, manifold_topology, seam_mask, vertex_array
from ..cut_graphs import CLUSTERED, DIRECT, ClosedSurface, Levels, log_scale
from ..features import CreasedSurface, Hiding, dihedral_angles, flat_share, flat_shares, hiding_weights
from ..panels import (
    FACETED_SHARE,
    FLAT_SHARE_OF_LARGE,
    MOST_HANDLES_OF_NETS,
    Nets,
    Panels,
    RoundedPanels,
    panel_seams,
)
from ..splitting import coarse_mesh, predicted_seams, seams_to_fine_tips
from .constants import FEW_BODIES, MANY_BODIES, MEDIUM_BODY, SMALL_BODY, SMOOTH_BODY, TIGHTENING, TRADE
from .growth import coarse_seam, fine_seam, grow_branches, grow_seam, if_it_pays
from .small_bodies import SmallBodies

Component = tuple[Submesh, int, int]  # with its numbers of boundary loops and handles


@dataclass(frozen=True, eq=False)
class SeamOptions:
    """Which seams are sought.

    Attributes
    ----------
    trade : float
    holes, disks : bool
        As of `find_seams`.
    gain : float
        L2 stretch that a seam has to save beyond its price on a component that needs none.
    hidden : (#F,) float64 or None
        As `hiding_weights` returns it.
    isometric : bool
        Whether maps are to keep lengths. The seams of small components among many are found as for others.
    part_overlaps : bool
        Whether large components are also cut where their map would overlap.
    panels : bool
        Whether what is made of panels is cut into these; with rounded creases only if nothing is hidden.
    """

    trade: float
    holes: bool = False
    disks: bool = False
    gain: float = 0.0
    hidden: FloatArray | None = None
    isometric: bool = False
    part_overlaps: bool = False
    panels: bool = False


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
    trade: float = TRADE,
    holes: bool = False,
    disks: bool = False,
    hide: Hiding | None = None,
) -> IntArray:
    """Find short seams that make every component a disk of low distortion.

    Handles are opened along short loops through one point (shortest-path tree and cotree of
    Erickson, Whittlesey 2005). Holes are joined by a tree of shortest paths. Then branches grow on
    the seam. Each is a shortest path from the point where the conformal map's scale is farthest
    from one, that is, from a tip that would shrink (one Laplace system a branch, as in boundary
    first flattening). Branches are kept as long as the lower stretch is worth their length.
    Finally, branch points move if a shorter seam is worth the change of stretch, and the seam is
    straightened and slides into valleys nearby. On surfaces of more than 10,000 vertices all this is
    done on clusters of vertices, and the seam is then pulled tight along the edges.

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
    options = SeamOptions(trade, holes=holes, disks=disks, hidden=hidden, isometric=isometric)
    return seams_of(surface, options)


def check_trade(trade: float) -> None:
    """Refuse what is no price of seams."""
    if not is_number(trade, 0):
        raise ValueError(f"trade is {trade!r}: use a number, 0 (shortest seams) or larger")


def seams_of(surface: Submesh, options: SeamOptions) -> IntArray:
    """`find_seams` of a checked manifold or a part of one; edges by the caller's vertices."""
    trade, holes, hidden = options.trade, options.holes, options.hidden
    found, known, small = [np.zeros((0, 2), dtype=np.int64)], None, list[IntArray]()
    if options.panels and trade > 0 and not holes:
        of_panels, creased = _seams_of_panels(CreasedSurface(surface, hidden), trade)
        found += of_panels
        if creased is None:
            return np.concatenate(found)
        surface, known = creased.surface, creased.dihedral
    components = _components(surface)
    for (component, loops, genus), is_small in zip(components, _are_small(surface, components), strict=True):
        needs_none = genus == 0 and (loops == 1 or (holes and loops > 1))
        if needs_none and not (options.disks and trade > 0):
            continue
        if is_small:
            small.append(component.faces)
        else:
            dihedral = known if known is not None and component is surface else dihedral_angles(component)
            closed = ClosedSurface.of(component, hidden, options.isometric, dihedral)
            gain = options.gain if needs_none else None
            seam = best_seam(component, closed, options, gain, dihedral)
            found.append(component.vertices[closed.edges[seam]])
    if small:
        rows = np.searchsorted(surface.faces, np.sort(np.concatenate(small)))
        found.append(SmallBodies(surface.of_faces(rows), hidden).seams(trade, holes, options.gain))
    return np.concatenate(found)


def _seams_of_panels(creased: CreasedSurface, trade: float) -> tuple[list[IntArray], CreasedSurface | None]:
    """The seams of the components that are made of panels; and the other components, if there are any."""
    found = list[IntArray]()
    for kind in (Panels, RoundedPanels):
        panels = kind(creased)
        made = panels.components(trade)[creased.label]
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


def _are_small(surface: Submesh, components: list[Component]) -> list[bool]:
    """Of which components the seams are found together: small ones among many, without handles."""
    sizes = np.array([len(component.F) for component, _, _ in components])
    small = (sizes <= SMALL_BODY) & (len(components) >= FEW_BODIES)
    medium = (sizes > SMALL_BODY) & (sizes <= MEDIUM_BODY)
    if len(components) >= MANY_BODIES and medium.any():
        of = np.empty(len(surface.F), dtype=np.int64)
        for i, (component, _, _) in enumerate(components):
            of[np.searchsorted(surface.faces, component.faces)] = i
        small |= medium & (flat_shares(surface, of) < SMOOTH_BODY)
    small &= np.array([genus for _, _, genus in components]) == 0
    return list(map(bool, small))


def _components(surface: Submesh) -> list[Component]:
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


def best_seam(
    component: Submesh,
    closed: ClosedSurface,
    options: SeamOptions,
    gain: float | None,
    dihedral: FloatArray | None = None,
) -> IntArray:
    """The seam that branches grow on, or a net, if there are creases and it costs less; edges of `closed`.

    With a `gain`, no seam is needed, and one has to save this. On a large surface it is found on clusters.
    """
    trade, graph = options.trade, closed.graph
    few = graph.n <= DIRECT
    with_nets = trade > 0 and not (options.holes and graph.n_holes > 1)
    nets = Nets(
        closed,
        trade,
        lambda seam: component.cut_along(component.vertices[closed.edges[seam]]),
        lambda net: grow_branches(closed, net, trade)[0],
    )
    # a net opens every handle, and many lay sheets over each other in it
    hard = with_nets and (few or graph.genus <= MOST_HANDLES_OF_NETS)
    hard = hard and 1 - nets.smooth_share >= FACETED_SHARE
    if hard and nets.smooth_share:
        hard = flat_share(component, dihedral) >= (FACETED_SHARE if few else FLAT_SHARE_OF_LARGE)
    # on a large surface without planes no net is free, and finding that out takes as long as all the rest
    if with_nets and (few or hard) and (net := nets.settled(hard)) is not None:
        if gain is None or nets.cost(net[:0]) - nets.cost(net) >= gain:
            return net
        if not hard:
            return net[:0]
    if few:
        seam, _ = grow_seam(closed, trade, options.holes)
        if hard and (net := nets.cheaper(seam, gain)) is not None:
            return net
        return if_it_pays(closed, fine_seam(component, closed, seam, trade, options.holes), trade, gain)
    levels = Levels.of(closed, CLUSTERED)
    seam, leaves = coarse_seam(levels.coarse, trade, options.holes, gain)
    if hard and (net := nets.cheaper(levels.lift(seam, leaves), gain)) is not None:
        return net
    if options.part_overlaps:
        return _with_predicted_seams(component, closed, levels, seam, leaves, trade)
    return levels.lift(seam, leaves)


def _with_predicted_seams(
    component: Submesh, closed: ClosedSurface, levels: Levels, seam: IntArray, leaves: IntArray, trade: float
) -> IntArray:
    """A seam of clusters on the surface, with seams where a map would overlap or shrink tips."""
    coarse = levels.coarse
    mesh = coarse_mesh(coarse.graph, levels.label(closed.node[component.F]))
    if mesh is not None:
        more, ends = predicted_seams(coarse.graph, mesh, seam, trade * TIGHTENING)
        leaves = np.union1d(leaves, ends)  # what is cut off would shrink if its ends were free to move
        seam = np.append(seam, more)
    lifted = levels.lift(seam, leaves)
    if trade == 0:
        return lifted
    of_clusters = log_scale(coarse, coarse.graph.boundary_nodes(seam), coarse.curvature)
    u = of_clusters[levels.label(np.arange(closed.graph.n))]
    return np.append(lifted, seams_to_fine_tips(closed, lifted, u, trade))
