"""The boundary layout of a mesh with holes: their loops are drawn from the angles, too."""

import numpy as np

from .._types import ComplexArray, FloatArray, IntArray, Solve
from ..angles import Closure, Constraints
from ..surface import complex_positions, coordinates


def around_holes(
    constraints: Constraints, closure: Closure, outer: ComplexArray, weight: FloatArray, solve: Solve
) -> ComplexArray:
    """Both coordinates harmonic between loops that have the shapes drawn from flat angles.

    The outer loop stays as it is drawn. Each hole's is drawn up to a similarity, z = a_h s + c_h: a_h and c_h
    are those of the least conformal energy. If z_0 has a_h = 0 for all holes, and z_h is the map with the
    outer loop at 0 and the loop of hole h at s_h, both with free c, these are harmonic with the holes as
    vertices, and z = z_0 + sum a_h z_h. The energy 1/2 z^H L z - area(z) is least where

        sum_h (z_g^H L z_h) a_h - 2 area(s_g) a_g = -z_g^H L z_0.

    L z_h sums to zero around a hole, and is zero inside: only the loop of hole g has to do with z_g^H L.

    Parameters
    ----------
    constraints : Constraints
        Each row has its wheel constraint, each hole has a row.
    closure : Closure
        Of the angles.
    outer : (#V,) complex128
        The outer loop's positions, zero elsewhere.
    weight : (#E,) float64
        Of edges in L.
    solve : callable
        L^-1 over the rows, for (#rows, 2).
    """
    topology, row, pattern = constraints.topology, constraints.row, constraints.pattern
    holes, (a, b), (i, j) = len(topology.holes), topology.edges.T, pattern.ends
    shape = np.zeros((topology.n, holes), dtype=np.complex128)
    shape[closure.site, closure.row] = -closure.q  # q leads from a vertex to the loop's end
    near = np.flatnonzero(shape[a].any(axis=1) | shape[b].any(axis=1))
    a, b, i, j, light = a[near], b[near], i[near], j[near], weight[near, None]

    def sums(ends: tuple[IntArray, IntArray], values: ComplexArray, n: int) -> ComplexArray:
        parts = [np.zeros((n + 1, 2 * holes + 2))[:, : 2 * values.shape[1]] for _ in ends]
        for part, end, sign in zip(parts, ends, (1, -1), strict=True):
            np.add.at(part, end, sign * values.view(float))
        return (parts[0] + parts[1])[:n].view(complex)

    pulled = sums((i, j), light * (shape[a] - shape[b]), pattern.n)
    rhs = [pattern.pull(weight, outer), *(-coordinates(column) for column in pulled.T)]
    free = np.column_stack([complex_positions(solve(np.ascontiguousarray(r))) for r in rhs])
    z = np.column_stack((outer, shape)) + np.where(row[:, None] >= 0, free[row], 0.0)
    force = sums((a, b), light * (z[a] - z[b]), topology.n)  # L z, at the holes
    energy = shape.conj().T @ force
    after = np.empty_like(shape)
    for loop in topology.holes:
        after[loop] = shape[np.roll(loop, -1)]
    area = [(shape[loop, h].conj() * after[loop, h]).imag.sum() / 2 for h, loop in enumerate(topology.holes)]
    similar = np.linalg.solve(energy[:, 1:] - 2 * np.diag(area), -energy[:, 0])
    return np.asarray(z[:, 0] + z[:, 1:] @ similar)
