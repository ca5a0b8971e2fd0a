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
from ..features import TIP_CURVATURE
from . import constants
from .panels import Panels, depths


@dataclass(frozen=True, eq=False)
class RoundedPanels(Panels):
    """The panels of a surface with rounded creases."""

    same: ClassVar[float] = constants.SAME_ROUNDED_MOTION
    opens_handles: ClassVar[bool] = True
    dearest: ClassVar[float] = constants.MAX_ROUNDED_COST

    @cached_property
    def _plane(self) -> IntArray:
        """The plane of each face."""
        creased = self.creased
        return connected_labels(creased.faces[creased.in_one_plane], len(creased.surface.F))

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
        least = np.maximum(constants.MIN_PLANE_SHARE * whole, constants.PLANE_OVER_NEIGHBOURS * beside)
        return np.asarray((area >= least)[plane])

    @cached_property
    def fold(self) -> BoolArray:
        """Whether edges part panels: sharp creases, and those halfway between two large planes.

        A face goes with the large plane to which the surface turns least on a way there.
        """
        creased, smooth = self.creased, ~self.creased.sharp
        m, faces = len(creased.surface.F), self.creased.faces
        turn = constants.TURN_OF_EXTENT * creased.length / creased.edge_extent
        way = (creased.crease_angle + turn)[smooth]
        indptr, indices, edge = shortest_pairs(faces[smooth], way, m)
        everywhere = np.ones(m, dtype=bool)
        _, _, source = nearest_sources(
            indptr, indices, way[edge], np.flatnonzero(self._large), everywhere, constants.MAX_FILLET_TURN
        )
        panel = np.where(source >= 0, self._plane[source], -1)
        return np.asarray(creased.sharp | np.not_equal(*panel[faces].T))

    @cached_property
    def opened(self) -> BoolArray:
        return np.asarray(self.creased.curvature > TIP_CURVATURE)

    def fits(self, rows: IntArray | BoolArray) -> FloatArray:
        extent, length = self.creased.edge_extent[rows], self.creased.length[rows]
        play = np.minimum(constants.ROUNDED_PLAY * extent, constants.ROUNDED_PLAY_OF_EDGE * length)
        return np.maximum(super().fits(rows), play)

    def depths(self, z: ComplexArray) -> FloatArray:
        shallow = np.where(self._large, constants.MAX_DEPTH_OF_HEIGHT, constants.ROUNDED_DEPTH_OF_HEIGHT)
        return depths(z, self.creased.extent[self.creased.label], constants.ROUNDED_PLAY, shallow)

    def made(self, trade: float) -> BoolArray:
        """Which components are: they have creases, and large planes make up a good part of the area.

        None if seams are to be hidden: around all planes they show.
        """
        creased = self.creased
        made = creased.may_fall_apart & (creased.hidden is None)
        if made.any():
            large = np.where(self._large, creased.surface.measured[0], 0.0)
            least = constants.PLANAR_SHARE_OF_ROUNDED * creased.double_area
            made &= sum_by(creased.label, large, len(made)) >= least
        if made.any():
            made &= np.bincount(creased.label[creased.faces[self.fold, 0]], minlength=len(made)) > 0
        return made
