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
from ..._types import BoolArray, FloatArray, IntArray
from ...surface import connected_labels, sum_by
from ..features import APEX_CURVATURE
from .constants import (
    DEAREST_ROUNDED,
    FILLET_GAP,
    FILLET_REACH,
    LARGER_THAN_BESIDE,
    LARGEST_TURN,
    PANEL_REACH,
    PLANAR_SHARE,
    PLANE_AREA,
    PLANE_BEND,
    SAME_FILLET_MOTION,
)
from .panels import Panels, in_one_plane


@dataclass(frozen=True, eq=False)
class RoundedPanels(Panels):
    """The panels of a surface with rounded creases."""

    gap: ClassVar[float] = FILLET_GAP
    same_motion: ClassVar[float] = SAME_FILLET_MOTION
    opens_handles: ClassVar[bool] = True
    dearest: ClassVar[float] = DEAREST_ROUNDED

    @cached_property
    def _planes(self) -> tuple[IntArray, BoolArray]:
        """The plane of each face, and whether it is so large that it makes a panel."""
        creased = self.creased
        plane = connected_labels(creased.faces[in_one_plane(creased)], len(creased.surface.F))
        number = int(plane.max()) + 1
        area, whole = sum_by(plane, creased.surface.measured[0], number), np.empty(number)
        whole[plane] = creased.double_area[creased.label]
        pairs = plane[creased.faces[~creased.sharp]]
        pairs, beside = pairs[pairs[:, 0] != pairs[:, 1]], np.zeros(number)
        for one, other in (pairs.T, pairs[:, ::-1].T):
            np.maximum.at(beside, one, area[other])
        large = (area >= PLANE_AREA * whole) & (area >= LARGER_THAN_BESIDE * beside)
        return plane, np.asarray(large[plane])

    @cached_property
    def folds(self) -> BoolArray:
        """Whether edges part panels: sharp creases, and those halfway between two large planes.

        A face goes with the large plane to which the surface turns least on a way there.
        """
        creased, smooth = self.creased, ~self.creased.sharp
        m, faces, (plane, large) = len(creased.surface.F), self.creased.faces, self._planes
        way = creased.crease_angle[smooth] + PLANE_BEND * creased.length[smooth] / creased.edge_extent[smooth]
        indptr, indices, edge = shortest_pairs(faces[smooth], way, m)
        everywhere = np.ones(m, dtype=bool)
        _, _, source = nearest_sources(
            indptr, indices, way[edge], np.flatnonzero(large), everywhere, LARGEST_TURN
        )
        panel = np.where(source >= 0, plane[source], -1)
        return np.asarray(creased.sharp | np.not_equal(*panel[faces].T))

    @cached_property
    def terminals(self) -> BoolArray:
        return np.asarray(self.creased.curvature > APEX_CURVATURE)

    @cached_property
    def reach(self) -> FloatArray:
        return np.where(self._planes[1], PANEL_REACH, FILLET_REACH)

    def components(self, trade: float) -> BoolArray:
        """Which components are: they have creases, and large planes make up a good part of the area.

        None if seams are to be hidden: around all planes they show.
        """
        creased = self.creased
        made = creased.may_fall_apart & (creased.hidden is None)
        if made.any():
            large = np.where(self._planes[1], creased.surface.measured[0], 0.0)
            made &= sum_by(creased.label, large, len(made)) >= PLANAR_SHARE * creased.double_area
        if made.any():
            made &= np.bincount(creased.label[creased.faces[self.folds, 0]], minlength=len(made)) > 0
        return made
