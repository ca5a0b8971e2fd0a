"""Placement of cones: where one more lets the rest of a surface be flattened with less stretch."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ..._runtime import advance
from ..._types import FloatArray, IntArray
from ...errors import MeshError, is_number, some
from ...surface import Submesh
from ..cut_graphs import SurfaceGraph
from .angle_sums import are_possible, least_quarter_turns, quantised_curvatures
from .component import ConeComponent
from .constants import (
    CONE_TRADE,
    CONES_IN_VAIN,
    CONES_ONE_BY_ONE,
    CONES_PER_NEW_CONE,
    NARROW_CONE,
    QUARTER_TURN,
    USABLE_STRETCH,
    WIDE_CORNER,
)
from .scale import ConeScale


def find_cones(V: ArrayLike, F: ArrayLike, n: int | None = None, *, trade: float = CONE_TRADE) -> IntArray:
    """Find vertices that, as cones, let the rest of the surface be flattened with little stretch.

    Think of the conformal map that is flat everywhere but at the cones, and whose scale is one at them and
    at the boundary. Elsewhere it shrinks or grows. The next cone is where the logarithm of its scale is
    farthest from zero: at the tips of limbs, and in the crotches between them. If a cone's angle sum
    would be less than 60 degrees, or more than its triangles can take, the next one is near it. One
    factor of the surface's Laplacian serves for all cones.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, loops and handles.
    n : int, optional
        How many cones on each component, or all of its interior vertices if it has fewer. By default
        as many as pay.
    trade : float
        How many cones lowering the L2 stretch by 1 is worth. Large: cones are added as long as the
        expected stretch falls. Beyond 100 on a component, several are added at a time until all limbs have
        theirs.

    Returns
    -------
    cones : (#C,) int64
        Interior vertices, component by component; on each the most useful ones first.

    Raises
    ------
    MeshError
        The arrays are malformed, the surface is not an oriented manifold, or a face is degenerate; or
        `n` is too small for a component: no triangles would have the angles.
    ValueError
        `n` is no number of cones, or `trade` is not positive.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> len(find_cones(V, F, 4))
    4
    >>> len(find_cones(V[:4], F[:2]))  # no interior vertex, no cone
    0
    """
    if n is not None and not is_number(n, 0, whole=True):
        raise ValueError(f"n is {n!r}: give a whole number of cones, or None for as many as pay")
    surface = Submesh.checked_manifold(V, F)
    found = [
        component.vertices[find_on_component(ConeComponent(component), n, trade)]
        for component in surface.components()
    ]
    return np.concatenate(found)


def find_on_component(component: ConeComponent, n: int | None, trade: float) -> IntArray:
    """Cones on a component: `n`, or as many as pay; its own vertices."""
    if not is_number(trade, 0, above=True):
        raise ValueError(f"trade is {trade!r}: use a positive number of cones")
    if n is not None and (n < component.min_cones or (n == 1 and component.total_curvature == 0)):
        submesh = component.submesh
        least, cones = max(component.min_cones, 2), "1 cone is" if n == 1 else f"{n} cones are"
        raise MeshError(
            f"the component of faces {some(submesh.faces)} is closed, of Euler characteristic "
            f"{submesh.topology.characteristic}, and {cones} too few for angles of 90 degrees and more at "
            f"them: give at least {least}"
        )
    if n == 0 or not len(component.interior):
        return np.zeros(0, dtype=np.int64)
    return component.vertices_of(_paying_cones(component, trade) if n is None else _first_cones(component, n))


def _paying_cones(component: ConeComponent, trade: float) -> IntArray:
    """Add cones as long as they pay; the nodes of those whose stretch and number cost least."""
    best, least, smallest_spread, in_vain = np.zeros(0, dtype=np.int64), np.inf, np.inf, 0
    for scale in _growing_scales(component, component.max_cones):
        number, stretch, cost = len(scale.nodes), scale.stretch, np.inf
        many = number >= component.one_by_one
        if component.total_curvature == 0 and number == 1:
            least = stretch  # that of no cones
        if number >= component.min_cones:
            cost = stretch + number / trade + _strain_cost(component, scale)
            # while some limbs have no cones, their stretch hides what cones on other limbs save
            spread = scale.spread if many and stretch >= USABLE_STRETCH else np.inf
            in_vain = 0 if cost < least or spread < smallest_spread else in_vain + 1
            smallest_spread = min(smallest_spread, spread)
            if cost < least:
                best, least = scale.nodes, cost
        patience = CONES_ONE_BY_ONE if many and np.isinf(cost) else CONES_IN_VAIN
        if (many or least < USABLE_STRETCH) and in_vain >= patience:
            break
    return best if np.isfinite(least) else _first_cones(component, number)


def _first_cones(component: ConeComponent, n: int) -> IntArray:
    """The nodes of the first `n` cones.

    Raises
    ------
    MeshError
        Triangles can have neither the angle sums of one scale at all cones, nor quarter turns.
    """
    *_, scale = _growing_scales(component, n)
    n_triangles = component.n_triangles[scale.nodes]
    beyond = np.flatnonzero(~are_possible(2 * np.pi - scale.curvature, n_triangles))
    if len(beyond):
        turns = quantised_curvatures(component, scale).for_stretch
        if not are_possible(np.asarray(2 * np.pi - turns * QUARTER_TURN), n_triangles).all():
            more = _growing_scales(component, max(component.one_by_one, 2 * n))
            enough = (len(s.nodes) for s in more if len(s.nodes) > n and _is_possible(component, s))
            raise MeshError(_too_few_message(component, scale, beyond[0], next(enough, None)))
    return scale.nodes


def _too_few_message(component: ConeComponent, scale: ConeScale, beyond: int, enough: int | None) -> str:
    """That triangles cannot have the angle sum of cone `beyond`, and how many cones would do."""
    submesh, node = component.submesh, scale.nodes[beyond]
    angle, around = 2 * np.pi - scale.curvature[beyond], component.n_triangles[node]
    vertex = submesh.vertices[component.vertices_of(node)]
    help_ = "cut along seams instead: leave out cones" if enough is None else f"give at least {enough}"
    return (
        f"{len(scale.nodes)} cones are too few for the component of faces {some(submesh.faces)}, of "
        f"Euler characteristic {submesh.topology.characteristic}: the angle sum at vertex {vertex} "
        f"would be {angle:.4g} rad, and must be within 0 and {around} pi = {np.pi * around:.4g}: {help_}"
    )


def _growing_scales(component: ConeComponent, most: int) -> Iterator[ConeScale]:
    """The conformal scales with the fewest cones, and then with more and more, up to a number of cones."""
    scale = ConeScale.of(component.closed)
    while True:
        advance("cones", 0.1)
        yield scale
        room = min(most, len(component.interior)) - len(scale.nodes)
        further = _next_cones(component, scale, room)
        if not len(further):
            return
        scale = scale.with_cones(further)


def _next_cones(component: ConeComponent, scale: ConeScale, most: int) -> IntArray:
    """The node at which another cone helps most; with many cones, several nodes far from each other."""
    far = np.abs(scale.log_scale)
    far[scale.nodes] = 0.0
    if most <= 0 or not far.any():
        return np.zeros(0, dtype=np.int64)
    strain = _strain(component, scale)
    strained = len(strain) > 0 and strain.max() > 0
    single = len(scale.nodes) < component.one_by_one or scale.stretch < USABLE_STRETCH
    if single and not strained:
        return np.array([np.argmax(far)])
    distance, _, nearest_cone = component.closed.graph.shortest_paths(scale.nodes)
    if single:  # near the cone of most strain
        near = np.where(nearest_cone == scale.nodes[np.argmax(strain)], far, 0.0)
        return np.array([np.argmax(near if near.any() else far)])
    # in the Voronoi cell of each cone, the node where the scale is farthest from one
    order = np.argsort(far, kind="stable")
    farthest = np.zeros(component.closed.graph.n, dtype=np.int64)
    farthest[nearest_cone[order]] = order
    tried, room = farthest[scale.nodes], min(most, len(scale.nodes) // CONES_PER_NEW_CONE)
    tried, strain = tried[far[tried] > 0], strain[far[tried] > 0]
    by_strain, by_scale = np.argsort(-strain, kind="stable"), np.argsort(-far[tried], kind="stable")
    helped = by_strain[strain[by_strain] > 0][: room // 2]
    candidates = tried[np.concatenate((helped, by_scale))]
    return _spread_nodes(component.closed.graph, candidates, distance / 2)[:room]


def _spread_nodes(graph: SurfaceGraph, nodes: IntArray, distance: FloatArray) -> IntArray:
    """Of the nodes in their order, each that is at least its `distance` away from all that were taken."""
    taken = np.zeros(0, dtype=np.int64)
    for i in nodes.tolist():
        gap = np.linalg.norm(graph.position[taken] - graph.position[i], axis=1)
        if (gap >= distance[i]).all():
            taken = np.append(taken, i)
    return taken


def _strain_cost(component: ConeComponent, scale: ConeScale) -> float:
    """What strained cones cost: as much as usable stretch; infinity if no triangles have such angle sums."""
    if not _is_possible(component, scale):
        return np.inf
    return USABLE_STRETCH if (_strain(component, scale) > 0).any() else 0.0


def _is_possible(component: ConeComponent, scale: ConeScale) -> bool:
    """Whether triangles can have the angle sums of one scale at all cones, and some quarter turns, too."""
    total, n_triangles = component.total_curvature, component.n_triangles[scale.nodes]
    room = total is None or least_quarter_turns(n_triangles).sum() <= round(total / QUARTER_TURN)
    return bool(room and are_possible(2 * np.pi - scale.curvature, n_triangles).all())


def _strain(component: ConeComponent, scale: ConeScale) -> FloatArray:
    """By how much each cone's angle sum is too small, or too large for its triangles; radians."""
    angle = 2 * np.pi - scale.curvature
    return np.maximum(NARROW_CONE - angle, angle - WIDE_CORNER * component.n_triangles[scale.nodes])
