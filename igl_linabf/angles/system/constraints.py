"""The constraints on the angles of a mesh with prescribed angle sums (eq. 5, 6, 10), and their residuals.

Around holes and along closed paths, the angles draw a loop that has to close.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ... import _core
from ..._core import angle_sums, cotangents
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged, Topology
from .circles import foreseen, inscribed_sums
from .patterns import Pattern


@dataclass(frozen=True, eq=False)
class ClosedPath:
    """A closed path of edges, along which scale and direction are to come back.

    The path's *left fans* are the corners to its left at its vertices. Over them the logarithms of the
    next edge's length over the last one's sum to zero, so the path ends at the scale at which it
    begins. The exterior angles, pi - the sum of the left fan, sum to `turning`.

    Attributes
    ----------
    corner : (#c,) int64
        The corners of the left fans, numbered k #F + t.
    size : int
        Number of the path's vertices.
    turning : float
        Sum of the exterior angles, radians; NaN if it may be any.
    """

    corner: IntArray
    size: int
    turning: float = np.nan


@dataclass(frozen=True, eq=False)
class HolonomyResidual:
    """By how much loops and closed paths drawn from the angles fail to close (docs/holes.md).

    Loops of holes: first the exterior angles are shifted to sum to -2 pi, and the logarithms of the
    length ratios to sum to 0, evenly over a loop. The derivative is averaged over all starting
    vertices, so the result does not depend on the start.

    Attributes
    ----------
    gap : (#holes + #paths,) complex128
        For each hole tau: vector from the start to the end of its loop, in units of its length. For
        each path the sum of the logarithms + i (sum of the exterior angles - `turning`).
    site, row : (#L,) int64
        The *sites* of all these, and the entry of `gap` that each adds to. Site v is vertex v; after
        the vertices come the paths.
    q : (#L,) complex128
        Derivative of the gap with respect to log_ratio + i turning at the site. At a hole's vertex it
        is the vector from the vertex to the loop's end, minus its mean over the loop; at a path it
        is 1.
    asked : (#holes + #paths, 2) bool
        Whether the real and the imaginary part of each gap is to vanish.
    """

    gap: ComplexArray
    site: IntArray
    row: IntArray
    q: ComplexArray
    asked: BoolArray

    def of_paths(self, n: int) -> HolonomyResidual:
        """Only that of the paths, the last `n`."""
        asked = self.asked.copy()
        asked[: len(asked) - n] = False
        return replace(self, asked=asked)


def holonomy_residual(
    topology: Topology,
    turning: FloatArray,
    log_ratio: FloatArray,
    paths: tuple[ClosedPath, ...] = (),
    drawn: ComplexArray | None = None,
) -> HolonomyResidual:
    """Draw each hole's loop; `turning` and `log_ratio` as in `Residual`.

    `drawn` has the sum of the logarithms + i angles over the left fans of each path.
    """
    holes = topology.holes
    if not holes and not paths:
        none, nowhere = np.empty(0, dtype=np.complex128), np.empty(0, dtype=np.int64)
        return HolonomyResidual(none, nowhere, nowhere, none, np.empty((0, 2), dtype=bool))
    parts = Ragged.of_sizes([len(loop) for loop in holes])
    site = np.concatenate((*holes, topology.n + np.arange(len(paths))))
    gap, q = _core.drawn_loops(site[: parts.start[-1]], parts.start, turning, log_ratio)
    asked = np.ones((len(holes) + len(paths), 2), dtype=bool)
    if paths:
        assert drawn is not None
        wanted = np.array([path.size * np.pi - path.turning for path in paths])
        asked[len(holes) :, 1] = ~np.isnan(wanted)
        beyond = np.where(np.isnan(wanted), 0.0, wanted - drawn.imag)
        gap = np.concatenate((gap, drawn.real + 1j * beyond))
        q = np.append(q, np.ones(len(paths)))
    row = np.repeat(np.arange(len(gap)), np.append(parts.sizes, np.ones(len(paths), dtype=np.int64)))
    return HolonomyResidual(gap, site, row, q, asked)


SMALLEST_SINE = 1e-75  # of an angle of 0, as in a collapsed triangle; the core's sums go by the same


@dataclass(frozen=True, eq=False)
class Constraints:
    """The vertex and wheel constraints of a surface (eq. 5 and 10); a row has one of each.

    The last rows have a vertex constraint only. Where all constraints of a kind depend on each other,
    one of them is left out: it holds with the others.

    Attributes
    ----------
    topology : Topology
    row : (#V,) int64
        The virtual-vertex map: the row of each vertex's constraints. An interior vertex has its own
        row, and so has a boundary vertex with a prescribed angle sum. All vertices of a hole without
        prescribed sums share one row. Other vertices have -1.
    target : (#rows,) float64
        Target angle sum of each row: that prescribed at a vertex, (m + 2) pi around a hole of m
        vertices.
    sums : (#V,) float64
        The angle sum that is asked for at each vertex; NaN where none is.
    wheels : int
        The first so many rows have a wheel constraint, too.
    paths : tuple of ClosedPath
        Closed paths whose scale, and maybe turning, is to come back: one constraint or two each.
    circles : tuple of int
        The boundary loops that are to lie on circles. Their sums are those of the inscribed polygon with
        the lengths that the present angles give; `target` and `sums` have those of the surface's lengths.
    """

    topology: Topology
    row: IntArray
    target: FloatArray
    sums: FloatArray
    wheels: int
    paths: tuple[ClosedPath, ...] = ()
    circles: tuple[int, ...] = ()

    @property
    def n(self) -> int:
        """Number of rows."""
        return len(self.target)

    @property
    def empty(self) -> bool:
        """Whether nothing is constrained: every vertex is on the boundary, and nothing is to close."""
        return not self.n and not self.paths

    @property
    def prescribes_sums(self) -> bool:
        """Whether other sums are asked for than 2 pi inside."""
        return bool((self.sums[~np.isnan(self.sums)] != 2 * np.pi).any())

    @property
    def plain(self) -> bool:
        """Whether nothing is asked for but a flat map."""
        return not (self.prescribes_sums or self.paths or self.circles)

    @cached_property
    def pattern(self) -> Pattern:
        """The graph of the rows."""
        return Pattern(self.topology, self.row, self.n)

    def with_prescribed(
        self, sums: FloatArray | None = None, turnings: FloatArray | None = None
    ) -> Constraints:
        """The same rows with other angle sums, (#V,), and other turnings; no hole has a row."""
        made, inside = self, self.row >= 0
        if sums is not None:
            target = self.target.copy()
            target[self.row[inside]] = sums[inside]
            made = replace(made, sums=sums, target=target)
        if turnings is not None:
            both = zip(self.paths, turnings.tolist(), strict=True)
            made = replace(made, paths=tuple(replace(path, turning=turning) for path, turning in both))
        made.__dict__["pattern"] = self.pattern  # that of the same rows
        return made

    def sum_at_rows(self, values: FloatArray) -> FloatArray:
        """Sum (#V,) values over the vertices of each row."""
        if self._vertex is not None:
            return values.take(self._vertex)
        return np.asarray(np.bincount(self.row + 1, weights=values, minlength=self.n + 1)[1:])

    @cached_property
    def _vertex(self) -> IntArray | None:
        """The vertex of each row; None where a row has several, as a hole's has."""
        inside = np.flatnonzero(self.row >= 0)
        if len(inside) != self.n:
            return None
        vertex = np.empty_like(inside)
        vertex[self.row[inside]] = inside
        return vertex

    def sum_at_wheels(self, values: FloatArray) -> FloatArray:
        """`sum_at_rows`, zero where the row has no wheel constraint."""
        total = self.sum_at_rows(values)
        total[self.wheels :] = 0.0
        return total

    def target_at(self, log_ratio: FloatArray) -> FloatArray:
        """Target angle sum of each row where the loops' edges have the ratios `log_ratio`, (#V,)."""
        if not self.circles:
            return self.target
        target = self.target.copy()
        for i in self.circles:
            loop = self.topology.loops[i]
            asked = self.row[loop] >= 0
            target[self.row[loop[asked]]] = inscribed_sums(log_ratio[loop], i > 0)[asked]
        return target

    def ahead(self, b: Residual) -> Residual:
        """The residual with the change of sums that leads to circles, whose sums change on the way."""
        if not self.circles:
            return b
        vertex = b.vertex.copy()
        for i in self.circles:
            loop = self.topology.loops[i]
            asked = self.row[loop] >= 0
            more = foreseen(b.log_ratio[loop], b.turning[loop], i > 0)[asked]
            vertex[self.row[loop[asked]]] += more
        return replace(b, vertex=vertex)


def constraints_of(
    topology: Topology,
    sums: FloatArray | None = None,
    paths: Sequence[ClosedPath] = (),
    circles: Sequence[int] = (),
    left_out: int | None = None,
) -> Constraints:
    """A row for each interior vertex, one for each hole as a virtual vertex, and one for each prescribed sum.

    Around a hole of m vertices the angles sum to (m + 2) pi; m = 0 is an interior vertex. A hole with
    prescribed sums at some of its vertices is no virtual vertex but a closed path: it turns by -2 pi and
    comes back to its scale.

    Parameters
    ----------
    topology : Topology
        Of a connected surface, which may be closed and may have handles.
    sums : (#V,) float64, optional
        Angle sum at each vertex, radians. NaN is 2 pi inside, and nothing at the boundary.
    paths : sequence of ClosedPath
        Further paths that are to close.
    circles : sequence of int
        Loops of which all sums are given, those of inscribed polygons.
    left_out : int, optional
        On a closed surface, the vertex whose rows are left out; by default the one of most curvature.
    """
    if sums is None and not paths:
        return topology.once("constraints", lambda: _constraints(topology, None, (), (), None))
    return _constraints(topology, sums, paths, circles, left_out)


def _constraints(
    topology: Topology,
    sums: FloatArray | None,
    paths: Sequence[ClosedPath],
    circles: Sequence[int],
    ground: int | None,
) -> Constraints:
    inside = topology.interior
    sums = np.full(topology.n, np.nan) if sums is None else sums
    sums = np.where(inside & np.isnan(sums), 2 * np.pi, sums)
    given = ~np.isnan(sums)
    virtual = [loop for loop in topology.holes if not given[loop].any()]
    around = [_path_of(topology, loop, given) for loop in topology.holes if given[loop].any()]
    left_out = np.zeros(topology.n, dtype=bool)
    if not topology.loops:
        # the wheel constraints sum to zero, angle by angle, and the vertex constraints as below
        left_out[np.argmax(np.abs(sums - 2 * np.pi)) if ground is None else ground] = True
    elif given[topology.loops[0]].all() and topology.n_outer == 1:
        # the angles of all vertices sum to those of all triangles (Gauss-Bonnet); holes turn anyway
        left_out[topology.loops[0][0]] = True
    inner, rim = inside & ~left_out, given & ~inside & ~left_out
    row = np.where(inner, np.cumsum(inner) - 1, -1)
    n_inner = int(np.count_nonzero(inner))
    for i, loop in enumerate(virtual):
        row[loop] = n_inner + i
    wheels = n_inner + len(virtual)
    row[rim] = wheels + np.arange(np.count_nonzero(rim))
    target = np.full(wheels, 2 * np.pi)
    target[:n_inner] = sums[inner]
    target[n_inner:] += [np.pi * len(loop) for loop in virtual]
    target = np.concatenate((target, sums[rim]))
    return Constraints(topology, row, target, sums, wheels, (*around, *paths), tuple(circles))


def _path_of(topology: Topology, loop: IntArray, given: BoolArray) -> ClosedPath:
    """A hole's loop; it turns by itself where all its sums are given."""
    on_loop = np.zeros(topology.n, dtype=bool)
    on_loop[loop] = True
    turning = np.nan if given[loop].all() else -2 * np.pi
    return ClosedPath(np.flatnonzero(on_loop[topology.corner].ravel()), len(loop), turning)


@dataclass(frozen=True, eq=False)
class Residual:
    """Residuals of the constraints: the right-hand sides b of eq. 5, 6 and 10.

    Attributes
    ----------
    vertex, wheel : (#rows,) float64
        target - sum alpha, and sum log sin(gamma) - log sin(beta).
    triangle : (#F,) float64
        pi - sum alpha.
    turning, log_ratio : (#V,) float64
        At a vertex of a boundary loop, the mesh on the left: the exterior angle, and the
        logarithm of the next edge's length over the last one's.
    holonomy : HolonomyResidual
        The holes' loops drawn from these, and the closed paths.
    """

    vertex: FloatArray
    wheel: FloatArray
    triangle: FloatArray
    turning: FloatArray
    log_ratio: FloatArray
    holonomy: HolonomyResidual

    @cached_property
    def largest(self) -> float:
        """Largest absolute value: radians, logarithms, relative gaps of holes."""
        return max(self.at_vertices, largest_magnitude(np.abs(self.holonomy.gap)))

    @cached_property
    def at_vertices(self) -> float:
        """The largest of those but the holonomy's."""
        families = (self.vertex, self.wheel, self.triangle)
        return max(map(largest_magnitude, families))


def largest_magnitude(values: FloatArray) -> float:
    """The largest absolute value; 0 of none."""
    return float(max(values.max(initial=0.0), -values.min(initial=0.0)))  # no array of absolute values


def _log_sines(alpha: FloatArray) -> FloatArray:
    return np.asarray(np.log(np.maximum(np.abs(np.sin(alpha)), SMALLEST_SINE)))


def residual(constraints: Constraints, alpha: FloatArray, cot: FloatArray | None = None) -> Residual:
    """Residuals of the angle constraints at `alpha`, (3, #F) radians, whose cotangents may be known."""
    topology, paths = constraints.topology, constraints.paths
    cot = cotangents(alpha) if cot is None else cot
    total, log_ratio = angle_sums(topology.corner, alpha, cot, topology.n)  # eq. 7: logarithms of sines
    turning, triangle = np.pi - total, alpha.sum(axis=0)
    np.subtract(np.pi, triangle, out=triangle)
    drawn = None
    if paths:
        k, t = np.divmod(np.concatenate([path.corner for path in paths]), alpha.shape[1])
        ratio = _log_sines(alpha[(k + 2) % 3, t]) - _log_sines(alpha[(k + 1) % 3, t])
        start = np.cumsum([0, *(len(path.corner) for path in paths[:-1])])
        drawn = np.add.reduceat(ratio + 1j * alpha[k, t], start)
    return Residual(
        vertex=constraints.target_at(log_ratio) - constraints.sum_at_rows(total),  # eq. 5
        wheel=constraints.sum_at_wheels(log_ratio),  # eq. 8-10
        triangle=triangle,  # eq. 6
        turning=turning,
        log_ratio=log_ratio,
        holonomy=holonomy_residual(topology, turning, log_ratio, paths, drawn),
    )
