"""Find the seams of many small components at once, adding one branch to each component at a time.

The components are disjoint. Therefore one Laplace system and one shortest-path search serve all of them.
"""

import numpy as np

from ..._types import BoolArray, FloatArray, IntArray
from ...surface import Ragged, Submesh, connected_labels, sum_by_index
from ..cut_graphs import ClosedSurface, join_terminals, solve_log_scale
from ..features import CreasedSurface
from . import constants
from .growth import DISK_GAIN


class SmallBodies:
    """Small components without handles, which are processed as one closed surface.

    Parameters
    ----------
    surface : Submesh
        The surface that consists of all small components.
    hidden : (#F,) float64, optional
        The hiding weights of the input faces.
    """

    def __init__(self, surface: Submesh, hidden: FloatArray | None = None) -> None:
        self.vertices = surface.vertices
        self.closed = ClosedSurface.from_creased_surface(CreasedSurface(surface, hidden))
        closed, of = self.closed, connected_labels(self.closed.graph.ends, self.closed.graph.n)
        self._n = int(of.max()) + 1
        component = np.empty(self._n, dtype=np.int64)
        component[of[closed.node[surface.F[:, 0]]]] = surface.component_of_face
        self._of = component[of]  # the body of each node, numbered like the components of the surface
        self._area = sum_by_index(self._of, closed.area, self._n)
        self._by_body = np.argsort(self._of, kind="stable")
        self._nodes = Ragged(np.searchsorted(self._of[self._by_body], np.arange(self._n + 1)))

    def find_seams(self, trade: float, keep_holes: bool) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the seam edges of all bodies, as pairs of input vertices, and the cost of each body.

        A disk is cut only if the net gain is at least `DISK_GAIN`.

        Returns
        -------
        edges : (#E, 2) int64
        body : (#E,) int64
            The body of each edge.
        cost : (#B,) float64
            The expected cost of each body.
        """
        seam = np.zeros(0, dtype=np.int64)
        if not keep_holes:
            seam = join_terminals(self.closed.graph, seam)
        needed = seam = np.concatenate((seam, self._find_slits()))
        cost = self._estimate_cost(needed, trade)
        if trade > 0:
            seam = self._grow_seams(needed, trade)
            lower = self._estimate_cost(seam, trade)
            idle = np.bincount(self._find_bodies(needed), minlength=self._n) == 0
            stays = idle & (cost - lower < DISK_GAIN / trade)
            seam, cost = self._choose_per_body(needed, seam, stays), np.where(stays, cost, lower)
        return self.vertices[self.closed.edges[seam]], self._find_bodies(seam), cost

    def _find_slits(self) -> IntArray:
        """Return a path for each sphere, along which it is cut open, between the points that shrink most."""
        closed, rims = self.closed, np.arange(self.closed.graph.n_holes)
        bare = np.bincount(self._of[rims], minlength=self._n) == 0
        if not bare.any():
            return np.zeros(0, dtype=np.int64)
        extra = closed.curvature - 4 * np.pi * closed.area / self._area[self._of]
        first = np.unique(self._of, return_index=True)[1][bare]
        start = self._find_least_nodes(solve_log_scale(closed, np.union1d(first, rims), extra))[bare]
        end = self._find_least_nodes(solve_log_scale(closed, np.union1d(start, rims), closed.curvature))[bare]
        distance, before, _ = closed.graph.find_shortest_paths(start)
        path = closed.graph.find_edges_on_paths(before, end)
        # a cut along a single edge does not open a sphere
        short = bare & (np.bincount(self._find_bodies(path), minlength=self._n) < 2)
        distance[np.concatenate((start, end))] = np.inf
        more = closed.graph.find_edges_on_paths(before, self._find_least_nodes(distance)[short])
        return np.concatenate((path, np.setdiff1d(more, path)))

    def _grow_seams(self, seam: IntArray, trade: float) -> IntArray:
        """Add branches one by one to the seam of each body, and return each body's seam of least cost."""
        closed = self.closed
        when = np.zeros(len(seam), dtype=np.int64)  # round of the search that added each edge
        best, least = np.zeros(self._n, dtype=np.int64), np.full(self._n, np.inf)
        in_vain, growing = np.zeros(self._n, dtype=np.int64), np.ones(self._n, dtype=bool)
        for leaf in range(constants.MAX_BRANCHES):
            # The stretch is at least 1. A body whose seam alone costs too much gets no more branches.
            growing &= 1 + self._measure_length(seam) / trade < least
            if not growing.any():
                break
            open_nodes = self._find_fixed_nodes(seam)
            u = solve_log_scale(closed, open_nodes, closed.curvature)
            cost = self._estimate_stretch(u) + self._measure_length(seam) / trade
            better = growing & (cost < least)
            in_vain = np.where(better, 0, in_vain + 1)
            best[better], least[better] = leaf, cost[better]
            tip = self._find_least_nodes(-np.abs(u))
            growing &= (in_vain < constants.MAX_IDLE_BRANCHES) & (u[tip] != 0)
            if not growing.any():
                break
            _, before, _ = closed.graph.find_shortest_paths(open_nodes[growing[self._of[open_nodes]]])
            path = closed.graph.find_edges_on_paths(before, tip[growing])
            seam = np.concatenate((seam, path))
            when = np.concatenate((when, np.full(len(path), leaf + 1)))
        return seam[when <= best[self._find_bodies(seam)]]

    def _choose_per_body(self, one: IntArray, other: IntArray, takes_one: BoolArray) -> IntArray:
        """Return seam `one` for the bodies in the mask `takes_one`, and seam `other` for all other bodies."""
        return np.concatenate(
            (one[takes_one[self._find_bodies(one)]], other[~takes_one[self._find_bodies(other)]])
        )

    def _estimate_cost(self, seam: IntArray, trade: float) -> FloatArray:
        """Return the expected cost of each body: L2 stretch minus 1, plus the price of its seam."""
        if not trade:
            return self._measure_length(seam)
        u = solve_log_scale(self.closed, self._find_fixed_nodes(seam), self.closed.curvature)
        return np.asarray(self._estimate_stretch(u) - 1 + self._measure_length(seam) / trade)

    def _estimate_stretch(self, u: FloatArray) -> FloatArray:
        """Return the expected L2 stretch of each body."""
        shrunk, grown = (sum_by_index(self._of, self.closed.area * np.exp(k * u), self._n) for k in (-2, 2))
        return np.asarray(np.sqrt(shrunk * grown) / self._area)

    def _measure_length(self, seam: IntArray) -> FloatArray:
        """Return the length of each body's seam, in units of the square root of the body's area."""
        length = np.bincount(self._find_bodies(seam), self.closed.graph.length[seam], self._n)
        return np.asarray(length / np.sqrt(self._area))

    def _find_fixed_nodes(self, seam: IntArray) -> IntArray:
        return np.union1d(self.closed.graph.ends[seam], np.arange(self.closed.graph.n_holes))

    def _find_bodies(self, edges: IntArray) -> IntArray:
        """Return the body of each of the given edges."""
        return np.asarray(self._of[self.closed.graph.ends[edges, 0]])

    def _find_least_nodes(self, values: FloatArray) -> IntArray:
        """Return the node with the least value in each body; the first such node if several are equal."""
        values = values[self._by_body]
        least = np.flatnonzero(values == self._nodes.repeat(self._nodes.min(values)))
        first = np.searchsorted(least, self._nodes.start[:-1])
        return np.asarray(self._by_body[least[first]], dtype=np.int64)
