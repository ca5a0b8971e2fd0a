"""Flatten a piece of a surface on its own.

If the piece is a single triangle that is too thin to be mapped, the triangle is made slightly higher first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from ..._core import side_products
from ..._runtime import advance
from ..._types import FloatArray
from ...errors import MeshError, first_few, format_count
from ...flattening import Flattening, Hole, Method, Outcome
from ...surface import (
    NEXT,
    PREV,
    Submesh,
    build_planar_mesh,
    complex_positions,
    normalize_placement,
    real_coordinates,
)

MIN_LONE_HEIGHT = 1e-6  # minimum ratio of height to longest side of a single triangle that is mapped
LONE_ROUNDING = 16 * np.finfo(float).eps  # minimum height of a single triangle / its largest coordinate


def open_slivers(pieces: Sequence[Submesh]) -> list[Submesh]:
    """Make thin triangles that are pieces of their own slightly higher, and return all pieces.

    The apex of such a triangle moves away from the longest side. No other triangle changes.
    """
    made = list(pieces)
    alone = [i for i, piece in enumerate(pieces) if len(piece.F) == 1]
    if not alone:
        return made
    corners = np.stack([pieces[i].V[pieces[i].F[0]] for i in alone])
    corner = np.ascontiguousarray(np.arange(3 * len(alone)).reshape(-1, 3).T)
    double, dot, _ = side_products(corners.reshape(3 * len(alone), -1), corner)
    longest = np.sqrt((dot[NEXT] + dot[PREV]).max(axis=0))
    rounding = LONE_ROUNDING * np.abs(corners).max(axis=(1, 2))
    height = np.maximum(MIN_LONE_HEIGHT * longest, rounding)
    for j in np.flatnonzero(double < height * longest).tolist():
        piece, apex = pieces[alone[j]], int(dot[:, j].argmin())  # the apex is opposite to the longest side
        V = piece.V.copy()
        V[piece.F[0, apex]] = _raise_apex(np.roll(corners[j], -apex, axis=0), float(height[j]))
        made[alone[j]] = replace(piece, V=V)
    return made


def _raise_apex(corners: FloatArray, height: float) -> FloatArray:
    """Return the first corner of a triangle after moving it to the given height above the opposite side."""
    apex, start, end = corners
    side = (end - start) / np.linalg.norm(end - start)
    along = (apex - start) @ side
    away = _remove_component(apex - start, side)
    if not away @ away > 0:
        away = _remove_component(np.eye(len(side))[np.abs(side).argmin()], side)
    return np.asarray(start + along * side + height / np.linalg.norm(away) * away)


def _remove_component(vector: FloatArray, side: FloatArray) -> FloatArray:
    """Return the component of a vector that is orthogonal to a unit vector."""
    for _ in range(2):  # the second pass removes the rounding error of the first
        vector = vector - (vector @ side) * side
    return vector


def flatten_piece(piece: Submesh, method: Method) -> Flattening:
    """Flatten a piece. Vertices and faces of the result are numbered within the piece."""
    start, topology = perf_counter(), piece.topology
    if topology.genus or not topology.loops:
        what = f"has {format_count(topology.genus, 'handle')}" if topology.loops else "is closed"
        which = f"the chart of faces {first_few(piece.faces)} {what}"
        raise MeshError(
            f"{which}: give more seams, or charts=ChartOptions(extend=True), which finds the remaining ones"
        )
    n = len(piece.V)
    mesh = replace(build_planar_mesh(piece), vertices=np.arange(n), n_given=n)
    checked = perf_counter() - start
    advance("check", 0.05)
    made = method.run(mesh, None)
    return replace(made, seconds={"check": checked, **made.seconds, "total": perf_counter() - start})


def restrict_uv(uv: FloatArray, piece: Submesh, part: Submesh) -> FloatArray:
    """Return the coordinates of a piece's map at the vertices of one of its parts."""
    of = np.empty(len(part.V), dtype=np.int64)
    of[part.F.ravel()] = piece.F[np.searchsorted(piece.faces, part.faces)].ravel()
    return np.asarray(uv[of])


def scale_to_surface(uv: FloatArray, piece: Submesh) -> FloatArray:
    """Scale the map of a piece to the piece's area, centre it, and rotate it to its standard orientation."""
    z = normalize_placement(
        piece.topology, complex_positions(uv), float(piece.areas_and_products[0].sum()) / 2
    )
    return real_coordinates(z)


def restrict_flattening(result: Flattening, piece: Submesh, part: Submesh, uv: FloatArray) -> Flattening:
    """Return the `Flattening` of a part, whose map `uv` is the piece's map up to scale.

    The outcome is flipped only if triangles of the part are flipped. The caller reports overlaps in the part.
    """
    rows = np.searchsorted(piece.faces, part.faces)
    place = np.full(len(piece.F), -1)
    place[rows] = np.arange(len(rows))
    report = result.report
    flipped, repaired = (np.sort(kept[kept >= 0]) for kept in (place[result.flipped], place[report.repaired]))
    made = replace(
        result,
        uv=uv,
        F=part.F,
        angles=result.angles[rows],
        flipped=flipped,
        holes=_find_holes_of_part(result, piece, part),
        report=replace(report, repaired=repaired),
    )
    if made.outcome not in (Outcome.FLIPPED, Outcome.OVERLAPPING) or len(flipped):
        return made
    return replace(made, outcome=Outcome.VALID, message="no triangle of this part of the map is flipped")


def _find_holes_of_part(result: Flattening, piece: Submesh, part: Submesh) -> tuple[Hole, ...]:
    """Return the holes of a piece's map that a part contains uncut, with their vertices in the part."""
    vertex = np.full(len(piece.V), -1)
    vertex[piece.F[np.searchsorted(piece.faces, part.faces)]] = part.F
    size = {v: len(loop) for loop in part.topology.loops for v in loop}
    moved = [replace(hole, vertex=int(vertex[hole.vertex])) for hole in result.holes]
    return tuple(hole for hole in moved if size.get(hole.vertex) == hole.size)
