"""Panels: what lies between sharp creases, each laid flat for itself.

Where all that is curved is on sharp creases, panels are planes, cylinders and cones. `unfolding` puts them
together edge to edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..._core import DEPTH
from ..._types import BoolArray, ComplexArray, FloatArray
from ...surface import NEXT, PREV
from ..features import APEX_CURVATURE, SINGLE_PRECISION, CreasedSurface
from .constants import (
    CHEAP_NET_AT_CREASES,
    FACETED_SHARE,
    FILLET_GAP_OF_LENGTH,
    FOLD,
    PANEL_GAP,
    PANEL_REACH,
    PLANE_BEND,
    SAME_MOTION,
    SHARP_CREASE_PRICE,
    SLIVER_BEND,
)


@dataclass(frozen=True, eq=False)
class Panels:
    """The panels of a surface with sharp creases.

    Attributes
    ----------
    creased : CreasedSurface
    gap : float
        Share of the extent by which two sides of a fold may miss each other, and faces may reach into each
        other.
    same_motion : float
        Share of the extent, and radians, up to which two motions are one.
    opens_handles : bool
        Whether panels may have handles, which seams then open.
    dearest : float
        Price of a component's seams, from which on they are sought in another way.
    """

    creased: CreasedSurface
    gap: ClassVar[float] = PANEL_GAP
    same_motion: ClassVar[float] = SAME_MOTION
    opens_handles: ClassVar[bool] = False
    dearest: ClassVar[float] = np.inf

    @cached_property
    def folds(self) -> BoolArray:
        """Whether edges part panels."""
        return np.asarray(self.creased.crease_angle >= FOLD)

    @cached_property
    def terminals(self) -> BoolArray:
        """Which vertices seams have to come to."""
        return np.asarray(self.creased.curvature > 0)

    @cached_property
    def reach(self) -> float | FloatArray:
        """Share of its height by which each face may reach into another one at most."""
        return PANEL_REACH

    def gaps(self, edges: BoolArray) -> FloatArray:
        """By how much the two sides of such edges may miss each other when panels are joined there."""
        extent = self.creased.edge_extent[edges]
        most = FILLET_GAP_OF_LENGTH * self.creased.length[edges]
        return np.maximum(PANEL_GAP * extent, np.minimum(self.gap * extent, most))

    def depths(self, z: ComplexArray) -> FloatArray:
        """By how much the faces, laid flat, may reach into each other; negative for slivers."""
        extent = self.creased.extent[self.creased.label]
        side = np.roll(z, -1, axis=1) - z
        height = -(side[:, 0].conj() * side[:, 2]).imag / np.maximum(np.abs(side.T).max(axis=0), 1e-300)
        depth = np.maximum(DEPTH * height, np.minimum(self.reach * height, self.gap * extent))
        return np.where(height > np.finfo(float).eps * extent, depth, -1.0)

    def components(self, trade: float) -> BoolArray:
        """Which components are made of panels: what is curved is on sharp creases, or a tip.

        Seams there have to cost little. Where most of the area lies flat, they may cost more.
        """
        creased, bent = self.creased, self.creased.curvature
        smooth = (bent > 0) & ~creased.on_sharp
        made = np.asarray(creased.per_component(smooth & (bent <= APEX_CURVATURE)) == 0)
        if made.any():
            made &= creased.per_component(smooth & ~creased.is_apex) == 0
        if not made.any():
            return made
        # no tree through what is curved costs less: each node has an edge, and an edge has two nodes
        least = np.full(len(bent), np.inf)
        price = creased.visible_length * np.where(creased.sharp, SHARP_CREASE_PRICE, 1.0)
        np.minimum.at(least, creased.ends.ravel(), np.repeat(price, 2))
        cheap = self.price(creased.per_component(bent > 0, least) / 2, trade) < CHEAP_NET_AT_CREASES
        if not cheap[made].all():
            cheap |= creased.flat_share >= FACETED_SHARE
        made &= cheap & creased.may_fall_apart
        return made & ((creased.n_loops > 0) | (creased.per_component(creased.on_sharp) > 0))

    def price(self, length: FloatArray, trade: float) -> FloatArray:
        """What seams on sharp creases cost, of which this length counts in each component."""
        length = length / np.sqrt(self.creased.double_area / 2)
        return np.asarray(np.maximum(0.0, length - SHARP_CREASE_PRICE * trade) / trade)


def in_one_plane(creased: CreasedSurface) -> BoolArray:
    """The edges whose two faces lie in one plane, as far as coordinates tell."""
    double_area, dot = creased.surface.measured
    longest = np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
    height = np.minimum(*(double_area / longest)[creased.faces.T])
    noise = SINGLE_PRECISION * creased.edge_extent / height
    return np.asarray(creased.crease_angle <= np.minimum(np.maximum(PLANE_BEND, 4 * noise), SLIVER_BEND))
