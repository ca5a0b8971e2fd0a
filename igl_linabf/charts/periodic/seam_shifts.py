"""Measure rotations and shifts between the two sides of a seam, and find the shifts that are free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..._types import ComplexArray, IntArray
from ...errors import MeshError, first_few
from ...surface import NEXT, PREV, Submesh, connected_labels
from ..atlas import find_texture_seam_rows

QUARTER_TURN_TOL = 1e-3  # maximum relative deviation of a seam edge's sides from a rotation by quarter turns


@dataclass(frozen=True, eq=False)
class SeamSides:
    """Both sides of the seam edges. z -> turn * z + shift maps the first side to the second.

    Attributes
    ----------
    vertex : (#S, 2) int64
        The ends of each edge.
    first, second : (#S, 2) int64
        The copies of the ends on the first and the second side: row indices into `TC`.
    turn : (#S,) complex128
        The rotation from the first side to the second, a power of i.
    shift : (#S,) complex128
    """

    vertex: IntArray
    first: IntArray
    second: IntArray
    turn: ComplexArray
    shift: ComplexArray

    @classmethod
    def from_map(cls, surface: Submesh, z: ComplexArray, FTC: IntArray) -> SeamSides:
        """Measure the rotations and shifts between the two sides of all seam edges of a map."""
        topology = surface.topology
        rows = find_texture_seam_rows(topology, FTC)
        start, end = FTC.T[NEXT].ravel(), FTC.T[PREV].ravel()
        one, other = topology.sides[:, rows]
        tail, head = surface.F.T[NEXT].ravel(), surface.F.T[PREV].ravel()
        vertex = np.column_stack((tail[one], head[one]))
        first = np.column_stack((start[one], end[one]))
        second = np.column_stack((end[other], start[other]))
        ratio = (z[second[:, 1]] - z[second[:, 0]]) / (z[first[:, 1]] - z[first[:, 0]])
        quarters = np.round(np.angle(ratio) / (np.pi / 2)).astype(np.int64) % 4
        turn = np.array([1, 1j, -1, -1j])[quarters]
        off = np.flatnonzero(~(np.abs(ratio - turn) < QUARTER_TURN_TOL))
        if len(off):
            raise MeshError(
                f"the seam at vertices {first_few(surface.vertices[vertex[off, 0]])} turns by no multiple of "
                "90 "
                'degrees, and no texture goes on across it: use angles="quarter"; if the map did not '
                "reach them, give more cones"
            )
        return cls(vertex, first, second, turn, (z[second] - turn[:, None] * z[first]).mean(axis=1))


Sums = list[tuple[int, complex]]  # linear combination of shifts: pairs of a seam edge and a power of i


@dataclass(frozen=True, eq=False)
class VertexFan:
    """The copies of a seam vertex, in order around it.

    Copy k is at turns[k] * (position of the first copy) + sums[k], where sums[k] is a linear combination of
    shifts. `closing` has the turn and the sum after a full circle around the vertex; None at the boundary.
    """

    vertex: int
    copies: list[int]
    turns: list[complex]
    sums: list[Sums]
    closing: tuple[complex, Sums] | None

    @property
    def turns_cancel(self) -> bool:
        """Return True if the rotations around the vertex cancel. Then the vertex is not a cone."""
        return self.closing is not None and self.closing[0] == 1


def find_fans(sides: SeamSides) -> list[VertexFan]:
    """Return the copies of all seam vertices, in order around each vertex."""
    ways: dict[int, list[tuple[int, int, bool]]] = {}  # copy -> its seam edges, copies across, directions
    copies: dict[int, list[int]] = {}
    for e, (vertices, first, second) in enumerate(
        zip(sides.vertex.tolist(), sides.first.tolist(), sides.second.tolist(), strict=True)
    ):
        for v, i, j in zip(vertices, first, second, strict=True):
            ways.setdefault(i, []).append((e, j, True))
            ways.setdefault(j, []).append((e, i, False))
            copies.setdefault(v, []).extend((i, j))
    turn = sides.turn.tolist()
    fans = []
    for v, own in copies.items():
        ends = [i for i in own if len(ways[i]) == 1]  # start at the boundary if the vertex is on it
        at = ends[0] if ends else own[0]
        fan = VertexFan(v, [at], [1 + 0j], [[]], None)
        by, sums, came, closing = 1 + 0j, Sums(), -1, None
        while True:
            onward = [way for way in ways[at] if way[0] != came]
            if not onward:
                break
            e, at, forward = onward[0]
            factor = turn[e] if forward else 1 / turn[e]
            sums = [(f, factor * c) for f, c in sums] + [(e, 1 + 0j if forward else -factor)]
            by, came = factor * by, e
            if at == fan.copies[0]:
                closing = by, sums
                break
            fan.copies.append(at)
            fan.turns.append(by)
            fan.sums.append(sums)
        fans.append(VertexFan(v, fan.copies, fan.turns, fan.sums, closing))
    return fans


@dataclass(frozen=True, eq=False)
class FreeShifts:
    """The shifts of all seam edges as linear functions of some of them, the free shifts.

    The constraint is that the shifts around a vertex cancel unless the vertex is a cone.

    Attributes
    ----------
    edges : (#K,) int64
        The seam edges whose shifts are free.
    shifts : (#S, #K) complex128
        The shifts of all edges as functions of the free shifts.
    cones : (#C,) int64
        The cones whose positions are determined by the shifts.
    places : (#C, #K) complex128
        The positions of the first copies of the cones as functions of the free shifts.
    """

    edges: IntArray
    shifts: sparse.csr_array
    cones: IntArray
    places: sparse.csr_array

    @classmethod
    def from_seam_sides(cls, sides: SeamSides, fans: list[VertexFan]) -> FreeShifts:
        """Find the free shifts of all seams. There must be at least one seam edge."""
        seam = connected_labels(sides.vertex, int(sides.vertex.max()) + 1)
        own: dict[int, list[VertexFan]] = {}
        for fan in fans:
            own.setdefault(int(seam[fan.vertex]), []).append(fan)
        of_edge = seam[sides.vertex[:, 0]]
        order = np.argsort(of_edge, kind="stable")
        seams = np.split(order, np.flatnonzero(np.diff(of_edge[order])) + 1)
        made = [_solve_seam(sides, edges, own[int(of_edge[edges[0]])]) for edges in seams]
        chosen, shifts, cones, places = zip(*made, strict=True)
        return cls(
            np.concatenate(chosen),
            sparse.block_diag(list(map(sparse.csr_array, shifts)), format="csr")[np.argsort(order)],
            np.concatenate(cones),
            sparse.block_diag(list(map(sparse.csr_array, places)), format="csr"),
        )


def _solve_seam(
    sides: SeamSides, edges: IntArray, fans: list[VertexFan]
) -> tuple[IntArray, ComplexArray, IntArray, ComplexArray]:
    """Return the attributes of `FreeShifts` for one connected seam.

    On a spanning tree of the seam, each vertex that is not a cone determines the shift of the edge to its
    parent. The shifts of all other edges are free.
    """
    fan_of = {fan.vertex: fan for fan in fans}
    order, above = _span_seam(sides, edges, fans)
    on_tree = {above[v] for v in order if above[v] >= 0}
    bound = {above[v] for v in order if above[v] >= 0 and fan_of[v].turns_cancel}
    choice = np.array([e for e in edges.tolist() if e not in bound], dtype=np.int64)
    assert len(bound) <= len(on_tree)
    row = dict(zip(edges.tolist(), range(len(edges)), strict=True))
    rows = np.zeros((len(edges), len(choice)), dtype=np.complex128)  # shifts in terms of free shifts
    rows[[row[e] for e in choice.tolist()], np.arange(len(choice))] = 1.0
    for v in reversed(order):
        fan = fan_of[v]
        if fan.closing is None or not fan.turns_cancel:
            continue
        others = (c * rows[row[e]] for e, c in fan.closing[1] if e != above[v])
        total = sum(others, np.zeros(len(choice), complex))
        if above[v] >= 0:
            (own,) = (c for e, c in fan.closing[1] if e == above[v])
            rows[row[above[v]]] = -total / own
        elif np.abs(total).max(initial=0.0) > 0:
            raise MeshError(
                "the seam turns by multiples of 90 degrees along handles only, and its shifts cannot be "
                "chosen: give cones"
            )
    ends = [(fan, *fan.closing) for fan in fans if fan.closing is not None and not fan.turns_cancel]
    held = np.array([fan.vertex for fan, _, _ in ends], dtype=np.int64)
    places = np.array([sum(c * rows[row[e]] for e, c in sums) / (1 - by) for _, by, sums in ends])
    places = places.reshape(len(ends), len(choice))
    return choice, rows, held, places


def _span_seam(sides: SeamSides, edges: IntArray, fans: list[VertexFan]) -> tuple[list[int], dict[int, int]]:
    """Return a spanning forest of a seam.

    Roots are cones or boundary vertices, if a component of the seam has such vertices.

    Returns
    -------
    order : list of int
        The vertices, each after its parent.
    above : dict
        The edge from each vertex to its parent; -1 for roots.
    """
    beside: dict[int, list[tuple[int, int]]] = {fan.vertex: [] for fan in fans}
    for e, (a, b) in zip(edges.tolist(), sides.vertex[edges].tolist(), strict=True):
        beside[a].append((e, b))
        beside[b].append((e, a))
    order: list[int] = []
    above: dict[int, int] = {}
    for root in sorted(fans, key=lambda fan: fan.turns_cancel):
        if root.vertex in above:
            continue
        above[root.vertex] = -1
        waiting = [root.vertex]
        while waiting:
            order += waiting
            further = []
            for v in waiting:
                for e, w in beside[v]:
                    if w not in above:
                        above[w] = e
                        further.append(w)
            waiting = further
    return order, above
