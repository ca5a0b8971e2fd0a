"""Represent a component as a closed surface: each hole is contracted to one node."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import FloatArray, IntArray
from ...surface import Submesh, sum_by_index
from ..features import CreasedSurface
from .constants import MAX_BOND_WEIGHT, MIN_BOND_WEIGHT
from .graph import SurfaceGraph
from .laplacians import SurfaceLaplacian


@dataclass(frozen=True, eq=False)
class ClosedSurface:
    """A component as a closed surface: each boundary loop is contracted to one node.

    If the complement of a graph on the closed surface is a disk, cutting the component along the graph also
    leaves a disk, no matter where the graph meets the boundary.

    Attributes
    ----------
    graph : SurfaceGraph
        The graph of the interior edges. Edges are shorter where a seam is less visible: along creases, and on
        hidden sides. A polygon is one face, and its diagonals are not edges of the graph.
    node : (#V,) int64
        The node of each vertex. Interior vertices keep their order.
    edges : (#E, 2) int64
        The vertices at each edge.
    hiding : (#E,) float64
        Factor on the length of each edge: above 1 if a seam there would be visible, below 1 if it would be
        hidden.
    curvature, area : (n,) float64
        Angle defects, radians, and vertex areas.
    laplacian : SurfaceLaplacian
    size : float
        Square root of the area.
    isometric : bool
        Whether the map is to preserve lengths instead of angles.
    """

    graph: SurfaceGraph
    node: IntArray
    edges: IntArray
    hiding: FloatArray
    curvature: FloatArray
    area: FloatArray
    laplacian: SurfaceLaplacian
    size: float
    isometric: bool = False

    @classmethod
    def from_submesh(cls, component: Submesh, isometric: bool = False) -> ClosedSurface:
        """Contract the boundary loops of a connected surface."""
        return cls.from_creased_surface(CreasedSurface(component), isometric)

    @classmethod
    def from_creased_surface(cls, creased: CreasedSurface, isometric: bool = False) -> ClosedSurface:
        """Contract the boundary loops of a connected surface, given as a `CreasedSurface`."""
        component = creased.surface
        V, topology = component.V, component.topology
        holes = len(topology.loops)
        node = np.full(len(V), -1)
        for i, loop in enumerate(topology.loops):
            node[loop] = i
        n = holes + int(np.count_nonzero(node < 0))
        node[node < 0] = np.arange(holes, n)
        cell, inside = component.polygon_labels, topology.interior_edges
        taken = np.searchsorted(inside, component.cuttable_edges)
        edges, beside = creased.edge_ends[taken], cell[creased.faces_of_edges[taken]]
        double_area, dot = component.areas_and_products
        vertex = np.empty(n, dtype=np.int64)
        vertex[node] = np.arange(len(V))
        cotangent = topology.sum_at_edges(dot / double_area)[inside] / 2
        weight = np.clip(cotangent, MIN_BOND_WEIGHT, MAX_BOND_WEIGHT)
        price, faces = creased.search_price[taken], int(cell.max()) + 1
        return cls(
            SurfaceGraph(n, holes, topology.genus, faces, node[edges], beside, price, V[vertex]),
            node=node,
            edges=edges,
            hiding=creased.visibility_factor[taken],
            curvature=np.asarray(2 * np.pi - np.bincount(node, component.angle_sums, n)),
            area=sum_by_index(node[topology.corner].ravel(), np.tile(double_area / 6, 3), n),
            laplacian=SurfaceLaplacian(n, node[topology.interior_edge_ends], cotangent, weight),
            size=float(np.sqrt(double_area.sum() / 2)),
            isometric=isometric,
        )

    @cached_property
    def has_hidden_edges(self) -> bool:
        """Return True if `hiding` changes the length of any edge."""
        return bool((self.hiding != 1).any())

    @cached_property
    def hiding_at_nodes(self) -> FloatArray:
        """Mean of `hiding` over the edges at each node, (n,); 1 at nodes without edges."""
        n, ends = self.graph.n, self.graph.ends.ravel()
        total = np.bincount(ends, np.repeat(self.hiding, 2), n)
        number = np.bincount(ends, minlength=n)
        return np.where(number, total, 1.0) / np.maximum(number, 1)
