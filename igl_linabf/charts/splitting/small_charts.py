"""Merge small charts, which remain after splitting, into adjacent charts if there is room in the map.

The map of the adjacent chart does not change. Therefore the positions on the common seam are fixed. The map
of the small chart is kept if it matches the seam after a similarity transform. Otherwise the small chart is
mapped again by LSCM with fixed vertices on the seam.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..._core import has_overlap
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...errors import format_count
from ...layouts import least_squares
from ...linalg import NotPositiveDefiniteError, Solvers
from ...measures import measure_change, measure_qualities
from ...surface import (
    Ragged,
    Submesh,
    complex_positions,
    compute_flat_angles,
    real_coordinates,
    signed_double_areas,
)
from ..atlas import Chart, scale_to_surface

MAX_SMALL_AREA = 0.01  # maximum area of a small chart, as a share of the surface's area
MAX_SMALL_FACES = 300  # maximum number of faces of a small chart
FIT_TOL = 1e-5  # a chart fits if its seam vertices are off by at most this, relative to its extent
MAX_STRETCH_FACTOR = 1.01  # maximum factor by which merging small charts may increase the L2 stretch

Key = tuple[int, ...]  # position in the tree of cuts: index of a piece, of a part of the piece, and so on
Made = tuple[Key, Chart, Submesh]


def merge_small_charts(made: list[Made], most_stretch: float, kept: IntArray) -> list[Made]:
    """Merge small charts into adjacent charts of the same piece that have room for them.

    The edges `kept`, (#E, 2) input vertices, remain seams.
    """
    split = [len(key) > 1 for key, _, _ in made]
    if not any(split):
        return made
    area = [float(piece.areas_and_products[0].sum()) for _, _, piece in made]
    whole = sum(area)
    small = [
        parted
        and len(piece.topology.loops) == 1
        and len(piece.F) <= MAX_SMALL_FACES
        and a < MAX_SMALL_AREA * whole
        for parted, a, (_, _, piece) in zip(split, area, made, strict=True)
    ]
    if not any(small):
        return made
    of_piece: dict[int, list[_GrowingChart]] = {}
    for i, (key, chart, piece) in enumerate(made):
        if split[i] and not small[i] and not chart.overlapping and chart.result.outcome.good:
            of_piece.setdefault(key[0], []).append(_GrowingChart(i, chart, piece))
    rims = {k: _BoundaryEdges(hosts, kept) for k, hosts in of_piece.items()}
    taken = set[int]()
    for i in sorted(np.flatnonzero(small).tolist(), key=lambda i: area[i]):
        key, chart, piece = made[i]
        runs = rims[key[0]].find_runs(piece) if key[0] in rims else []
        candidate = _MergeCandidate(piece, chart.result.uv)
        if any(run.host.merge(piece, z, run, most_stretch) for run, z in candidate.iterate_positions(runs)):
            taken.add(i)
    larger = {host.index: host for hosts in of_piece.values() for host in hosts if host.guests}
    joined = {i: host.append_merged_charts(made[i]) for i, host in larger.items()}
    measured = measure_qualities([(piece, chart.result.uv, 0) for _, chart, piece in joined.values()])
    for (i, (key, chart, piece)), quality in zip(joined.items(), measured, strict=True):
        joined[i] = key, replace(chart, quality=quality), piece
    return [joined.get(i, entry) for i, entry in enumerate(made) if i not in taken]


class _SharedRun(NamedTuple):
    """A run of consecutive edges between a small chart and a host, which is an adjacent larger chart.

    Attributes
    ----------
    host : _GrowingChart
    own, of_host : (#R,) int64
        The vertices along the run, in the small chart and in the host.
    at : (#R,) complex128
        The positions of these vertices in the host's map.
    length : float
    """

    host: _GrowingChart
    own: IntArray
    of_host: IntArray
    at: ComplexArray
    length: float


@dataclass(frozen=True)
class _MergedChart:
    """A small chart that is merged into a host, which is an adjacent larger chart.

    `z` has the positions of the small chart's vertices in the host's map. `of_host` has the host's index of
    each vertex on the common boundary, and -1 for all other vertices.
    """

    piece: Submesh
    z: ComplexArray
    of_host: IntArray


class _MergeCandidate:
    """A small chart with its map, which may be merged into an adjacent chart."""

    def __init__(self, piece: Submesh, flat: FloatArray) -> None:
        self._piece, self._z = piece, complex_positions(flat)
        self._cot = np.divide(piece.areas_and_products[1], piece.areas_and_products[0])

    def iterate_positions(self, runs: list[_SharedRun]) -> Iterator[tuple[_SharedRun, ComplexArray]]:
        """Yield runs with positions of all vertices: first the given map where it fits, then LSCM maps."""
        if not runs:
            return
        fits, moved = self._fit_to_runs(runs)
        for k in np.flatnonzero(fits).tolist():
            z = moved[k]
            z[runs[k].own] = runs[k].at
            yield runs[k], z
        for run, fit in zip(runs, fits.tolist(), strict=True):
            laid_out = None if fit else self._lay_out(run.own, run.at)
            if laid_out is not None:
                yield run, laid_out

    def _fit_to_runs(self, runs: list[_SharedRun]) -> tuple[BoolArray, ComplexArray]:
        """Move the map so that it has the ends of a run of shared edges, for each run.

        Return a mask of the runs whose other vertices fit, too, and the moved maps.
        """
        z, vertices = self._z, Ragged.from_sizes([len(run.own) for run in runs])
        own, to = (np.concatenate(rows) for rows in zip(*((run.own, run.at) for run in runs), strict=True))
        (first, last), (start, end) = ((x[vertices.start[:-1]], x[vertices.start[1:] - 1]) for x in (own, to))
        apart = z[first] != z[last]
        turn = np.divide(end - start, z[last] - z[first], out=np.zeros_like(start), where=apart)
        moved = start[:, None] + (z - z[first][:, None]) * turn[:, None]
        off = vertices.max(np.abs(moved[vertices.repeat(np.arange(len(runs))), own] - to))
        return apart & (off <= FIT_TOL * np.abs(moved - start[:, None]).max(axis=1)), moved

    def _lay_out(self, fixed: IntArray, position: ComplexArray) -> ComplexArray | None:
        """Return the least-squares conformal map (LSCM) with fixed vertices; None if LSCM fails."""
        try:
            return least_squares(self._piece.topology, self._cot, fixed, position, Solvers("auto"))[0]
        except NotPositiveDefiniteError:
            return None


class _GrowingChart:
    """A chart, together with the small charts that are merged into it."""

    def __init__(self, index: int, chart: Chart, piece: Submesh) -> None:
        self.index, self.guests, self.n_given = index, list[_MergedChart](), piece.n_given
        self._chart, self._piece = chart, piece
        self._double_area = self._flat_area = float(
            piece.areas_and_products[0].sum()
        )  # equal, because the map preserves the total area
        self._squared = chart.quality.stretch_l2**2 * self._double_area
        self._z = complex_positions(chart.result.uv)
        size = -int(np.frexp(np.abs(chart.result.uv).max())[1])
        self._unit = float(np.ldexp(1.0, size))  # scales coordinates so that their squares cannot overflow
        self._in_chart = self._z[piece.F] * self._unit

    def get_boundary_edges(self) -> tuple[IntArray, IntArray]:
        """Return the boundary edges of the chart, (#E, 2), and a unique number for each edge."""
        loops = self._piece.topology.loops
        start = np.concatenate(loops)
        rim = np.column_stack((start, start[Ragged.from_sizes([len(loop) for loop in loops]).next_element]))
        return rim, _encode_edges(self._piece, *rim.T)

    def get_positions(self, vertices: IntArray) -> ComplexArray:
        """Return the positions of vertices in the map of the chart."""
        return np.asarray(self._z[vertices])

    def merge(self, piece: Submesh, z: ComplexArray, run: _SharedRun, most_stretch: float) -> bool:
        """Merge a small chart with the map `z` if there is room; return True if it is merged."""
        double_area = signed_double_areas(z, piece.topology.corner)
        if not double_area.min() > 0:
            return False
        own = z[piece.F] * self._unit
        if has_overlap(own, self._in_chart):
            return False
        changed = measure_change(piece, real_coordinates(z))
        own_area = float(changed.double_area.sum())
        share = own_area / double_area.sum()  # `squared_stretch` assumes that the map preserves the area
        own_squared = float(changed.double_area @ changed.squared_stretch)
        squared = self._squared + share * own_squared
        area, flat_area = self._double_area + own_area, self._flat_area + float(double_area.sum())
        stretch = np.sqrt(squared * flat_area) / area
        limit = min(MAX_STRETCH_FACTOR * self._chart.quality.stretch_l2, most_stretch)
        if not (stretch <= limit and np.sqrt(own_squared / own_area) <= most_stretch):
            return False
        of_host = np.full(len(piece.V), -1)
        of_host[run.own] = run.of_host
        self.guests.append(_MergedChart(piece, z, of_host))
        self._in_chart = np.concatenate((self._in_chart, own))
        self._squared, self._double_area, self._flat_area = squared, area, flat_area
        return True

    def append_merged_charts(self, entry: Made) -> Made:
        """Return one chart that consists of this chart and all merged charts, with the old `quality`."""
        key, chart, piece = entry
        V, uv, F, angles = [piece.V], [chart.result.uv], [piece.F], [chart.result.angles]
        faces, vertices = [piece.faces], [piece.vertices]
        inner = [] if piece.inner is None else [piece.inner]
        n = len(piece.V)
        for guest in self.guests:
            new = guest.of_host < 0
            index = np.where(new, n + np.cumsum(new) - 1, guest.of_host)
            n += int(new.sum())
            F.append(index[guest.piece.F])
            V.append(guest.piece.V[new])
            uv.append(real_coordinates(guest.z[new]))
            vertices.append(guest.piece.vertices[new])
            faces.append(guest.piece.faces)
            angles.append(compute_flat_angles(guest.z, guest.piece.topology.corner).T)
            inner += [] if guest.piece.inner is None else [guest.piece.inner]
        order = np.argsort(np.concatenate(faces))
        whole = Submesh(
            np.concatenate(V),
            np.concatenate(F)[order],
            np.concatenate(faces)[order],
            np.concatenate(vertices),
            piece.n_given,
            np.concatenate(inner)[order] if inner else None,
        )
        flat = scale_to_surface(np.concatenate(uv), whole)
        place = np.empty(len(order), dtype=np.int64)
        place[order] = np.arange(len(order))
        number = len(whole.F) - len(piece.F)
        report = chart.result.report
        result = replace(
            chart.result,
            uv=flat,
            F=whole.F,
            angles=np.concatenate(angles)[order],
            message=f"{chart.result.message}; with {format_count(number, 'face')} of small charts",
            report=replace(report, repaired=np.sort(place[report.repaired])),
        )
        return key, replace(chart, faces=whole.faces, result=result), whole


class _BoundaryEdges:
    """The boundary edges of large charts, except the edges `kept`, indexed by their vertices."""

    def __init__(self, hosts: list[_GrowingChart], kept: IntArray) -> None:
        rims, codes = zip(*(host.get_boundary_edges() for host in hosts), strict=True)
        of = np.repeat(np.arange(len(hosts)), [len(rim) for rim in rims])
        n, code = hosts[0].n_given, np.concatenate(codes)
        code[np.isin(code, np.concatenate((kept, kept[:, ::-1])) @ [n, 1])] = -1  # matches no edge
        order = np.argsort(code)
        self._hosts, self._of, self._code = hosts, of[order], code[order]
        self._rim = np.concatenate(rims)[order]

    def find_runs(self, piece: Submesh) -> list[_SharedRun]:
        """Return the runs of boundary edges that a chart with one boundary loop shares with large charts.

        The longest runs come first.
        """
        loop = piece.topology.loops[0]
        after = Ragged.from_sizes([len(loop)]).next_element
        following = loop[after]
        code = _encode_edges(piece, following, loop)  # adjacent charts traverse edges in reverse
        place = np.minimum(np.searchsorted(self._code, code), len(self._code) - 1)
        beside = self._code[place] == code
        (end, start), of = self._rim[place].T, np.where(beside, self._of[place], -1)
        # edges k and k + 1 of the loop belong to one run if their copies in the large chart share a vertex
        goes_on = beside & (of == of[after]) & (end == start[after])
        first = beside.copy()
        first[after] &= ~goes_on
        length, goes = np.linalg.norm(piece.V[following] - piece.V[loop], axis=1), goes_on.tolist()
        found = []
        for k in np.flatnonzero(first).tolist():
            number = 1
            while goes[(k + number - 1) % len(loop)]:
                number += 1
            number = min(number, len(loop) - 1)  # if the run is closed, omit one edge
            edges = np.arange(k, k + number) % len(loop)
            own = np.concatenate((loop[edges], following[edges[-1:]]))
            of_host = np.concatenate((start[edges], end[edges[-1:]]))
            host = self._hosts[of[k]]
            if of_host[0] != of_host[-1]:
                found.append(
                    _SharedRun(host, own, of_host, host.get_positions(of_host), float(length[edges].sum()))
                )
        return sorted(found, key=lambda run: (-run.length, run.host.index))


def _encode_edges(piece: Submesh, start: IntArray, end: IntArray) -> IntArray:
    return np.asarray(piece.vertices[start] * piece.n_given + piece.vertices[end])
