"""The constraints on the angles of a mesh with prescribed angle sums (eq. 5, 6, 10), and their residuals.

Around a hole and along a closed path, the edges laid out from the angles have to return to their start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ... import _core
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...surface import Ragged, Topology
from .circles import compute_inscribed_sums, predict_sum_changes
from .patterns import Pattern

SMALLEST_SINE = 1e-75  # replaces the sine of a zero angle, as in the sums of the core


@dataclass(frozen=True, eq=False)
class ClosedPath:
    """A closed path of edges along which scale and direction have to return to their initial values.

    The *left fans* of the path are the corners to its left at its vertices. Over them, the logarithms of the
    ratios of successive edge lengths sum to zero, so that the path starts and ends at the same scale. The
    exterior angles, pi minus the sum of the left fan, sum to `turning`.

    Attributes
    ----------
    corner : (#c,) int64
        The corners of the left fans, numbered k #F + t.
    size : int
        Number of the path's vertices.
    turning : float
        Sum of the exterior angles, radians; NaN if it is free.
    """

    corner: IntArray
    size: int
    turning: float = np.nan


@dataclass(frozen=True, eq=False)
class HolonomyResidual:
    """The closure errors of hole loops and closed paths, laid out from the angles (docs/holes.md).

    Before the loop of a hole is laid out, its exterior angles are shifted evenly to sum to -2 pi, and the
    logarithms of its length ratios to sum to 0. The derivative is the mean over all starting vertices, and
    therefore independent of the start.

    Attributes
    ----------
    gap : (#holes + #paths,) complex128
        For each hole tau: the vector from the start to the end of its loop, divided by the length of the
        loop. For each path: the sum of the logarithms + i (sum of the exterior angles - `turning`).
    site, row : (#L,) int64
        The *sites* of all loops and paths, and the entry of `gap` to which each contributes. Site v is vertex
        v; the sites after the vertices are the paths.
    q : (#L,) complex128
        Derivative of `gap` with respect to log_ratio + i turning at the site. At a vertex of a hole, it is
        the vector from the vertex to the end of the loop, minus its mean over the loop. At a path, it is 1.
    constrained : (#holes + #paths, 2) bool
        Whether the real and the imaginary part of each entry of `gap` have to be zero.
    """

    gap: ComplexArray
    site: IntArray
    row: IntArray
    q: ComplexArray
    constrained: BoolArray

    def restrict_to_paths(self, n: int) -> HolonomyResidual:
        """Return the residual with constraints on the closed paths only: the last `n` entries of `gap`."""
        constrained = self.constrained.copy()
        constrained[: len(constrained) - n] = False
        return replace(self, constrained=constrained)


def compute_holonomy_residual(
    topology: Topology,
    turning: FloatArray,
    log_ratio: FloatArray,
    paths: tuple[ClosedPath, ...] = (),
    fan_sums: ComplexArray | None = None,
) -> HolonomyResidual:
    """Lay out the loops of holes, and compare the scale and turning of paths with their targets.

    Parameters
    ----------
    topology : Topology
    turning, log_ratio : (#V,) float64
        As in `Residual`.
    paths : tuple of ClosedPath
    fan_sums : (#paths,) complex128, optional
        Sum of the logarithms + i angles over the left fans of each path.
    """
    holes = topology.holes
    if not holes and not paths:
        none, nowhere = np.empty(0, dtype=np.complex128), np.empty(0, dtype=np.int64)
        return HolonomyResidual(none, nowhere, nowhere, none, np.empty((0, 2), dtype=bool))
    loops = Ragged.from_sizes([len(loop) for loop in holes])
    site = np.concatenate((*holes, topology.n + np.arange(len(paths))))
    gap, q = _core.loop_gaps(site[: loops.start[-1]], loops.start, turning, log_ratio)
    constrained = np.ones((len(holes) + len(paths), 2), dtype=bool)
    if paths:
        assert fan_sums is not None
        wanted = np.array([path.size * np.pi - path.turning for path in paths])
        constrained[len(holes) :, 1] = ~np.isnan(wanted)
        beyond = np.where(np.isnan(wanted), 0.0, wanted - fan_sums.imag)
        gap = np.concatenate((gap, fan_sums.real + 1j * beyond))
        q = np.append(q, np.ones(len(paths)))
    row = np.repeat(np.arange(len(gap)), np.append(loops.sizes, np.ones(len(paths), dtype=np.int64)))
    return HolonomyResidual(gap, site, row, q, constrained)


@dataclass(frozen=True, eq=False)
class Constraints:
    """The vertex and wheel constraints of a surface (eq. 5 and 10), one of each per row.

    The last rows have a vertex constraint only. On a closed surface, and if all sums of the outer loop are
    prescribed, the constraints of one kind are linearly dependent. One of them is then omitted, because the
    other constraints imply it.

    Attributes
    ----------
    topology : Topology
    row : (#V,) int64
        The virtual-vertex map: the row of the constraints of each vertex. Interior vertices and boundary
        vertices with a prescribed angle sum have their own rows. All vertices of a hole without prescribed
        sums share one row. The row of every other vertex is -1.
    target : (#rows,) float64
        Target angle sum of each row: the prescribed sum of a vertex, or (m + 2) pi around a hole of m
        vertices.
    sums : (#V,) float64
        The prescribed angle sum of each vertex, 2 pi at interior vertices by default; NaN if it is free.
    wheels : int
        Number of leading rows that have a wheel constraint.
    pattern : Pattern
        The graph of the rows.
    paths : tuple of ClosedPath
        Closed paths along which the scale has to return to its initial value. If the turning of a path is
        also prescribed, the path has two constraints, otherwise one.
    circles : tuple of int
        Boundary loops that have to lie on circles. Their sums are the angle sums of the inscribed polygon
        with the lengths given by the current angles; `target` and `sums` use the lengths on the surface.
    """

    topology: Topology
    row: IntArray
    target: FloatArray
    sums: FloatArray
    wheels: int
    pattern: Pattern
    paths: tuple[ClosedPath, ...] = ()
    circles: tuple[int, ...] = ()

    @property
    def n_rows(self) -> int:
        """Number of rows of constraints."""
        return len(self.target)

    @property
    def prescribes_sums(self) -> bool:
        """Whether angle sums other than 2 pi at interior vertices are prescribed."""
        return bool((self.sums[~np.isnan(self.sums)] != 2 * np.pi).any())

    def replace_targets(
        self, sums: FloatArray | None = None, turnings: FloatArray | None = None
    ) -> Constraints:
        """Return the constraints with the same rows, but other angle sums, (#V,), and turnings of paths.

        No row may belong to a hole.
        """
        made, inside = self, self.row >= 0
        if sums is not None:
            target = self.target.copy()
            target[self.row[inside]] = sums[inside]
            made = replace(made, sums=sums, target=target)
        if turnings is not None:
            both = zip(self.paths, turnings.tolist(), strict=True)
            made = replace(made, paths=tuple(replace(path, turning=turning) for path, turning in both))
        return made

    def sum_at_rows(self, values: FloatArray) -> FloatArray:
        """Sum (#V,) values over the vertices of each row."""
        if self._vertex_of_row is not None:
            return values.take(self._vertex_of_row)
        return np.asarray(np.bincount(self.row + 1, weights=values, minlength=self.n_rows + 1)[1:])

    @cached_property
    def _vertex_of_row(self) -> IntArray | None:
        """The vertex of each row; None if a row has several vertices, such as the row of a hole."""
        inside = np.flatnonzero(self.row >= 0)
        if len(inside) != self.n_rows:
            return None
        vertex = np.empty_like(inside)
        vertex[self.row[inside]] = inside
        return vertex

    def target_sums(self, log_ratio: FloatArray) -> FloatArray:
        """Return the target angle sum of each row for loops with the length ratios `log_ratio`, (#V,)."""
        if not self.circles:
            return self.target
        target = self.target.copy()
        for i in self.circles:
            loop = self.topology.loops[i]
            has_row = self.row[loop] >= 0
            target[self.row[loop[has_row]]] = compute_inscribed_sums(log_ratio[loop], i > 0)[has_row]
        return target

    def predict_residual(self, b: Residual) -> Residual:
        """Return the residual for the angle sums that are predicted on circles after the next step."""
        if not self.circles:
            return b
        vertex = b.vertex.copy()
        for i in self.circles:
            loop = self.topology.loops[i]
            has_row = self.row[loop] >= 0
            change = predict_sum_changes(b.log_ratio[loop], b.turning[loop], i > 0)[has_row]
            vertex[self.row[loop[has_row]]] += change
        return replace(b, vertex=vertex)


def build_constraints(
    topology: Topology,
    sums: FloatArray | None = None,
    paths: Sequence[ClosedPath] = (),
    circles: Sequence[int] = (),
    left_out: int | None = None,
) -> Constraints:
    """Build the constraints, with a row for each interior vertex, hole (virtual vertex) and prescribed sum.

    Around a hole of m vertices, the angles sum to (m + 2) pi; an interior vertex is the case m = 0. A hole
    with prescribed sums at some of its vertices is a closed path instead of a virtual vertex: it turns by -2
    pi and returns to its scale.

    Parameters
    ----------
    topology : Topology
        Topology of a connected surface, which may be closed and may have handles.
    sums : (#V,) float64, optional
        Angle sum at each vertex, radians. NaN means 2 pi at interior vertices, and free at the boundary.
    paths : sequence of ClosedPath
        Further paths that have to close.
    circles : sequence of int
        Loops on circles; the sums at all of their vertices are given.
    left_out : int, optional
        On a closed surface, the vertex whose rows are omitted; by default the vertex of largest curvature.
    """
    if sums is None and not paths:
        return topology.compute_once("constraints", partial(_make_constraints, topology))
    return _make_constraints(topology, sums, paths, circles, left_out)


def _make_constraints(
    topology: Topology,
    sums: FloatArray | None = None,
    paths: Sequence[ClosedPath] = (),
    circles: Sequence[int] = (),
    ground: int | None = None,
) -> Constraints:
    inside = topology.is_interior
    sums = np.full(topology.n, np.nan) if sums is None else sums
    sums = np.where(inside & np.isnan(sums), 2 * np.pi, sums)
    given = ~np.isnan(sums)
    virtual: list[IntArray] = []
    around: list[ClosedPath] = []
    for loop in topology.holes:
        if given[loop].any():
            around.append(_find_path_around_hole(topology, loop, given))
        else:
            virtual.append(loop)
    left_out = np.zeros(topology.n, dtype=bool)
    if not topology.loops:
        # one vertex is redundant: wheel constraints sum to 0, vertex constraints to the sum of all angles
        left_out[np.argmax(np.abs(sums - 2 * np.pi)) if ground is None else ground] = True
    elif given[topology.loops[0]].all() and topology.n_outer == 1:
        # one vertex is redundant: the angle sums of vertices add up to the sum of all angles (Gauss-Bonnet)
        left_out[topology.loops[0][0]] = True
    inner, rim = inside & ~left_out, given & ~inside & ~left_out
    row = np.where(inner, np.cumsum(inner) - 1, -1)
    n_inner = int(np.count_nonzero(inner))
    wheels = n_inner + len(virtual)
    target = np.full(wheels, 2 * np.pi)
    target[:n_inner] = sums[inner]
    for i, loop in enumerate(virtual, n_inner):
        row[loop] = i
        target[i] += np.pi * len(loop)
    row[rim] = wheels + np.arange(np.count_nonzero(rim))
    target = np.concatenate((target, sums[rim]))
    pattern = Pattern(topology, row, len(target))
    return Constraints(topology, row, target, sums, wheels, pattern, (*around, *paths), tuple(circles))


def _find_path_around_hole(topology: Topology, loop: IntArray, given: BoolArray) -> ClosedPath:
    """Return the closed path along the loop of a hole; its turning is free if all sums are prescribed."""
    on_loop = np.zeros(topology.n, dtype=bool)
    on_loop[loop] = True
    turning = np.nan if given[loop].all() else -2 * np.pi
    return ClosedPath(np.flatnonzero(on_loop[topology.corner].ravel()), len(loop), turning)


@dataclass(frozen=True, eq=False)
class Residual:
    """The residuals of the constraints: the right-hand sides b of eq. 5, 6 and 10.

    Attributes
    ----------
    vertex, wheel : (#rows,) float64
        target - sum alpha, and sum log sin(gamma) - log sin(beta).
    triangle : (#F,) float64
        pi - sum alpha.
    turning, log_ratio : (#V,) float64
        At a vertex of a boundary loop with the mesh on its left: the exterior angle, and the logarithm of the
        ratio of the length of the next edge to the length of the previous edge.
    holonomy : HolonomyResidual
        Closure errors of the loops of holes and of the closed paths.
    """

    vertex: FloatArray
    wheel: FloatArray
    triangle: FloatArray
    turning: FloatArray
    log_ratio: FloatArray
    holonomy: HolonomyResidual

    @cached_property
    def max_magnitude(self) -> float:
        """Largest absolute value of all residuals: radians, logarithms, and closure errors."""
        return max(self.max_magnitude_without_holonomy, largest_magnitude(np.abs(self.holonomy.gap)))

    @cached_property
    def max_magnitude_without_holonomy(self) -> float:
        """Largest absolute residual of the vertex, wheel and triangle constraints."""
        families = (self.vertex, self.wheel, self.triangle)
        return max(map(largest_magnitude, families))


def largest_magnitude(values: FloatArray) -> float:
    """Return the largest absolute value, or 0 for an empty array."""
    return float(max(values.max(initial=0.0), -values.min(initial=0.0)))  # avoids an array of absolute values


def residual(constraints: Constraints, alpha: FloatArray, cot: FloatArray | None = None) -> Residual:
    """Return the residuals of the constraints at `alpha`, (3, #F) radians; `cot` are the cotangents."""
    topology, paths = constraints.topology, constraints.paths
    cot = _core.cotangents(alpha) if cot is None else cot
    total, log_ratio = _core.angle_sums(topology.corner, alpha, cot, topology.n)  # eq. 7: logarithms of sines
    turning, triangle = np.pi - total, alpha.sum(axis=0)
    np.subtract(np.pi, triangle, out=triangle)
    fan_sums = None
    if paths:
        k, t = np.divmod(np.concatenate([path.corner for path in paths]), alpha.shape[1])
        sine = np.abs(np.sin(alpha[[(k + 2) % 3, (k + 1) % 3], t]))
        right, left = np.log(np.maximum(sine, SMALLEST_SINE))
        start = np.cumsum([0, *(len(path.corner) for path in paths[:-1])])
        fan_sums = np.add.reduceat(right - left + 1j * alpha[k, t], start)
    wheel = constraints.sum_at_rows(log_ratio)  # residual of eq. 8-10
    wheel[constraints.wheels :] = 0.0
    return Residual(
        vertex=constraints.target_sums(log_ratio) - constraints.sum_at_rows(total),  # residual of eq. 5
        wheel=wheel,
        triangle=triangle,  # residual of eq. 6
        turning=turning,
        log_ratio=log_ratio,
        holonomy=compute_holonomy_residual(topology, turning, log_ratio, paths, fan_sums),
    )
