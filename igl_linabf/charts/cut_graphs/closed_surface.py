"""A component as a closed surface: each hole is contracted to a node."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np

from ..._core import lengths
from ..._types import FloatArray, IntArray
from ...surface import Submesh, sum_by
from ..features import Smoothing, dihedral_angles, hiding_factors, valley_factors
from .constants import CREASE_DISCOUNT, MAX_BOND_WEIGHT, MIN_BOND_WEIGHT
from .graph import SurfaceGraph
from .laplacians import SurfaceLaplacian


@dataclass(frozen=True, eq=False)
class EdgeFeatures:
    """What a seam along each edge of a closed surface is like.

    Attributes
    ----------
    length : (#E,) float64
        In space.
    hiding : (#E,) float64
        What the length is multiplied by where the caller wants seams, or does not: below and above 1.
    valleys : callable
        Makes `valley`: few need it.
    """

    length: FloatArray
    hiding: FloatArray
    valleys: Callable[[], FloatArray]

    @cached_property
    def valley(self) -> FloatArray:
        """(#E,): what the length is multiplied by when arcs slide into valleys; below 1 in concave ones."""
        return self.valleys()


@dataclass(frozen=True, eq=False)
class ClosedSurface:
    """A component as a closed surface: each boundary loop is contracted to a node of its own.

    A graph on it whose complement is a disk also cuts the component to a disk, wherever it meets
    the boundary. So holes need no special treatment.

    Attributes
    ----------
    graph : SurfaceGraph
        Its edges are those with two faces, shorter where a seam shows less: at creases, and where it is
        hidden. A polygon is one face: its diagonals are no edges.
    node : (#V,) int64
        The node of each vertex. Interior vertices keep their order.
    edges : (#E, 2) int64
        The vertices at each edge.
    features : EdgeFeatures
    curvature, area : (n,) float64
        Angle defects and vertex areas.
    laplacian : SurfaceLaplacian
    size : float
        Square root of the area.
    isometric : bool
        Whether the map is to keep lengths, not angles.
    """

    graph: SurfaceGraph
    node: IntArray
    edges: IntArray
    features: EdgeFeatures
    curvature: FloatArray
    area: FloatArray
    laplacian: SurfaceLaplacian
    size: float
    isometric: bool = False

    @classmethod
    def of(
        cls,
        component: Submesh,
        hidden: FloatArray | None = None,
        isometric: bool = False,
        bend: FloatArray | None = None,
    ) -> ClosedSurface:
        """Contract the boundary loops of a surface in one piece.

        `hidden` is as `hiding_weights` returns it; `bend` are the `dihedral_angles`, if they are known.
        """
        V, topology = component.V, component.topology
        holes = len(topology.loops)
        node = np.full(len(V), -1)
        for i, loop in enumerate(topology.loops):
            node[loop] = i
        n = holes + int(np.count_nonzero(node < 0))
        node[node < 0] = np.arange(holes, n)
        cell, inside = component.polygon_labels, component.cuttable_edges
        edges, beside = topology.edges_inside, topology.faces_inside
        every, bend = topology.inside, dihedral_angles(component) if bend is None else bend
        if component.inner is not None:
            taken = np.searchsorted(every, inside)
            edges, beside, bend = edges[taken], cell[beside[taken]], bend[taken]
        in_space = lengths(V, topology.edges[inside])
        double_area, dot = component.measured
        size = float(np.sqrt(double_area.sum() / 2))
        smoothing = cache(partial(Smoothing, component, edges, in_space))
        seen = (
            np.ones(len(edges))
            if hidden is None
            else hiding_factors(component, edges, hidden, smoothing(), size)
        )
        vertex = np.empty(n, dtype=np.int64)
        vertex[node] = np.arange(len(V))
        cotangent = topology.sum_at_edges(dot / double_area)[every] / 2
        weight = np.clip(cotangent, MIN_BOND_WEIGHT, MAX_BOND_WEIGHT)
        length = seam_lengths(in_space, bend) * seen
        return cls(
            SurfaceGraph(
                n, holes, topology.genus, int(cell.max()) + 1, node[edges], beside, length, V[vertex]
            ),
            node=node,
            edges=edges,
            features=EdgeFeatures(
                in_space, seen, lambda: valley_factors(component, edges, in_space, bend, smoothing(), size)
            ),
            curvature=np.asarray(2 * np.pi - np.bincount(node, component.angle_sums, n)),
            area=sum_by(node[topology.corner].ravel(), np.tile(double_area / 6, 3), n),
            laplacian=SurfaceLaplacian(n, node[topology.edges_inside], cotangent, weight),
            size=size,
            isometric=isometric,
        )

    @cached_property
    def hides(self) -> bool:
        """Whether some seams are better hidden than others."""
        return bool((self.features.hiding != 1).any())

    @cached_property
    def node_hiding(self) -> FloatArray:
        """By what hiding multiplies lengths on average at each node, (n,)."""
        n, ends = self.graph.n, self.graph.ends.ravel()
        total = np.bincount(ends, np.repeat(self.features.hiding, 2), n)
        number = np.bincount(ends, minlength=n)
        return np.where(number, total, 1.0) / np.maximum(number, 1)

    def with_lengths(self, length: FloatArray) -> ClosedSurface:
        """The same with other lengths of its edges."""
        return replace(self, graph=replace(self.graph, length=length))


def seam_lengths(length: FloatArray, bend: FloatArray) -> FloatArray:
    """The lengths of edges for a seam, which shows less along bends."""
    return np.asarray(length * (1 - CREASE_DISCOUNT * np.minimum(np.abs(bend) / (np.pi / 2), 1)))
