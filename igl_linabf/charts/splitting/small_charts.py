"""Charts of a few faces that a split leaves, joined to a neighbour where they have room beside it.

The neighbour keeps its map, and so the seam's vertices their places. The small chart is laid out beside it as
conformally as these allow. Where it would lie over something, it is joined along a part of the seam only, or
gets narrower.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, product
from typing import NamedTuple

import numpy as np

from ..._core import lie_over
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...layouts import energy_matrix, least_energy_positions, least_squares
from ...linalg import NotPositiveDefiniteError, Solvers
from ...measures import change_of, quality_of_each
from ...surface import Ragged, Submesh, complex_positions, coordinates, flat_angles, signed_double_areas
from ..atlas import Chart, scaled_to_surface
from . import constants

Key = tuple[int, ...]  # the piece that a chart is a part of, and its place there
Made = tuple[Key, Chart, Submesh]


def merge_small_charts(made: list[Made], most_stretch: float, kept: IntArray) -> list[Made]:
    """The charts, with small ones joined to others of the same piece, where these have room.

    The edges `kept`, (#E, 2) of the caller's vertices, stay seams.
    """
    split = [len(key) > 1 for key, _, _ in made]
    if not any(split):
        return made
    area = [float(piece.measured[0].sum()) for _, _, piece in made]
    largest = constants.MAX_AREA_OF_SMALL_CHART * sum(area)
    small = [
        parted
        and a < largest
        and len(piece.F) <= constants.MAX_FACES_OF_SMALL_CHART
        and len(piece.topology.loops) == 1
        for parted, a, (_, _, piece) in zip(split, area, made, strict=True)
    ]
    if not any(small):
        return made
    of_piece: dict[int, list[_Host]] = {}
    for i, (key, chart, piece) in enumerate(made):
        if split[i] and not small[i] and not chart.overlapping and chart.result.outcome.good:
            of_piece.setdefault(key[0], []).append(_Host(i, chart, piece))
    rims = {k: _Rims(hosts, kept) for k, hosts in of_piece.items()}
    taken = set[int]()
    for i in sorted(np.flatnonzero(small).tolist(), key=lambda i: area[i]):
        key, chart, piece = made[i]
        runs = rims[key[0]].beside(piece) if key[0] in rims else []
        candidate = _Candidate(piece, chart.result.uv)
        if any(run.host.takes(piece, z, run, width, most_stretch) for run, width, z in candidate.ways(runs)):
            taken.add(i)
    larger = {host.index: host for hosts in of_piece.values() for host in hosts if host.guests}
    joined = {i: host.joined(made[i]) for i, host in larger.items()}
    measured = quality_of_each([(piece, chart.result.uv, 0) for _, chart, piece in joined.values()])
    for (i, (key, chart, piece)), quality in zip(joined.items(), measured, strict=True):
        joined[i] = key, replace(chart, quality=quality), piece
    return [joined.get(i, entry) for i, entry in enumerate(made) if i not in taken]


class _Run(NamedTuple):
    """Edges in a row between a small chart and a host: vertices in both, their places there, and length."""

    host: _Host
    own: IntArray
    of_host: IntArray
    at: ComplexArray
    length: float


@dataclass(frozen=True)
class _Guest:
    """A small chart, its vertices' places and, on the run, their index in the host; else -1."""

    piece: Submesh
    z: ComplexArray
    of_host: IntArray


class _Candidate:
    """A small chart and its map, and the ways to lay it out beside others."""

    def __init__(self, piece: Submesh, flat: FloatArray) -> None:
        self._piece, self._z = piece, complex_positions(flat)
        self._cot = np.divide(piece.measured[1], piece.measured[0])
        self._matrices = dict[float, ComplexArray]()

    def ways(self, runs: list[_Run]) -> Iterator[tuple[_Run, float, ComplexArray]]:
        """Runs, widths and positions: the map itself where it fits along a run; else ever narrower ones."""
        if not runs:
            return
        fits, moved = self._moved(runs)
        for k in np.flatnonzero(fits).tolist():
            z = moved[k]
            z[runs[k].own] = runs[k].at
            yield runs[k], 1.0, z
        rest = [run for run, fit in zip(runs, fits, strict=True) if not fit]
        others = list(zip(rest, self._least_shear(rest), strict=True)) if rest else []
        tries = product(constants.RELAYOUT_WIDTHS, others)
        for width, (run, least) in islice(tries, constants.MAX_JOINING_TRIES):
            if least <= run.host.most_shear(width):
                laid_out = self._laid_out(run.own, run.at, width)
                if laid_out is not None:
                    yield run, width, laid_out

    def _moved(self, runs: list[_Run]) -> tuple[BoolArray, ComplexArray]:
        """Whether the map, moved to the ends of a run, fits it, for each; and its places there, (#R, #V)."""
        z, vertices = self._z, Ragged.of_sizes([len(run.own) for run in runs])
        own, to = (np.concatenate(rows) for rows in zip(*((run.own, run.at) for run in runs), strict=True))
        (first, last), (start, end) = ((x[vertices.start[:-1]], x[vertices.start[1:] - 1]) for x in (own, to))
        apart = z[first] != z[last]
        turn = np.divide(end - start, z[last] - z[first], out=np.zeros_like(start), where=apart)
        moved = start[:, None] + (z - z[first][:, None]) * turn[:, None]
        off = vertices.max(np.abs(moved[vertices.repeat(np.arange(len(runs))), own] - to))
        return apart & (off <= constants.FIT_TOL * np.abs(moved - start[:, None]).max(axis=1)), moved

    def _least_shear(self, runs: list[_Run]) -> list[float]:
        """The least mean angle distortion of any map with the vertices of a run held, for each.

        Of angles b that have to change by d together, the relative errors have squares of d^2 / sum b^2 at
        least (Cauchy).
        """
        z = np.concatenate([run.at for run in runs])
        inner = np.concatenate([run.own[1:-1] for run in runs])
        of = np.repeat(np.arange(len(runs)), [len(run.own) - 2 for run in runs])
        middle = np.arange(1, len(inner) + 1) + 2 * of
        there = np.angle((z[middle - 1] - z[middle]) / (z[middle + 1] - z[middle])) % (2 * np.pi)
        total, squares = self._angles
        least = np.bincount(of, (there - total[inner]) ** 2 / squares[inner], len(runs)) / self._cot.size
        return list(least.tolist())

    @cached_property
    def _angles(self) -> tuple[FloatArray, FloatArray]:
        """The sum of the angles at each vertex, and that of their squares."""
        angle = np.arctan2(*self._piece.measured)
        return self._piece.topology.sum_at_vertices(angle), self._piece.topology.sum_at_vertices(angle**2)

    def _laid_out(self, fixed: IntArray, position: ComplexArray, width: float) -> ComplexArray | None:
        """The map of least squares to a conformal one (LSCM) with some vertices held, or a narrower one.

        None if the piece is too thin for that.
        """
        topology = self._piece.topology
        if topology.n > constants.MAX_DENSE_VERTICES:
            try:
                return least_squares(topology, self._cot, fixed, position, Solvers("auto"), width)[0]
            except NotPositiveDefiniteError:
                return None
        if width not in self._matrices:
            self._matrices[width] = energy_matrix(topology.corner, topology.n, self._cot, width)
        z, free = np.zeros(topology.n, dtype=np.complex128), np.ones(topology.n, dtype=bool)
        z[fixed], free[fixed] = position, False
        return least_energy_positions(self._matrices[width], z, free)


class _Host:
    """A chart that small ones may be joined to, and those that are."""

    def __init__(self, index: int, chart: Chart, piece: Submesh) -> None:
        self.index, self.guests, self.n_given = index, list[_Guest](), piece.n_given
        self._chart, self._piece = chart, piece
        self._double_area = self._flat_area = float(piece.measured[0].sum())  # the map has the scale one
        self._squared = chart.quality.stretch_l2**2 * self._double_area
        self._z = complex_positions(chart.result.uv)
        size = -int(np.frexp(np.abs(chart.result.uv).max())[1])
        self._unit = float(np.ldexp(1.0, size))  # squares of larger ones could overflow
        self._in_chart = self._z[piece.F] * self._unit

    def rim(self) -> tuple[IntArray, IntArray]:
        """Its boundary edges, (#E, 2), and their codes."""
        loops = self._piece.topology.loops
        start = np.concatenate(loops)
        rim = np.column_stack((start, start[Ragged.of_sizes([len(loop) for loop in loops]).following]))
        return rim, _codes(self._piece, *rim.T)

    def most_shear(self, width: float) -> float:
        """The mean angle distortion that a chart joined to it may have at this width."""
        if self._chart.quality.angle_distortion > constants.INVISIBLE_SHEAR:
            return constants.MAX_NARROWED_SHEAR
        return constants.INVISIBLE_SHEAR if width == 1 else -1.0  # narrower, it is not isometric

    def at(self, vertices: IntArray) -> ComplexArray:
        """Where these are in its map."""
        return np.asarray(self._z[vertices])

    def takes(self, piece: Submesh, z: ComplexArray, run: _Run, width: float, most_stretch: float) -> bool:
        """Join a chart, at this width and these positions, if it has room there; whether it is joined."""
        double_area = signed_double_areas(z, piece.topology.corner)
        if not double_area.min() > 0:
            return False
        own = z[piece.F] * self._unit
        if lie_over(own, self._in_chart):
            return False
        changed = change_of(piece, coordinates(z))
        if not changed.angle_distortion.mean() <= self.most_shear(width):
            return False
        own_area = float(changed.double_area.sum())
        share = own_area / double_area.sum()  # stretch is measured at a scale of its own: the host's is one
        squared = self._squared + share * float(changed.double_area @ changed.squared_stretch)
        area, flat_area = self._double_area + own_area, self._flat_area + float(double_area.sum())
        stretch = np.sqrt(squared * flat_area) / area
        if not stretch <= min(constants.MAX_STRETCH_FACTOR * self._chart.quality.stretch_l2, most_stretch):
            return False
        of_host = np.full(len(piece.V), -1)
        of_host[run.own] = run.of_host
        self.guests.append(_Guest(piece, z, of_host))
        self._in_chart = np.concatenate((self._in_chart, own))
        self._squared, self._double_area, self._flat_area = squared, area, flat_area
        return True

    def joined(self, entry: Made) -> Made:
        """The chart with all that it took; its quality is still that of the chart alone."""
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
            uv.append(coordinates(guest.z[new]))
            vertices.append(guest.piece.vertices[new])
            faces.append(guest.piece.faces)
            angles.append(flat_angles(guest.z, guest.piece.topology.corner).T)
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
        flat = scaled_to_surface(np.concatenate(uv), whole)
        place = np.empty(len(order), dtype=np.int64)
        place[order] = np.arange(len(order))
        number = len(whole.F) - len(piece.F)
        result = replace(
            chart.result,
            uv=flat,
            F=whole.F,
            angles=np.concatenate(angles)[order],
            repaired=np.sort(place[chart.result.repaired]),
            message=f"{chart.result.message}; {number:,} faces of small charts are joined to it",
        )
        return key, replace(chart, faces=whole.faces, result=result), whole


class _Rims:
    """The boundaries of some hosts but for the edges `kept`, in which each is found by its vertices."""

    def __init__(self, hosts: list[_Host], kept: IntArray) -> None:
        rims, codes = zip(*(host.rim() for host in hosts), strict=True)
        of = np.repeat(np.arange(len(hosts)), [len(rim) for rim in rims])
        n, code = hosts[0].n_given, np.concatenate(codes)
        code[np.isin(code, np.concatenate((kept, kept[:, ::-1])) @ [n, 1])] = -1  # that of no edge
        order = np.argsort(code)
        self._hosts, self._of, self._code = hosts, of[order], code[order]
        self._rim = np.concatenate(rims)[order]

    def beside(self, piece: Submesh) -> list[_Run]:
        """Where a chart of one boundary loop lies beside hosts, and parts of that; the longest first."""
        loop = piece.topology.loops[0]
        after = Ragged.of_sizes([len(loop)]).following
        following = loop[after]
        code = _codes(piece, following, loop)  # as the host goes along them
        place = np.minimum(np.searchsorted(self._code, code), len(self._code) - 1)
        beside = self._code[place] == code
        (end, start), of = self._rim[place].T, np.where(beside, self._of[place], -1)
        # edge k, from loop[k] to loop[k + 1], goes on in edge k + 1 if the host's vertex there is one
        goes_on = beside & (of == of[after]) & (end == start[after])
        first = beside.copy()
        first[after] &= ~goes_on
        length, goes = np.linalg.norm(piece.V[following] - piece.V[loop], axis=1), goes_on.tolist()
        found = []
        for k in np.flatnonzero(first).tolist():
            number = 1
            while goes[(k + number - 1) % len(loop)]:
                number += 1
            edges = np.arange(k, k + number) % len(loop)
            own = np.concatenate((loop[edges], following[edges[-1:]]))
            of_host = np.concatenate((start[edges], end[edges[-1:]]))
            host, names = self._hosts[of[k]], of_host.tolist()
            at, upto = host.at(of_host), [0.0, *np.cumsum(length[edges]).tolist()]
            for i, j in _parts_of_run(number, bool(own[0] == own[-1])):
                if names[i] != names[j]:
                    part = slice(i, j + 1)
                    found.append(_Run(host, own[part], of_host[part], at[part], upto[j] - upto[i]))
        return sorted(found, key=lambda run: (-run.length, run.host.index))


def _parts_of_run(number: int, closed: bool) -> list[tuple[int, int]]:
    """A run of so many edges, and if it is short, its parts: along one, a chart may find room."""
    least, most = 1 if number <= constants.MAX_EDGES_TO_TRY_PARTS else number, number - closed
    return [(i, j) for i in range(number) for j in range(i + least, min(i + most, number) + 1)]


def _codes(piece: Submesh, start: IntArray, end: IntArray) -> IntArray:
    return np.asarray(piece.vertices[start] * piece.n_given + piece.vertices[end])
