"""Place cones one by one where the conformal scale is farthest from 1, and choose their angles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..._runtime import advance
from ..._types import BoolArray, FloatArray, IntArray
from ...angles import ClosedPath
from ...errors import MeshError, first_few, format_count, is_number
from ...surface import Submesh
from ..cut_graphs import ClosedSurface
from .constants import CONES_PER_STRETCH, MAX_QUARTERS, QUARTER_TURN
from .quantisation import QuantisedCurvatures
from .scale import ConeScale
from .seams import cut_handles, find_closed_paths, find_seam

# Number of cones up to which cones are added one by one, not in batches.
# The search also ends after this many cones in a row without feasible angles.
SINGLE_CONES = 100
CONES_PER_NEW_CONE = 16  # a batch of new cones has one cone for this many existing cones
MAX_GREEN_VALUES = 200_000_000  # maximum number of stored values of Green's functions: nodes times cones
MIN_VERTICES_PER_CONE = 8  # minimum number of interior vertices per cone, beyond `SINGLE_CONES` cones
MAX_IDLE_CONES = 4  # the search ends after this many cones in a row that do not lower the cost
# L2 stretch plus price of the cones below which the search may end; also the penalty for strained cones.
TOLERABLE_STRETCH = 3.0
MIN_CONE_ANGLE = np.pi / 3  # cones with a smaller angle sum, radians, are strained
MAX_ANGLE_AT_CONE = 0.75 * np.pi  # cones with a larger mean triangle angle, radians, are strained
QUARTERS_PER_TRIANGLE = 120 / 90  # maximum angle of each triangle at a cone, in quarter turns


def find_cones(
    V: ArrayLike, F: ArrayLike, n: int | None = None, *, cones_per_stretch: float = CONES_PER_STRETCH
) -> IntArray:
    """Find cones: vertices that allow the rest of the surface to be flattened with little stretch.

    Cones are added one by one. The conformal map for the current cones is flat except at the cones, and has
    scale 1 at the cones and at the boundary. The next cone is placed where the logarithm of the scale is
    farthest from zero, which is at the tips of limbs and in the crotches between limbs. If the angle of a
    cone would be less than 60 degrees, or larger than its triangles allow, the next cone is placed near it.
    The Laplacian of the surface is factored only once for all cones.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles with any number of components, boundary loops and handles.
    n : int, optional
        Number of cones on each component. If a component has fewer interior vertices, all of them are cones.
        By default cones are added as long as the saved stretch is worth another cone, see
        `cones_per_stretch`.
    cones_per_stretch : float
        Number of additional cones that a decrease of the L2 stretch by 1 is worth. With a large
        number, cones are added as long as the expected stretch falls. Beyond 100 cones on a component,
        several cones are added at a time until all limbs have cones.

    Returns
    -------
    cones : (#C,) int64
        Interior vertices, component by component; on each component, the most useful cones come first.

    Raises
    ------
    MeshError
        The arrays are malformed, the surface is not an oriented manifold, a face is degenerate, or `n` is too
        small: the triangles at a cone could not have the required angle sum.
    ValueError
        `n` is not a number of cones, or `cones_per_stretch` is not positive.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> len(find_cones(V, F, 4))
    4
    >>> len(find_cones(V[:4], F[:2]))  # without interior vertices, there are no cones
    0
    """
    if n is not None and not is_number(n, 0, whole=True):
        raise ValueError(f"n is {n!r}: give a whole number of cones, or None for as many as pay")
    surface = Submesh.manifold_from_input(V, F)
    found = [
        component.vertices[find_cones_on_component(ConeComponent(component), n, cones_per_stretch)]
        for component in surface.split_components()
    ]
    return np.concatenate(found)


@dataclass(frozen=True, eq=False)
class ConeComponent:
    """A component on which cones are placed."""

    component: Submesh

    @cached_property
    def closed_surface(self) -> ClosedSurface:
        """The component as a closed surface: each hole is contracted to a node."""
        return ClosedSurface.from_submesh(self.component)

    @cached_property
    def handle_cut_graph(self) -> IntArray:
        """Edges of `closed_surface` along which its handles are cut open."""
        return cut_handles(self.closed_surface)

    @cached_property
    def closed_paths(self) -> tuple[ClosedPath, ...]:
        """Closed paths around holes and along handles, from `find_closed_paths`; independent of the cones."""
        seam = find_seam(self.closed_surface, np.zeros(0, dtype=np.int64), self.handle_cut_graph)
        return find_closed_paths(self.component, self.closed_surface.graph, seam)

    @cached_property
    def interior_vertices(self) -> IntArray:
        """The interior vertices, in the order of the nodes after the holes."""
        return np.flatnonzero(self.component.topology.is_interior)

    @cached_property
    def valence(self) -> IntArray:
        """Number of faces around each node; 0 for nodes that are holes."""
        around = np.bincount(self.component.F.ravel(), minlength=len(self.component.V))
        return np.append(
            np.zeros(self.closed_surface.graph.n_holes, dtype=np.int64), around[self.interior_vertices]
        )

    @property
    def total_curvature_if_closed(self) -> float | None:
        """Sum of the curvatures of all cones if the surface is closed, otherwise None; radians."""
        return (
            None if self.closed_surface.graph.n_holes else 2 * np.pi * self.component.topology.characteristic
        )

    @property
    def min_cones(self) -> int:
        """Least number of cones with angles of at least 90 degrees that can hold all curvature."""
        total = self.total_curvature_if_closed
        return 0 if total is None or total == 0 else 3 if total > 0 else 1

    @property
    def n_single_cones(self) -> int:
        """Number of cones up to which cones are added one by one. Few surfaces need more cones."""
        return max(SINGLE_CONES, 2 * abs(self.component.topology.characteristic))

    @property
    def max_cones(self) -> int:
        """Maximum number of cones to find on the component."""
        by_memory = MAX_GREEN_VALUES // self.closed_surface.graph.n
        return max(self.n_single_cones, min(by_memory, len(self.interior_vertices) // MIN_VERTICES_PER_CONE))

    def convert_to_vertices(self, nodes: IntArray) -> IntArray:
        """Convert nodes that are not holes to vertices of the component."""
        return self.interior_vertices[nodes - self.closed_surface.graph.n_holes]


def find_cones_on_component(place: ConeComponent, n: int | None, cones_per_stretch: float) -> IntArray:
    """Find cones on a component, and return them as vertices of the component."""
    if not is_number(cones_per_stretch, 0, above=True):
        raise ValueError(f"cones_per_stretch is {cones_per_stretch!r}: use a positive number of cones")
    where = f"the component of faces {first_few(place.component.faces)}"
    if n is not None and (n < place.min_cones or (n == 1 and place.total_curvature_if_closed == 0)):
        chi = place.component.topology.characteristic
        least, cones = max(place.min_cones, 2), "1 cone is" if n == 1 else f"{n} cones are"
        raise MeshError(
            f"{where} is closed, of Euler characteristic {chi}, and {cones} too few for angles of 90 degrees "
            f"and more at them: give at least {least}"
        )
    if n == 0 or not len(place.interior_vertices):
        return np.zeros(0, dtype=np.int64)
    return place.convert_to_vertices(_choose_cones(place, n, cones_per_stretch))


def _choose_cones(place: ConeComponent, n: int | None, cones_per_stretch: float) -> IntArray:
    """Return the nodes of `n` cones or, if `n` is None, of the cones of least stretch plus price."""
    if n is not None:
        return _choose_first_cones(place, n)
    best, least, smallest, idle = np.zeros(0, dtype=np.int64), np.inf, np.inf, 0
    for scale in _grow_cones(place, place.max_cones):
        many, cost = len(scale.nodes) >= place.n_single_cones, np.inf
        if place.total_curvature_if_closed == 0 and len(scale.nodes) == 1:
            least = scale.expected_stretch  # on a torus, the only cone has curvature 0
        if len(scale.nodes) >= place.min_cones:
            cost = (
                scale.expected_stretch
                + len(scale.nodes) / cones_per_stretch
                + _compute_strain_penalty(place, scale)
            )
            # the stretch hardly falls while any limb lacks a cone: watch the spread of the scale, too
            spread = (
                scale.log_scale_deviation if many and scale.expected_stretch >= TOLERABLE_STRETCH else np.inf
            )
            idle = 0 if cost < least or spread < smallest else idle + 1
            smallest = min(smallest, spread)
            if cost < least:
                best, least = scale.nodes, cost
        if (many or least < TOLERABLE_STRETCH) and idle >= (
            SINGLE_CONES if many and np.isinf(cost) else MAX_IDLE_CONES
        ):
            break
    return best if np.isfinite(least) else _choose_first_cones(place, len(scale.nodes))


def _choose_first_cones(place: ConeComponent, n: int) -> IntArray:
    """Return the nodes of the first `n` cones.

    Raises
    ------
    MeshError
        Triangles at a cone can have neither the angle sum for equal scale nor a multiple of 90 degrees.
    """
    *_, scale = _grow_cones(place, n)
    angle = 2 * np.pi - scale.cone_curvatures
    beyond = np.flatnonzero(~_mask_feasible_sums(angle, place.valence[scale.nodes]))
    if len(beyond):
        turns = _quantise_curvatures(place, scale).quarters_for_stretch
        if not _mask_feasible_sums(
            np.asarray(2 * np.pi - turns * QUARTER_TURN), place.valence[scale.nodes]
        ).all():
            more = _grow_cones(place, max(place.n_single_cones, 2 * n))
            enough = (len(s.nodes) for s in more if len(s.nodes) > n and _is_feasible(place, s))
            raise MeshError(_describe_too_few(place, scale, beyond[0], next(enough, None)))
    return scale.nodes


def _describe_too_few(place: ConeComponent, scale: ConeScale, beyond: int, enough: int | None) -> str:
    """Return an error message: a cone's angle is not feasible, and `enough` cones are needed."""
    angle, around = 2 * np.pi - scale.cone_curvatures[beyond], place.valence[scale.nodes[beyond]]
    (vertex,) = place.component.vertices[place.convert_to_vertices(scale.nodes[[beyond]])]
    help_ = "cut along seams instead: leave out cones" if enough is None else f"give at least {enough}"
    return (
        f"{format_count(len(scale.nodes), 'cone')} {'is' if len(scale.nodes) == 1 else 'are'} too few "
        f"for the component of faces {first_few(place.component.faces)}, of "
        f"Euler characteristic {place.component.topology.characteristic}: the angle sum at vertex {vertex} "
        f"would be {angle:.4g} rad, and must be within 0 and {around} pi = {np.pi * around:.4g}: {help_}"
    )


def _grow_cones(place: ConeComponent, most: int) -> Iterator[ConeScale]:
    """Yield conformal scales with more and more cones, up to `most` cones."""
    scale = ConeScale.with_least_cones(place.closed_surface)
    while True:
        advance("cones", 0.1)
        yield scale
        further = _find_next_cones(place, scale, min(most, len(place.interior_vertices)) - len(scale.nodes))
        if not len(further):
            return
        scale = scale.add_cones(further)


def _find_next_cones(place: ConeComponent, scale: ConeScale, most: int) -> IntArray:
    """Return the node where a new cone saves most stretch. If there are many cones, return several nodes."""
    far = np.abs(scale.log_scale)
    far[scale.nodes] = 0.0
    if most <= 0 or not far.any():
        return np.zeros(0, dtype=np.int64)
    strain = _measure_strain(place, scale)
    strained = len(strain) > 0 and strain.max() > 0
    alone = len(scale.nodes) < place.n_single_cones or scale.expected_stretch < TOLERABLE_STRETCH
    if alone and not strained:
        return np.array([np.argmax(far)])
    away, _, source = place.closed_surface.graph.find_shortest_paths(scale.nodes)
    if alone:
        near = np.where(source == scale.nodes[np.argmax(strain)], far, 0.0)
        return np.array([np.argmax(near if near.any() else far)])
    order = np.argsort(far, kind="stable")
    farthest = np.zeros(place.closed_surface.graph.n, dtype=np.int64)
    farthest[source[order]] = order  # for each cone: node of its Voronoi cell with u farthest from 0
    tried, room = farthest[scale.nodes], min(most, len(scale.nodes) // CONES_PER_NEW_CONE)
    tried, strain = tried[far[tried] > 0], strain[far[tried] > 0]
    by_strain, by_scale = np.argsort(-strain, kind="stable"), np.argsort(-far[tried], kind="stable")
    helped = by_strain[strain[by_strain] > 0][: room // 2]
    return _select_distant(place.closed_surface, tried[np.concatenate((helped, by_scale))], away / 2)[:room]


def _select_distant(piece: ClosedSurface, nodes: IntArray, distance: FloatArray) -> IntArray:
    """Select nodes greedily; node i is at least `distance[i]` away from all nodes selected before."""
    kept = np.zeros(0, dtype=np.int64)
    for i in nodes.tolist():
        gap = np.linalg.norm(piece.graph.position[kept] - piece.graph.position[i], axis=1)
        if (gap >= distance[i]).all():
            kept = np.append(kept, i)
    return kept


def _compute_strain_penalty(place: ConeComponent, scale: ConeScale) -> float:
    """Return the penalty for strained cones, which is infinite if triangles cannot have the cone angles."""
    if not _is_feasible(place, scale):
        return np.inf
    return TOLERABLE_STRETCH if (_measure_strain(place, scale) > 0).any() else 0.0


def _is_feasible(place: ConeComponent, scale: ConeScale) -> bool:
    """Return True if triangles can have the cone angles for equal scale, and also multiples of 90 degrees."""
    total, around = place.total_curvature_if_closed, place.valence[scale.nodes]
    room = total is None or find_least_quarters(around).sum() <= round(total / QUARTER_TURN)
    return bool(room and _mask_feasible_sums(2 * np.pi - scale.cone_curvatures, around).all())


def _mask_feasible_sums(angle: FloatArray, around: IntArray) -> BoolArray:
    """Return a mask of the angle sums that are possible with `around` triangles at each cone."""
    return np.asarray((angle > 0) & (angle < np.pi * around))


def find_least_quarters(around: IntArray) -> IntArray:
    """Return the minimum curvature of a cone with `around` triangles, in quarter turns."""
    least = 4 - np.floor(QUARTERS_PER_TRIANGLE * around).astype(np.int64)
    return np.asarray(np.minimum(least, MAX_QUARTERS))


def _quantise_curvatures(place: ConeComponent, scale: ConeScale) -> QuantisedCurvatures:
    """Return the curvatures of the cones of `scale` as multiples of a quarter turn."""
    return QuantisedCurvatures(scale, find_least_quarters(place.valence[scale.nodes]))


def _measure_strain(place: ConeComponent, scale: ConeScale) -> FloatArray:
    """Return how far each cone's angle sum is outside the range of unstrained cones, radians."""
    angle = 2 * np.pi - scale.cone_curvatures
    return np.maximum(MIN_CONE_ANGLE - angle, angle - MAX_ANGLE_AT_CONE * place.valence[scale.nodes])


def choose_cone_angles(
    place: ConeComponent, cones: IntArray, wanted: str | FloatArray | None
) -> tuple[FloatArray, ConeScale | None, QuantisedCurvatures | None]:
    """Return the angle sums of the cones of a component.

    `wanted` has the angle sums, or is None for equal scale at all cones, or "quarter" for multiples of 90
    degrees. Also return the scale that determines the angles, and the quantised curvatures.

    Raises
    ------
    MeshError
        The angles do not obey Gauss-Bonnet, or are not feasible for triangles.
    """
    component, total = place.component, place.total_curvature_if_closed
    names, scale, quarters = component.vertices[cones], None, None
    around = place.valence[place.closed_surface.node[cones]]
    if isinstance(wanted, np.ndarray):
        angle = wanted
        if total is not None and not abs((2 * np.pi - angle).sum() - total) < 1e-6:
            right = 2 * np.pi * len(cones) - total
            raise MeshError(
                f"the angles of cones at vertices {first_few(names)} sum to {angle.sum():.6g} rad; on a "
                f"closed surface of Euler characteristic {component.topology.characteristic}, "
                f"those of {format_count(len(cones), 'cone')} have to sum to {right:.6g} (Gauss-Bonnet): "
                f"change them by {right - angle.sum():+.6g} in all"
                + (", or from degrees to radians" if np.isclose(np.deg2rad(angle).sum(), right) else "")
            )
    else:
        needed = place.min_cones
        if len(cones) < needed or (total == 0 and len(cones) == 1):
            given = f"{len(cones)} cones ({first_few(names)}) are" if len(cones) else "no cones are"
            raise MeshError(
                f"{given} too few for the component of faces "
                f"{first_few(component.faces)}, which is closed, of Euler characteristic "
                f"{component.topology.characteristic}: give at least {max(needed, 2)}"
            )
        if not len(cones):
            return np.zeros(0), None, None
        scale = ConeScale.from_nodes(place.closed_surface, place.closed_surface.node[cones])
        curvature: FloatArray = scale.cone_curvatures
        if wanted == "quarter":
            quarters = _quantise_curvatures(place, scale)
            curvature = np.asarray(quarters.quarters_for_stretch * QUARTER_TURN)
        angle = 2 * np.pi - curvature
    bad = np.flatnonzero(~_mask_feasible_sums(angle, around))
    if len(bad):
        i = bad[0]
        given, other = ("would be", "your own") if wanted is None else ("is", "other")
        raise MeshError(
            f"the angle sum of {len(bad)} of {len(cones)} cones is outside of what triangles can have: at "
            f"vertex {names[i]} it {given} {angle[i]:.4g} rad, and must be within 0 and {around[i]} pi = "
            f"{np.pi * around[i]:.4g}: give more cones near vertices {first_few(names[bad])}, or {other} "
            "angles"
        )
    return np.asarray(angle), scale, quarters
