"""A component of a surface, seen as what cones are placed on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._types import IntArray
from ...angles import ClosedPath
from ...surface import Submesh
from ..cut_graphs import ClosedSurface
from .constants import CONES_ONE_BY_ONE, MAX_GREEN_VALUES
from .seams import handle_seam, paths_across, seam_through


@dataclass(frozen=True, eq=False)
class ConeComponent:
    """A component on which cones are placed."""

    submesh: Submesh

    @cached_property
    def closed(self) -> ClosedSurface:
        """The component with each boundary loop contracted to a node."""
        return ClosedSurface.of(self.submesh)

    @cached_property
    def handles(self) -> IntArray:
        """A cut graph that opens the handles; edges of `closed`."""
        return handle_seam(self.closed)

    @cached_property
    def paths(self) -> tuple[ClosedPath, ...]:
        """Closed paths around the holes and along the handles, as in `paths_across`; cones do not matter."""
        seam = seam_through(self.closed, np.zeros(0, dtype=np.int64), self.handles)
        return paths_across(self.submesh, self.closed.graph, seam)

    @cached_property
    def interior(self) -> IntArray:
        """The interior vertices. Their nodes follow those of the holes, in the same order."""
        return np.flatnonzero(self.submesh.topology.interior)

    @cached_property
    def n_triangles(self) -> IntArray:
        """Triangles around each node, (n,); 0 for those of holes."""
        number = np.bincount(self.submesh.F.ravel(), minlength=len(self.submesh.V))
        return np.append(np.zeros(self.closed.graph.n_holes, dtype=np.int64), number[self.interior])

    @property
    def total_curvature(self) -> float | None:
        """The sum of all cones' curvatures on a closed surface (Gauss-Bonnet); None with a boundary."""
        return None if self.closed.graph.n_holes else 2 * np.pi * self.submesh.topology.characteristic

    @property
    def min_cones(self) -> int:
        """The fewest cones, of 90 degrees or more, with which the surface can be flat."""
        total = self.total_curvature
        return 0 if total is None or total == 0 else 3 if total > 0 else 1

    @property
    def one_by_one(self) -> int:
        """Up to how many cones are found one by one."""
        return max(CONES_ONE_BY_ONE, 2 * abs(self.submesh.topology.characteristic))

    @property
    def max_cones(self) -> int:
        """The most cones that are found where their number is not given."""
        return max(self.one_by_one, MAX_GREEN_VALUES // self.closed.graph.n)

    def vertices_of(self, nodes: IntArray) -> IntArray:
        """The component's vertices of nodes that are no holes."""
        return self.interior[nodes - self.closed.graph.n_holes]
