"""Mirror planes: a body that is symmetric is cut alike on both sides."""

from dataclasses import dataclass

import numpy as np
import scipy

from ..._types import IntArray
from ...surface import Submesh
from ..cut_graphs import ClosedSurface, SurfaceGraph
from .constants import MIRROR_DETOUR, MIRROR_DISTANCE, MIRROR_EDGES, MIRROR_PLANE_PRICE


def _mirror_images(component: Submesh) -> IntArray | None:
    """The vertex in the place of each one's mirror image, in a plane through the principal axes; or None."""
    V, double_area = component.V, component.measured[0]
    weight = np.bincount(component.F.T.ravel(), np.tile(double_area, 3), minlength=len(V))
    weight = weight / weight.sum()
    offset = V - weight @ V
    moments, axes = np.linalg.eigh((offset * weight[:, None]).T @ offset)
    tree, near = scipy.spatial.cKDTree(V), MIRROR_DISTANCE * float(np.sqrt(double_area.sum() / 2))
    for axis, normal in enumerate(axes.T):
        if np.abs(np.delete(moments, axis) - moments[axis]).min() > MIRROR_DISTANCE * moments[2]:
            image = V - 2 * np.outer(offset @ normal, normal)
            distance, vertex = tree.query(image, distance_upper_bound=near)
            if np.isfinite(distance).all() and len(np.unique(vertex)) == len(V):
                return np.asarray(vertex, dtype=np.int64)
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
                if distance[leaf] < MIRROR_DETOUR * graph.length_of(way):
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
    graph, (code, shortest) = closed.graph, closed.graph.neighbours
    vertex = _mirror_images(component) if len(code) else None
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
    wanted = np.minimum(ends[:, 0], ends[:, 1]) * graph.n + np.maximum(ends[:, 0], ends[:, 1])
    place = np.minimum(np.searchsorted(code, wanted), len(code) - 1)
    found = code[place] == wanted
    if np.count_nonzero(found) < MIRROR_EDGES * len(found):
        return None
    other = np.where(found, graph.length[shortest[place]], graph.length)
    on_plane = (ends == graph.ends).all(axis=1)
    length = (graph.length + other) / 2 * np.where(on_plane, MIRROR_PLANE_PRICE, 1.0)
    return closed.with_lengths(length), Mirror(image, np.where(found, shortest[place], -1))
