"""Cones: the few vertices that keep all curvature when the rest of a surface is flattened."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import advance
from .._types import FloatArray, IntArray
from ..errors import MeshError, some
from ..surface import Submesh
from .cone_scale import ConeScale
from .cut_graph import ClosedSurface, closed_surface
from .quarter_turns import QUARTER, QuarterTurns

CONE_TRADE = 30.0
MAX_CONES = 100  # on a component, if they are to be found
IN_VAIN = 4  # cones in a row that do not pay, before no more are tried
USABLE, IN_VAIN_AT_FIRST = 3.0, 30  # and as long as stretch and price together are not below that
NARROW = np.pi / 3  # angle of a cone below which another one helps it
WIDE = 0.75 * np.pi  # angle of a triangle at a cone above which another one helps it
MOST_QUARTERS = 3  # of curvature at a cone
QUARTERS_OF_TRIANGLE = 4 / 3  # quarter turns that a triangle at a cone may take, so that it has 120 degrees


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
        expected stretch falls, at most 100 a component.

    Returns
    -------
    cones : (#C,) int64
        Interior vertices, component by component; on each the most useful ones first.

    Raises
    ------
    MeshError
        The arrays are malformed, the surface is not an oriented manifold, or a face is degenerate; or
        `n` is too small for a component.
    ValueError
        `trade` is not positive.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> len(find_cones(V, F, 4))
    4
    >>> len(find_cones(V[:4], F[:2]))  # no interior vertex, no cone
    0
    """
    surface = Submesh.checked_manifold(V, F)
    found = [
        component.vertices[found_on(ConePiece(component), n, trade)] for component in surface.components()
    ]
    return np.concatenate(found)


@dataclass(frozen=True, eq=False)
class ConePiece:
    """A component on which cones are placed."""

    component: Submesh

    @cached_property
    def piece(self) -> ClosedSurface:
        """Its graph."""
        return closed_surface(self.component)

    @cached_property
    def inner(self) -> IntArray:
        """Its interior vertices, the nodes after those of the holes."""
        return np.flatnonzero(self.component.topology.interior)

    @cached_property
    def valence(self) -> IntArray:
        """Faces at each node that is no hole; 0 at those."""
        around = np.bincount(self.component.F.ravel(), minlength=len(self.component.V))
        return np.append(np.zeros(self.piece.holes, dtype=np.int64), around[self.inner])

    @property
    def closed_curvature(self) -> float | None:
        """What the curvatures of the cones sum to, if the surface is closed."""
        return None if self.piece.holes else 2 * np.pi * self.component.topology.characteristic

    @property
    def fewest(self) -> int:
        """Number of cones of 90 degrees at least without which it cannot be flat."""
        total = self.closed_curvature
        return 0 if total is None or total == 0 else 3 if total > 0 else 1

    def vertices(self, nodes: IntArray) -> IntArray:
        """The component's vertices of nodes that are no holes."""
        return self.inner[nodes - self.piece.holes]


def found_on(place: ConePiece, n: int | None, trade: float) -> IntArray:
    """Cones on a component; its own vertices."""
    if not trade > 0:
        raise ValueError(f"trade is {trade!r}: use a positive number of cones")
    where = f"the component of faces {some(place.component.faces)}"
    if n is not None and (n < place.fewest or (n == 1 and place.closed_curvature == 0)):
        chi = place.component.topology.characteristic
        least = max(place.fewest, 2)
        raise MeshError(
            f"{where} is closed, of Euler characteristic {chi}, and {n} cones are too few for angles of 90 "
            f"degrees and more at them: give at least {least}"
        )
    if n == 0 or not len(place.inner):
        return np.zeros(0, dtype=np.int64)
    return place.vertices(_grown(place, n, trade))


