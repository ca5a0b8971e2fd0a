"""Where cones are placed: one by one, where the conformal scale is farthest from 1; and their angles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..._runtime import advance
from ..._types import BoolArray, FloatArray, IntArray
from ...angles import ClosedPath
from ...errors import MeshError, is_number, some
from ...surface import Submesh
from ..cut_graphs import ClosedSurface
from . import constants
from .constants import CONE_TRADE, MAX_QUARTERS, QUARTER_TURN
from .quantisation import QuantisedCurvatures
from .scale import ConeScale
from .seams import along_handles, paths_across, seam_through


def find_cones(V: ArrayLike, F: ArrayLike, n: int | None = None, *, trade: float = CONE_TRADE) -> IntArray:
    """Find vertices that, as cones, let the rest of the surface be flattened with little stretch.

    The conformal map that is flat everywhere but at the cones, and keeps the scale at them and at the
    boundary, shrinks or grows elsewhere. The next cone is where the logarithm of its scale is
    farthest from zero: at the tips of limbs, and in the crotches between them. If a cone's angle
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


@dataclass(frozen=True, eq=False)
class ConeComponent:
    """A component on which cones are placed."""

    component: Submesh

    @cached_property
    def piece(self) -> ClosedSurface:
        """Its graph."""
        return ClosedSurface.of(self.component)

    @cached_property
    def along_handles(self) -> IntArray:
        """A cut graph that opens the handles; edges of `piece`."""
        return along_handles(self.piece)

    @cached_property
    def paths(self) -> tuple[ClosedPath, ...]:
        """Closed paths around holes and along handles: those of `paths_across`, wherever cones are."""
        seam = seam_through(self.piece, np.zeros(0, dtype=np.int64), self.along_handles)
        return paths_across(self.component, self.piece.graph, seam)

    @cached_property
    def inner(self) -> IntArray:
        """Its interior vertices, the nodes after those of the holes."""
        return np.flatnonzero(self.component.topology.interior)

    @cached_property
    def valence(self) -> IntArray:
        """Faces at each node that is no hole; 0 at those."""
        around = np.bincount(self.component.F.ravel(), minlength=len(self.component.V))
        return np.append(np.zeros(self.piece.graph.n_holes, dtype=np.int64), around[self.inner])

    @property
    def closed_curvature(self) -> float | None:
        """What the curvatures of the cones sum to, if the surface is closed."""
        return None if self.piece.graph.n_holes else 2 * np.pi * self.component.topology.characteristic

    @property
    def fewest(self) -> int:
        """Number of cones of 90 degrees at least without which it cannot be flat."""
        total = self.closed_curvature
        return 0 if total is None or total == 0 else 3 if total > 0 else 1

    @property
    def enough(self) -> int:
        """Number of cones that are found one by one: few surfaces need more."""
        return max(constants.SINGLE_CONES, 2 * abs(self.component.topology.characteristic))

    @property
    def limit(self) -> int:
        """Number of cones at most, if they are to be found."""
        by_memory = constants.MAX_GREEN_VALUES // self.piece.graph.n
        return max(self.enough, min(by_memory, len(self.inner) // constants.MIN_VERTICES_PER_CONE))

    def vertices(self, nodes: IntArray) -> IntArray:
        """The component's vertices of nodes that are no holes."""
        return self.inner[nodes - self.piece.graph.n_holes]


def find_on_component(place: ConeComponent, n: int | None, trade: float) -> IntArray:
    """Cones on a component; its own vertices."""
    if not is_number(trade, 0, above=True):
        raise ValueError(f"trade is {trade!r}: use a positive number of cones")
    where = f"the component of faces {some(place.component.faces)}"
    if n is not None and (n < place.fewest or (n == 1 and place.closed_curvature == 0)):
        chi = place.component.topology.characteristic
        least, cones = max(place.fewest, 2), "1 cone is" if n == 1 else f"{n} cones are"
        raise MeshError(
            f"{where} is closed, of Euler characteristic {chi}, and {cones} too few for angles of 90 degrees "
            f"and more at them: give at least {least}"
        )
    if n == 0 or not len(place.inner):
        return np.zeros(0, dtype=np.int64)
    return place.vertices(_grown(place, n, trade))


def _grown(place: ConeComponent, n: int | None, trade: float) -> IntArray:
    """The nodes of the first `n` cones; or of as many as cost least by stretch and number."""
    if n is not None:
        return _first(place, n)
    best, least, smallest, in_vain = np.zeros(0, dtype=np.int64), np.inf, np.inf, 0
    for scale in _growing(place, place.limit):
        many, cost = len(scale.nodes) >= place.enough, np.inf
        if place.closed_curvature == 0 and len(scale.nodes) == 1:
            least = scale.stretch  # that of no cones
        if len(scale.nodes) >= place.fewest:
            cost = scale.stretch + len(scale.nodes) / trade + _price(place, scale)
            # a few limbs without cones hide all that others save
            spread = scale.spread if many and scale.stretch >= constants.TOLERABLE_STRETCH else np.inf
            in_vain = 0 if cost < least or spread < smallest else in_vain + 1
            smallest = min(smallest, spread)
            if cost < least:
                best, least = scale.nodes, cost
        if (many or least < constants.TOLERABLE_STRETCH) and in_vain >= (
            constants.SINGLE_CONES if many and np.isinf(cost) else constants.MAX_IDLE_CONES
        ):
            break
    return best if np.isfinite(least) else _first(place, len(scale.nodes))


def _first(place: ConeComponent, n: int) -> IntArray:
    """The nodes of the first `n` cones, which can have angles of one scale, or quarter turns.

    Raises
    ------
    MeshError
        They can have neither.
    """
    *_, scale = _growing(place, n)
    angle = 2 * np.pi - scale.curvature
    beyond = np.flatnonzero(~_within(angle, place.valence[scale.nodes]))
    if len(beyond):
        turns = _quarters_of(place, scale).for_stretch
        if not _within(np.asarray(2 * np.pi - turns * QUARTER_TURN), place.valence[scale.nodes]).all():
            more = _growing(place, max(place.enough, 2 * n))
            enough = (len(s.nodes) for s in more if len(s.nodes) > n and _possible(place, s))
            raise MeshError(_too_few(place, scale, beyond[0], next(enough, None)))
    return scale.nodes


def _too_few(place: ConeComponent, scale: ConeScale, beyond: int, enough: int | None) -> str:
    """The message: a cone's angle is beyond what its triangles can have, and how many cones would do."""
    angle, around = 2 * np.pi - scale.curvature[beyond], place.valence[scale.nodes[beyond]]
    (vertex,) = place.component.vertices[place.vertices(scale.nodes[[beyond]])]
    help_ = "cut along seams instead: leave out cones" if enough is None else f"give at least {enough}"
    return (
        f"{len(scale.nodes)} cones are too few for the component of faces {some(place.component.faces)}, of "
        f"Euler characteristic {place.component.topology.characteristic}: the angle sum at vertex {vertex} "
        f"would be {angle:.4g} rad, and must be within 0 and {around} pi = {np.pi * around:.4g}: {help_}"
    )


def _growing(place: ConeComponent, most: int) -> Iterator[ConeScale]:
    """With the fewest cones, and then with one or more further ones at a time, up to a number of them."""
    scale = ConeScale.of(place.piece)
    while True:
        advance("cones", 0.1)
        yield scale
        further = _further(place, scale, min(most, len(place.inner)) - len(scale.nodes))
        if not len(further):
            return
        scale = scale.with_cones(further)


def _further(place: ConeComponent, scale: ConeScale, most: int) -> IntArray:
    """The node at which another cone helps most; if there are many cones, several far from each other."""
    far = np.abs(scale.log_scale)
    far[scale.nodes] = 0.0
    if most <= 0 or not far.any():
        return np.zeros(0, dtype=np.int64)
    strain = _strain(place, scale)
    strained = len(strain) > 0 and strain.max() > 0
    alone = len(scale.nodes) < place.enough or scale.stretch < constants.TOLERABLE_STRETCH
    if alone and not strained:
        return np.array([np.argmax(far)])
    away, _, source = place.piece.graph.shortest_paths(scale.nodes)
    if alone:
        near = np.where(source == scale.nodes[np.argmax(strain)], far, 0.0)
        return np.array([np.argmax(near if near.any() else far)])
    order = np.argsort(far, kind="stable")
    farthest = np.zeros(place.piece.graph.n, dtype=np.int64)
    farthest[source[order]] = order  # of the nodes nearest to each cone, where the scale is worst
    tried, room = farthest[scale.nodes], min(most, len(scale.nodes) // constants.CONES_PER_NEW_CONE)
    tried, strain = tried[far[tried] > 0], strain[far[tried] > 0]
    by_strain, by_scale = np.argsort(-strain, kind="stable"), np.argsort(-far[tried], kind="stable")
    helped = by_strain[strain[by_strain] > 0][: room // 2]
    return _apart(place.piece, tried[np.concatenate((helped, by_scale))], away / 2)[:room]


def _apart(piece: ClosedSurface, nodes: IntArray, distance: FloatArray) -> IntArray:
    """Those nodes that are as far as their distances from the ones before them."""
    kept = np.zeros(0, dtype=np.int64)
    for i in nodes.tolist():
        gap = np.linalg.norm(piece.graph.position[kept] - piece.graph.position[i], axis=1)
        if (gap >= distance[i]).all():
            kept = np.append(kept, i)
    return kept


def _price(place: ConeComponent, scale: ConeScale) -> float:
    """What strained cones cost: as much as usable stretch; or all, if no triangles have such angles."""
    if not _possible(place, scale):
        return np.inf
    return constants.TOLERABLE_STRETCH if (_strain(place, scale) > 0).any() else 0.0


def _possible(place: ConeComponent, scale: ConeScale) -> bool:
    """Whether triangles can have the angles of one scale at all cones; and quarter turns, too."""
    total, around = place.closed_curvature, place.valence[scale.nodes]
    room = total is None or least_quarters(around).sum() <= round(total / QUARTER_TURN)
    return bool(room and _within(2 * np.pi - scale.curvature, around).all())


def _within(angle: FloatArray, around: IntArray) -> BoolArray:
    """Whether so many triangles can have these angles together."""
    return np.asarray((angle > 0) & (angle < np.pi * around))


def least_quarters(around: IntArray, of_triangle: float = constants.QUARTERS_PER_TRIANGLE) -> IntArray:
    """The least curvature of a cone of so many triangles, in quarter turns."""
    least = 4 - np.floor(of_triangle * around).astype(np.int64)
    return np.asarray(np.minimum(least, MAX_QUARTERS))


def _quarters_of(place: ConeComponent, scale: ConeScale) -> QuantisedCurvatures:
    """The cones in quarter turns, with triangles as wide as little stretch asks for."""
    around = place.valence[scale.nodes]
    turns = QuantisedCurvatures(scale, least_quarters(around))
    enough = np.log(scale.stretch) + constants.WIDENING_LOG_STRETCH
    if turns.log_stretch <= enough:
        return turns
    wider = replace(turns, least=least_quarters(around, constants.QUARTERS_PER_WIDE_TRIANGLE))
    return wider if wider.log_stretch < turns.log_stretch - constants.WIDENING_LOG_STRETCH else turns


def _strain(place: ConeComponent, scale: ConeScale) -> FloatArray:
    """By how much each cone's angle is too narrow, or too wide for the faces at it; radians."""
    angle = 2 * np.pi - scale.curvature
    return np.maximum(
        constants.MIN_CONE_ANGLE - angle, angle - constants.MAX_ANGLE_AT_CONE * place.valence[scale.nodes]
    )


def cone_angles_of(
    place: ConeComponent, cones: IntArray, wanted: str | FloatArray | None
) -> tuple[FloatArray, ConeScale | None, QuantisedCurvatures | None]:
    """Angle sums of the cones of a component: as they are given, of one scale, or in quarter turns.

    Also returns the scale that they follow from, and the quarter turns, which may be exchanged afterwards.

    Raises
    ------
    MeshError
        They do not obey Gauss-Bonnet, or are not within what triangles can take.
    """
    component, total = place.component, place.closed_curvature
    names, scale, quarters = component.vertices[cones], None, None
    around = place.valence[place.piece.node[cones]]
    if isinstance(wanted, np.ndarray):
        angle = wanted
        if total is not None and not abs((2 * np.pi - angle).sum() - total) < 1e-6:
            right = 2 * np.pi * len(cones) - total
            raise MeshError(
                f"the angles of cones at vertices {some(names)} sum to {angle.sum():.6g} rad; on a "
                f"closed surface of Euler characteristic {component.topology.characteristic}, "
                f"those of {len(cones)} cones have to sum to {right:.6g} (Gauss-Bonnet): "
                f"change them by {right - angle.sum():+.6g} in all"
                + (", or from degrees to radians" if np.isclose(np.deg2rad(angle).sum(), right) else "")
            )
    else:
        needed = place.fewest
        if len(cones) < needed or (total == 0 and len(cones) == 1):
            given = f"{len(cones)} cones ({some(names)}) are" if len(cones) else "no cones are"
            raise MeshError(
                f"{given} too few for the component of faces "
                f"{some(component.faces)}, which is closed, of Euler characteristic "
                f"{component.topology.characteristic}: give at least {max(needed, 2)}"
            )
        if not len(cones):
            return np.zeros(0), None, None
        scale = ConeScale.at(place.piece, place.piece.node[cones])
        curvature: FloatArray = scale.curvature
        if wanted == "quarter":
            quarters = _quarters_of(place, scale)
            curvature = np.asarray(quarters.for_stretch * QUARTER_TURN)
        angle = 2 * np.pi - curvature
    bad = np.flatnonzero(~_within(angle, around))
    if len(bad):
        i = bad[0]
        given, other = ("would be", "your own") if wanted is None else ("is", "other")
        raise MeshError(
            f"the angle sum of {len(bad)} of {len(cones)} cones is outside of what triangles can have: at "
            f"vertex {names[i]} it {given} {angle[i]:.4g} rad, and must be within 0 and {around[i]} pi = "
            f"{np.pi * around[i]:.4g}: give more cones near vertices {some(names[bad])}, or {other} "
            "angles"
        )
    return np.asarray(angle), scale, quarters
