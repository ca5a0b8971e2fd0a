"""Bodies with rounded creases, as machine parts have: planes, cylinders, and fillets between them.

A fillet ends in corners that are curved a little at each of many vertices, so that no net runs through all
that is curved. But the planes on its two sides are panels: each takes half of the fillet, and the middle of
it is a crease between them. Panels are put together along these as along sharp creases, with some play. What
is curved comes to the rims of charts, which are flattened then.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..._core import nearest_sources, shortest_pairs
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import connected_labels, sum_by
from ..features import TIP
from .panels import FITS, SHALLOW, Panels, depths, in_one_plane

PLANE = 1e-3  # of the area, from which a plane is a panel
LARGER = 2.0  # times any plane beside it that is not across a sharp crease: strips of cylinders are not
LEVEL = 1e-3  # radians that a way of the body's extent counts
MOST_TURN = np.deg2rad(60.0)  # from the plane of a panel to the faces that go with it
PLANAR = 0.3  # share of the area in such planes, from which a body has rounded creases
PLAY = 2e-3  # of the extent, by which two sides of a crease may miss each other
AWRY = 0.1  # of their length, by which they may
DEAREST = 2.0  # price of its seams, as stretch, from which on a body is cut in another way
DEEP = 0.3  # of their height, by which faces of fillets may reach into each other


@dataclass(frozen=True, eq=False)
class RoundedPanels(Panels):
    """The panels of a surface with rounded creases."""

    same: ClassVar[float] = 1e-2
    opens_handles: ClassVar[bool] = True
    dearest: ClassVar[float] = DEAREST

    @cached_property
    def _plane(self) -> IntArray:
        """The plane of each face."""
        creased = self.creased
        return connected_labels(creased.faces[in_one_plane(creased)], len(creased.surface.F))

    @cached_property
    def _large(self) -> BoolArray:
        """Which faces are in a plane that makes a panel."""
        creased, plane = self.creased, self._plane
        number = int(plane.max()) + 1
        area, whole = sum_by(plane, creased.surface.measured[0], number), np.empty(number)
        whole[plane] = creased.double_area[creased.label]
        pairs = plane[creased.faces[~creased.sharp]]
        pairs, beside = pairs[pairs[:, 0] != pairs[:, 1]], np.zeros(number)
        for one, other in (pairs.T, pairs[:, ::-1].T):
            np.maximum.at(beside, one, area[other])
        return np.asarray(((area >= PLANE * whole) & (area >= LARGER * beside))[plane])

    @cached_property
    def fold(self) -> BoolArray:
        """Whether edges part panels: sharp creases, and those halfway between two large planes.

        A face goes with the large plane to which the surface turns least on a way there.
        """
        creased, smooth = self.creased, ~self.creased.sharp
        m, faces = len(creased.surface.F), self.creased.faces
        way = creased.crease_angle[smooth] + LEVEL * creased.length[smooth] / creased.edge_extent[smooth]
        indptr, indices, edge = shortest_pairs(faces[smooth], way, m)
        everywhere = np.ones(m, dtype=bool)
        _, _, source = nearest_sources(
            indptr, indices, way[edge], np.flatnonzero(self._large), everywhere, MOST_TURN
        )
        panel = np.where(source >= 0, self._plane[source], -1)
        return np.asarray(creased.sharp | np.not_equal(*panel[faces].T))

    @cached_property
    def opened(self) -> BoolArray:
        return np.asarray(self.creased.curvature > TIP)

    def fits(self, rows: IntArray | BoolArray) -> FloatArray:
        extent = self.creased.edge_extent[rows]
        return np.maximum(FITS * extent, np.minimum(PLAY * extent, AWRY * self.creased.length[rows]))

    def depths(self, z: ComplexArray) -> FloatArray:
        extent = self.creased.extent[self.creased.label]
        return depths(z, extent, PLAY, np.where(self._large, SHALLOW, DEEP))

    def made(self, trade: float) -> BoolArray:
        """Which components are: they have creases, and large planes make up a good part of the area.

        None if seams are to be hidden: around all planes they show.
        """
        creased = self.creased
        made = creased.may_fall_apart & (creased.hidden is None)
        if made.any():
            large = np.where(self._large, creased.surface.measured[0], 0.0)
            made &= sum_by(creased.label, large, len(made)) >= PLANAR * creased.double_area
        if made.any():
            made &= np.bincount(creased.label[creased.faces[self.fold, 0]], minlength=len(made)) > 0
        return made
