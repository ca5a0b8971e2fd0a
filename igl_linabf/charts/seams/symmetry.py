"""Mirror planes: a body that is symmetric is cut alike on both sides."""

from dataclasses import dataclass

import numpy as np
import scipy

from ..._types import IntArray
from ...surface import Submesh
from ..cut_graphs import ClosedSurface, SurfaceGraph
from . import constants


def mirrored_vertices(component: Submesh) -> IntArray | None:
    """The vertex in the place of each one's mirror image, in a plane through the principal axes; or None."""
    V = component.V
    double_area = component.measured[0]
    weight = np.bincount(component.F.T.ravel(), np.tile(double_area, 3), minlength=len(V))
    weight = weight / weight.sum()
    middle = weight @ V
    offset = V - middle
    values, axes = np.linalg.eigh((offset * weight[:, None]).T @ offset)
    near = constants.MIRROR_TOL * float(np.sqrt(double_area.sum() / 2))
    tree = scipy.spatial.cKDTree(V)
    for axis in range(3):
        gaps = np.abs(np.delete(values, axis) - values[axis])
        if gaps.min() > constants.MIRROR_TOL * values[2]:
            normal = axes[:, axis]
            image = V - 2 * np.outer(offset @ normal, normal)
            distance, index = tree.query(image, distance_upper_bound=near)
            if np.isfinite(distance).all() and len(np.unique(index)) == len(V):
                return np.asarray(index, dtype=np.int64)
    return None


@dataclass(frozen=True, eq=False)
class Mirror:
    """Nodes and edges in the mirror.

    Attributes
    ----------
    node : (n,) int64
        The mirror image of each node.
    edge : (#E,) int64
        The mirror image of each edge, -1 where it is no edge.
    """

    node: IntArray
    edge: IntArray

    def pair(self, start: int, end: int) -> tuple[int, int]:
        """A tip and its image, if one of two tips is off the plane; else the two."""
        pairs = [(tip, int(self.node[tip])) for tip in (start, end) if self.node[tip] != tip]
        return pairs[0] if pairs else (start, end)

    def image(self, seam: IntArray) -> IntArray:
        """The mirror image of a seam, as far as it is made of edges."""
        edge = self.edge[seam]
        return edge[edge >= 0]

    def with_both(self, graph: SurfaceGraph, seam: IntArray, leaf: int, way: IntArray) -> IntArray:
        """The seam with a way to a leaf, and one to its image; in the plane, if the leaf is there."""
        plane = self.node == np.arange(graph.n)
        if plane[leaf]:
            sources = np.flatnonzero(plane & np.isin(np.arange(graph.n), graph.boundary_nodes(seam)))
            if len(sources):
                distance, before, _ = graph.shortest_paths(sources, np.flatnonzero(~plane))
                if distance[leaf] < constants.MAX_MIRROR_DETOUR * graph.length_of(way):
                    way = graph.path_edges(before, [leaf])
            return np.concatenate((seam, way))
        longer, image = np.concatenate((seam, way)), self.edge[way]
        known = graph.boundary_nodes(longer)
        new = np.setdiff1d(image, longer)
        if (image >= 0).all() and len(np.setdiff1d(graph.ends[new], known)) == len(new):  # no cycle is closed
            return np.concatenate((longer, new))
        _, before, _ = graph.shortest_paths(known)
        return np.concatenate((longer, graph.path_edges(before, [int(self.node[leaf])])))


def mirrored(component: Submesh, closed: ClosedSurface) -> tuple[ClosedSurface, Mirror] | None:
    """A surface with the same lengths on both sides of its mirror plane, and this mirror.

    None if there is no such plane, or the mesh is not the same on its two sides. Edges in the plane are
    shorter: seams like to run in it.
    """
    graph = closed.graph
    codes, edges = graph.neighbours
    vertex = mirrored_vertices(component) if len(codes) else None
    if vertex is None:
        return None
    node = np.full(len(component.V), -1)
    node[closed.edges.ravel()] = graph.ends.ravel()
    known = (node >= 0) & (node[vertex] >= 0)
    image = np.full(graph.n, -1)
    image[node[known]] = node[vertex[known]]
    if (image < 0).any() or (image[image] != np.arange(graph.n)).any():
        return None
    ends = image[graph.ends]
    code = np.minimum(ends[:, 0], ends[:, 1]) * graph.n + np.maximum(ends[:, 0], ends[:, 1])
    place = np.minimum(np.searchsorted(codes, code), len(codes) - 1)
    found = codes[place] == code
    if np.count_nonzero(found) < constants.MIN_MIRRORED_EDGES * len(found):
        return None
    other = np.where(found, graph.length[edges[place]], graph.length)
    in_plane = (ends == graph.ends).all(axis=1)
    length = (graph.length + other) / 2 * np.where(in_plane, constants.MIRROR_LENGTH_FACTOR, 1.0)
    return closed.with_lengths(length), Mirror(image, np.where(found, edges[place], -1))