def _grown(place: ConePiece, n: int | None, trade: float) -> IntArray:
    """Add cones one by one; return the nodes of those of least cost, or the first `n`."""
    scale = ConeScale.of(place.piece)
    best, least, in_vain = scale.nodes, np.inf, 0
    if n is None and place.closed_curvature == 0:
        best, least = best[:0], scale.stretch
    most = min(MAX_CONES if n is None else n, len(place.inner))
    while True:
        strain = _strain(place, scale)
        bad = bool(len(strain)) and strain.max() > 0
        if n is None and len(scale.nodes) >= place.fewest:
            cost = scale.stretch + len(scale.nodes) / trade + _price(place, scale, bad)
            in_vain = 0 if cost < least else in_vain + 1
            if cost < least:
                best, least = scale.nodes, cost
        advance("cones", 0.1)
        patience = IN_VAIN if least < USABLE else IN_VAIN_AT_FIRST
        if len(scale.nodes) >= most or in_vain >= patience:
            break
        far = np.abs(scale.log_scale)
        far[scale.nodes] = 0.0
        if bad:
            _, _, source = place.piece.search(scale.nodes)
            near = np.where(source == scale.nodes[np.argmax(strain)], far, 0.0)
            far = near if near.any() else far
        if not far.any():
            break
        scale = scale.with_cones(np.array([np.argmax(far)]))
    return scale.nodes if n is not None or not np.isfinite(least) else best


def _price(place: ConePiece, scale: ConeScale, strained: bool) -> float:
    """What strained cones cost: as much as usable stretch; or all, if no triangles have such angles."""
    angle = 2 * np.pi - scale.curvature
    possible = ((angle > 0) & (angle < np.pi * place.valence[scale.nodes])).all()
    return np.inf if not possible else USABLE if strained else 0.0


def _strain(place: ConePiece, scale: ConeScale) -> FloatArray:
    """By how much each cone's angle is too narrow, or too wide for the faces at it; radians."""
    angle = 2 * np.pi - scale.curvature
    return np.maximum(NARROW - angle, angle - WIDE * place.valence[scale.nodes])


def angles_of(
    place: ConePiece, cones: IntArray, wanted: str | FloatArray | None
) -> tuple[FloatArray, ConeScale | None, QuarterTurns | None]:
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
                f"cone_angles at vertices {some(names)} sum to {angle.sum():.6g} rad; on a closed surface of "
                f"Euler characteristic {component.topology.characteristic}, those of {len(cones)} cones "
                f"have to sum to {right:.6g} (Gauss-Bonnet): change them by {right - angle.sum():+.6g} in all"
            )
    else:
        needed = place.fewest
        if len(cones) < needed or (total == 0 and len(cones) == 1):
            raise MeshError(
                f"{len(cones)} cones ({some(names)}) are too few for the component of faces "
                f"{some(component.faces)}, which is closed, of Euler characteristic "
                f"{component.topology.characteristic}: give at least {max(needed, 2)}"
            )
        if not len(cones):
            return np.zeros(0), None, None
        scale = ConeScale.at(place.piece, place.piece.node[cones])
        curvature: FloatArray = scale.curvature
        if wanted == "quarter":
            least = 4 - np.floor(QUARTERS_OF_TRIANGLE * around).astype(np.int64)
            quarters = QuarterTurns(scale, np.minimum(least, MOST_QUARTERS), MOST_QUARTERS)
            curvature = np.asarray(quarters.for_stretch * QUARTER)
        angle = 2 * np.pi - curvature
    bad = np.flatnonzero(~((angle > 0) & (angle < np.pi * around)))
    if len(bad):
        i = bad[0]
        given = "would be" if wanted is None else "is"
        raise MeshError(
            f"the angle sum of {len(bad)} of {len(cones)} cones is outside of what triangles can have: at "
            f"vertex {names[i]} it {given} {angle[i]:.4g} rad, and must be within 0 and {around[i]} pi = "
            f"{np.pi * around[i]:.4g}: give larger cone_angles, more cones near vertices {some(names[bad])}, "
            "or let find_cones place them"
        )
    return np.asarray(angle), scale, quarters
