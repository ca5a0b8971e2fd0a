"""A piece of a surface, flattened alone.

A piece of one triangle that is too thin for a map is opened a little before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from ..._core import products
from ..._runtime import advance
from ..._types import FloatArray
from ...errors import MeshError, some
from ...flattening import Flattening, Method, Outcome
from ...surface import NEXT, PREV, Submesh, centred, complex_positions, coordinates, planar_mesh_of
from . import constants


def open_slivers(pieces: Sequence[Submesh]) -> list[Submesh]:
    """The pieces; in those of one thin triangle the vertex opposite to the longest side is moved away.

    Such a piece has no neighbour that would move with it, and hardly any area.
    """
    made = list(pieces)
    alone = [i for i, piece in enumerate(pieces) if len(piece.F) == 1]
    if not alone:
        return made
    corners = np.stack([pieces[i].V[pieces[i].F[0]] for i in alone])
    corner = np.ascontiguousarray(np.arange(3 * len(alone)).reshape(-1, 3).T)
    double, dot, _ = products(corners.reshape(3 * len(alone), -1), corner)
    longest = np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
    rounding = constants.LONE_ROUNDING * np.abs(corners).max(axis=(1, 2))
    height = np.maximum(constants.MIN_LONE_HEIGHT * longest, rounding)
    for j in np.flatnonzero(double < height * longest).tolist():
        piece, apex = pieces[alone[j]], int(dot[:, j].argmin())  # opposite to the longest side
        V = piece.V.copy()
        V[piece.F[0, apex]] = _raised(np.roll(corners[j], -apex, axis=0), float(height[j]))
        made[alone[j]] = replace(piece, V=V)
    return made


def _raised(corners: FloatArray, height: float) -> FloatArray:
    """The first corner of a triangle, moved to this height over the side between the others."""
    apex, start, end = corners
    side = (end - start) / np.linalg.norm(end - start)
    along = (apex - start) @ side
    away = _across(apex - start, side)
    if not away @ away > 0:
        away = _across(np.eye(len(side))[np.abs(side).argmin()], side)
    return np.asarray(start + along * side + height / np.linalg.norm(away) * away)


def _across(vector: FloatArray, side: FloatArray) -> FloatArray:
    """The part of a vector at right angles to a side of length one."""
    for _ in range(2):  # of a long vector the first round leaves rounding
        vector = vector - (vector @ side) * side
    return vector


def flatten_piece(piece: Submesh, method: Method) -> Flattening:
    """Flatten a piece; faces and vertices of the result are numbered within the piece."""
    start, topology = perf_counter(), piece.topology
    if topology.genus or not topology.loops:
        what = f"has {topology.genus} handle{'s' * (topology.genus > 1)}" if topology.loops else "is closed"
        which = f"the chart of faces {some(piece.faces)} {what}"
        raise MeshError(
            f"{which}: give more seams, or Seams(edges, complete=True), and unwrap finds the others"
        )
    n = len(piece.V)
    mesh = replace(planar_mesh_of(piece), vertices=np.arange(n), n_given=n)
    checked = perf_counter() - start
    advance("check", 0.05)
    made = method.run(mesh, None)
    return replace(made, seconds={"check": checked, **made.seconds, "total": perf_counter() - start})


def uv_of_part(uv: FloatArray, piece: Submesh, part: Submesh) -> FloatArray:
    """The coordinates of a piece's map at the vertices of a part of it."""
    of = np.empty(len(part.V), dtype=np.int64)
    of[part.F.ravel()] = piece.F[np.searchsorted(piece.faces, part.faces)].ravel()
    return np.asarray(uv[of])


def scaled_to_surface(uv: FloatArray, piece: Submesh) -> FloatArray:
    """The map of a piece, with its area on the surface, turned and placed as all maps are."""
    z = centred(piece.topology, complex_positions(uv), float(piece.measured[0].sum()) / 2)
    return coordinates(z)


def flattening_of_part(result: Flattening, piece: Submesh, part: Submesh, uv: FloatArray) -> Flattening:
    """The `Flattening` of a part whose map `uv` is that of its piece, at some scale.

    Its outcome is flipped only if triangles of the part are.
    """
    rows = np.searchsorted(piece.faces, part.faces)
    place = np.full(len(piece.F), -1)
    place[rows] = np.arange(len(rows))
    flipped, repaired = (np.sort(kept[kept >= 0]) for kept in (place[result.flipped], place[result.repaired]))
    made = replace(
        result,
        uv=uv,
        F=part.F,
        angles=result.angles[rows],
        flipped=flipped,
        repaired=repaired,
        holes=result.holes if len(part.topology.loops) > 1 else (),
    )
    if made.outcome is not Outcome.FLIPPED or len(flipped):
        return made
    return replace(made, outcome=Outcome.VALID, message="no triangle of this part of the map is flipped")
