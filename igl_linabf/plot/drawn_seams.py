"""Draw seams by clicks, along shortest edge paths from vertex to vertex."""

from dataclasses import dataclass, field
from functools import cached_property

import igl
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from .._types import FloatArray, IntArray
from .map_cache import Pairs


@dataclass
class DrawnSeams:
    """The edge paths that a user has drawn on a surface, and the vertex where the current seam continues.

    Attributes
    ----------
    V, F : (#V, 3) float64 and (#F, 3) int64
    paths : list of (#p,) int64
        The vertices of each path.
    end : int or None
        The vertex where the next click continues the seam; None if the click starts a new seam.
    active : bool
        Whether clicks draw seams.
    """

    V: FloatArray
    F: IntArray
    paths: list[IntArray] = field(default_factory=list)
    end: int | None = None
    active: bool = False

    @cached_property
    def _graph(self) -> csr_array:
        """The graph of edge lengths, built for the first drawn seam."""
        ends = igl.edges(self.F)
        lengths = np.linalg.norm(self.V[ends[:, 0]] - self.V[ends[:, 1]], axis=1)
        n = len(self.V)
        return csr_array((lengths, (ends[:, 0], ends[:, 1])), shape=(n, n))

    @property
    def edges(self) -> Pairs:
        """All edges of the drawn paths, each edge once."""
        pairs = [np.column_stack((path[:-1], path[1:])) for path in self.paths]
        if not pairs:
            return ()
        every = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
        return tuple((int(a), int(b)) for a, b in every)

    def add_vertex(self, vertex: int) -> None:
        """Start a seam at a vertex, or extend the current seam to it.

        If the vertex is the last vertex of the current seam, the seam ends there.
        """
        if self.end is None:
            self.end = vertex
        elif vertex == self.end:
            self.end = None
        else:
            _, before = dijkstra(self._graph, directed=False, indices=self.end, return_predecessors=True)
            path = [vertex]
            while path[-1] != self.end:
                if before[path[-1]] < 0:  # the vertices are in different components
                    break
                path.append(int(before[path[-1]]))
            else:
                self.paths.append(np.array(path[::-1], dtype=np.int64))
            self.end = vertex

    def remove_last_path(self) -> None:
        """Remove the last path."""
        if self.paths:
            self.end = int(self.paths.pop()[0])
        else:
            self.end = None
