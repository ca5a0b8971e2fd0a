"""A map whose seams shift a periodic texture by whole periods, so that it goes on across them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .._types import ComplexArray, FloatArray, IntArray
from ..errors import MeshError, some
from ..linalg import Solvers
from ..measures import quality_of
from ..surface import NEXT, PREV, Submesh, complex_positions, coordinates, signed_double_areas
from .atlas import Atlas, Chart
from .given_seams import textured_seams
from .seam_shifts import SeamSides, fans_of, whole_shifts

MOST_HALVINGS = 8  # of a period that is too long
EVEN = 1e-8  # share of its diagonal by which the displacement is drawn to zero
THIN = 1e-15  # share of the largest area below which a triangle of the map counts as so large


def with_period(surface: Submesh, atlas: Atlas, pieces: list[Submesh], period: float) -> Atlas:
    """The atlas with seams that shift by whole periods; `pieces` are the surfaces of its charts.

    Raises
    ------
    MeshError
        Triangles would flip; the message has a period that would do.
    """
    TC, charts = _moved(surface, atlas, pieces, period)
    if flips := _new_flips(charts, atlas.charts):
        advice = "use other cones"
        for _ in range(MOST_HALVINGS):
            period /= 2
            if not _new_flips(_moved(surface, atlas, pieces, period)[1], atlas.charts):
                advice = f"use {period:.3g}, or other cones"
                break
        raise MeshError(f"{flips}, as cones lie too near to each other for this period: {advice}")
    V = np.concatenate([piece.V for piece in pieces])
    whole = Submesh(V, atlas.FTC, surface.faces, atlas.origin, surface.n_given)
    mismatch = textured_seams(surface.topology, TC, atlas.FTC)[1]
    return replace(
        atlas, TC=TC, charts=charts, period=period, seam_mismatch=mismatch, quality=quality_of(whole, TC)
    )


def _moved(
    surface: Submesh, atlas: Atlas, pieces: list[Submesh], period: float
) -> tuple[FloatArray, tuple[Chart, ...]]:
    """The texture coordinates for a period, and the charts with what is then measured of them."""
    cones = np.flatnonzero(np.isin(surface.vertices, atlas.cones))
    TC = periodic(surface, atlas.TC, atlas.FTC, period, cones)
    parts = np.split(TC, np.cumsum([len(piece.V) for piece in pieces])[:-1])
    charts = []
    for chart, piece, uv in zip(atlas.charts, pieces, parts, strict=True):
        measured = quality_of(piece, uv)
        charts.append(replace(chart, quality=measured, overlapping=measured.overlaps))
    return TC, tuple(charts)


def _new_flips(moved: Sequence[Chart], charts: Sequence[Chart]) -> str:
    """In which chart triangles flip that did not before; "" if in none."""
    for i, (now, before) in enumerate(zip(moved, charts, strict=True)):
        if (flips := now.quality.flips - before.quality.flips) > 0:
            return f"{flips} triangles of chart {i} (faces {some(now.faces)}) would flip"
    return ""


def periodic(surface: Submesh, TC: FloatArray, FTC: IntArray, period: float, cones: IntArray) -> FloatArray:
    """Move a map whose seams turn by quarter turns, so that they shift by whole periods.

    The sides of a seam edge are at z and i^k z + t. Each t becomes a vector of the lattice of the period.
    This determines the places of the cones, at which the turns around them leave one point where it is; the
    lattice vectors are those that move the cones little. In between, the displacement is harmonic, with a
    stiffness that falls with the square of the distance to the cones: near these it would change fast.

    Parameters
    ----------
    surface : Submesh
    TC : (#TC, 2) float64
    FTC : (#F, 3) int64
    period : float
        In units of `TC`.
    cones : (#C,) int64
        The surface's own vertices.

    Raises
    ------
    MeshError
        A seam turns by no multiple of 90 degrees.
    """
    z, n = complex_positions(TC), len(surface.V)
    sides = SeamSides.of(surface, z, FTC)
    fans = [fan for fan in fans_of(sides) if fan.copies]
    shift, held, place = whole_shifts(sides, fans, z, period)
    origin = np.empty(len(z), dtype=np.int64)
    origin[FTC] = surface.F
    # a copy of a vertex is at turn * (its first copy) + moved
    first, turn, moved = np.arange(len(z)), np.ones(len(z), dtype=np.complex128), np.zeros(len(z), complex)
    for fan in fans:
        for copy, by, sums in zip(fan.copies, fan.turns, fan.sums, strict=True):
            first[copy], turn[copy] = fan.copies[0], by
            moved[copy] = sum(factor * shift[e] for e, factor in sums)
    L = _stiffness(surface, z, FTC, cones)
    of_vertex = sparse.csr_array((turn, (np.arange(len(z)), origin)), shape=(len(z), n))
    A = (of_vertex.conj().T @ L @ of_vertex).tocsr()
    A = A + sparse.diags_array(EVEN * A.diagonal())  # without cones it may float
    d, free = np.zeros(n, dtype=np.complex128), np.ones(n, dtype=bool)
    d[held], free[held] = place, False
    beyond = turn * z[first] + moved - z  # the displacement of a copy whose first one stays
    rhs = -(of_vertex.conj().T @ (L @ beyond) + A @ d)[free]
    lower = sparse.tril(A[free][:, free]).tocsc()
    d[free] = Solvers().whole(lower).factor(lower).solve(rhs)
    return coordinates(turn * (z[first] + d[origin]) + moved)


def _stiffness(surface: Submesh, z: ComplexArray, FTC: IntArray, cones: IntArray) -> sparse.csr_array:
    """The Laplacian of the map, (#TC, #TC), each triangle weighed by its distance to the cones to the -2."""
    corner = FTC.T
    side = z[corner[PREV]] - z[corner[NEXT]]
    area = np.abs(signed_double_areas(z, corner))
    area = np.maximum(area, THIN * area.max())
    weight = -(side[NEXT].conj() * side[PREV]).real / area  # twice a half of the cotangent
    if len(cones):
        length = np.abs(side)
        ends = np.stack((surface.F.T[NEXT], surface.F.T[PREV])).reshape(2, -1)
        _, once = np.unique(ends.min(axis=0) * len(surface.V) + ends.max(axis=0), return_index=True)
        graph = sparse.csr_array((length.ravel()[once], ends[:, once]), shape=(len(surface.V),) * 2)
        away = csgraph.dijkstra(graph, directed=False, indices=cones, min_only=True)
        away[~np.isfinite(away)] = 1.0  # components without cones
        distance = away[surface.F].mean(axis=1)
        distance = np.where(distance > 0, distance, length.mean(axis=0) / 3)  # all three corners are cones
        weight = weight / distance**2
    i, j = corner[NEXT].ravel(), corner[PREV].ravel()
    w = weight.ravel()
    index = np.concatenate((i, j, i, j)), np.concatenate((i, j, j, i))
    return sparse.csr_array((np.concatenate((w, w, -w, -w)), index), shape=(len(z),) * 2)
