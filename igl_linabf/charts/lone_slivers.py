"""Triangles that are alone in their charts, and too thin for a map in double precision: opened by a hair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .._core import products
from .._types import FloatArray
from ..surface import NEXT, PREV, Submesh

THIN = 1e-6  # height over the longest side, which thinner triangles get
ROUNDING = 16 * np.finfo(float).eps  # and over their distance from the origin, if that is more


def with_width(pieces: Sequence[Submesh]) -> list[Submesh]:
    """The pieces; of those that are one thin triangle, the vertex opposite to the longest side is moved away.

    No neighbour sees it, and a triangle so thin has no area to speak of.
    """
    made = list(pieces)
    alone = [i for i, piece in enumerate(pieces) if len(piece.F) == 1]
    if not alone:
        return made
    corners = np.stack([pieces[i].V[pieces[i].F[0]] for i in alone])
    corner = np.ascontiguousarray(np.arange(3 * len(alone)).reshape(-1, 3).T)
    double, dot, _ = products(corners.reshape(3 * len(alone), -1), corner)
    longest = np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
    height = np.maximum(THIN * longest, ROUNDING * np.abs(corners).max(axis=(1, 2)))
    for j in np.flatnonzero(double < height * longest).tolist():
        piece, apex = pieces[alone[j]], int(dot[:, j].argmin())  # opposite to the longest side
        V = piece.V.copy()
        V[piece.F[0, apex]] = _raised(np.roll(corners[j], -apex, axis=0), float(height[j]))
        made[alone[j]] = replace(piece, V=V)
    return made


def _raised(corners: FloatArray, height: float) -> FloatArray:
    """The first corner of a triangle, at this height over the side between the others."""
    apex, start, end = corners
    side = (end - start) / np.linalg.norm(end - start)
    along = (apex - start) @ side
    away = _across(apex - start, side)
    if not away @ away > 0:
        away = _across(np.eye(len(side))[np.abs(side).argmin()], side)
    return np.asarray(start + along * side + height / np.linalg.norm(away) * away)


def _across(vector: FloatArray, side: FloatArray) -> FloatArray:
    """The part of a vector at right angles to a side of length one."""
    for _ in range(2):  # the first time to some digits of a long vector only
        vector = vector - (vector @ side) * side
    return vector
