"""Take Newton steps for maps that are too large for a factor of their Hessian.

The displacement of the vertices is bilinear in the cells of a grid over the map, and its values at the nodes
of the grid are the unknowns. The energy and its gradient are still summed over all triangles. A conformal map
of a surface with smooth curvature differs from an isometric map only by smooth displacements, which the grid
can represent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core import sum_by_index
from ..._types import ComplexArray, FloatArray, IntArray
from ...linalg import Analysis, Factor, Solvers
from ...surface import Ragged
from .energy import RestTriangles
from .newton import Springs, factor_damped, sum_at_vertices

VERTICES_PER_NODE = 40  # vertices per node of the grid, for a map that fills a rectangle
# Stiffness of springs between the nodes of an empty cell, relative to the mean stiffness of a node.
EMPTY_CELL_STIFFNESS = 1e-2
FACES_AT_ONCE = 200_000  # number of triangles added to the Hessian at once, which bounds the memory


@dataclass(frozen=True, eq=False)
class BilinearWeights:
    """Points in the cells of a grid, for bilinear interpolation from the nodes.

    Attributes
    ----------
    cell : (#P,) int64
        Number of the lower left node of the cell.
    weights : (4, #P) float64
        Bilinear weights of the lower left, lower right, upper left and upper right node.
    """

    cell: IntArray
    weights: FloatArray

    @classmethod
    def locate_points(cls, x: ComplexArray, columns: int, cell: IntArray | None = None) -> BilinearWeights:
        """Locate points, in units of cells, in their cells; with `cell`, extrapolate from these cells."""
        if cell is None:
            cell = x.imag.astype(np.int64) * columns + x.real.astype(np.int64)
        row, column = np.divmod(cell, columns)
        s, t = x.real - column, x.imag - row
        return cls(cell, np.stack(((1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t)))


class CoarseHessians:
    """The Hessian of the energy with respect to bilinear displacements on a grid over the map `start`."""

    def __init__(self, corner: IntArray, start: ComplexArray, solvers: Solvers) -> None:
        self._n = len(start)
        low = complex(start.real.min(), start.imag.min())
        width, height = np.ptp(start.real), np.ptp(start.imag)
        x = (start - low) / np.sqrt(width * height * VERTICES_PER_NODE / len(start))
        self._columns = int(x.real.max()) + 2
        nodes = self._columns * (int(x.imag.max()) + 2)
        self._vertices = BilinearWeights.locate_points(x, self._columns)
        middle = x[corner].mean(axis=0)
        cell = BilinearWeights.locate_points(middle, self._columns).cell
        self._order = np.argsort(cell, kind="stable")
        self._x, self._cell = x, cell
        self._cells = np.unique(np.concatenate((cell, self._vertices.cell)))
        count = np.bincount(np.searchsorted(self._cells, cell), minlength=len(self._cells))
        self._faces = Ragged.from_sizes(count)
        self._number_nodes(nodes, solvers)

    def _number_nodes(self, nodes: int, solvers: Solvers) -> None:
        """Number the nodes of the cells, and analyse the pattern of the Hessian."""
        steps = np.array([0, 1, self._columns, self._columns + 1])
        needed = np.zeros(nodes, dtype=bool)
        needed[self._cells[:, None] + steps] = True
        number = np.cumsum(needed) - 1
        self._nodes = int(number[-1]) + 1
        self._at_vertices = number[self._vertices.cell + steps[:, None]]
        corners = number[self._cells[:, None] + steps]
        self._pairs = [(i, j) for i in range(4) for j in range(i + 1)]
        row, column = corners[:, np.transpose(self._pairs)].swapaxes(0, 1)
        keys = column * self._nodes + row
        found, place = np.unique(keys, return_inverse=True)
        self._place = place.ravel()
        column, row = np.divmod(found, self._nodes)
        indptr = np.searchsorted(column, np.arange(self._nodes + 1))
        self._diagonal = indptr[:-1]
        self._entries = len(found)
        self._analysis: Analysis = solvers.analyse(indptr, row, 2)

    def differentiate(
        self, rest: RestTriangles, z: ComplexArray, weight: float, springs: Springs | None
    ) -> tuple[FloatArray, Factor]:
        """Return the gradient, (2 #V,), and a factor of the Hessian that is restricted to the grid.

        The factor solves for a displacement of all vertices, given a gradient with respect to all vertices.
        """
        if springs is not None:
            raise ValueError("pins are not in the grid: use the Hessian of all vertices")
        slope, sums = np.zeros(2 * self._n), np.empty((len(self._cells), len(self._pairs), 4))
        at_once = max(1, FACES_AT_ONCE * len(self._cells) // len(self._order))
        for first in range(0, len(self._cells), at_once):
            part = slice(first, min(first + at_once, len(self._cells)))
            face = self._order[self._faces.start[part.start] : self._faces.start[part.stop]]
            own = rest.select_faces(face)
            by_corner, rows = own.differentiate(z, weight)
            slope += sum_at_vertices(own.corner, by_corner, self._n)
            sums[part] = self._sum_in_cells(rows, own.corner, self._cell[face], self._faces.sizes[part])
        return slope, self._factor(sums)

    def _factor(self, sums: FloatArray) -> Factor:
        """Factor the Hessian on the grid; its solve turns a gradient into a displacement on the mesh."""
        on_diagonal = np.array([i == j for i, j in self._pairs])
        # springs let nodes of cells with few triangles follow their neighbours
        stiffness = EMPTY_CELL_STIFFNESS * sums[:, on_diagonal][..., [0, 3]].mean()
        empty = np.maximum(1 - self._faces.sizes / np.median(self._faces.sizes), 0)
        sums[..., [0, 3]] += np.multiply.outer(stiffness * empty, np.where(on_diagonal, 3, -1))[..., None]
        blocks = np.column_stack(
            [sum_by_index(self._place, values.ravel(), self._entries) for values in np.moveaxis(sums, 2, 0)]
        )
        coarse = factor_damped(self._analysis, blocks, self._diagonal)
        return Factor(coarse.name, lambda slope: self._prolong(coarse.solve(self._restrict(slope))))

    def _sum_in_cells(
        self, rows: FloatArray, corner: IntArray, cell: IntArray, sizes: IntArray
    ) -> FloatArray:
        """For each cell, sum row row^T over the triangles whose centres are in the cell."""
        within = Ragged.from_sizes(sizes)
        by_corner = rows.reshape(4, 2, 3, -1)
        at_nodes = np.zeros((4, 2, 4, len(cell)))  # row, x or y, node, triangle
        for k in range(3):
            at_nodes += (
                by_corner[:, :, k, None]
                * BilinearWeights.locate_points(self._x[corner[k]], self._columns, cell).weights
            )
        made = np.empty((len(within), len(self._pairs), 4))
        for pair, (i, j) in enumerate(self._pairs):
            for entry in range(4):
                a, b = divmod(entry, 2)
                made[:, pair, entry] = within.sum((at_nodes[:, a, j] * at_nodes[:, b, i]).sum(axis=0))
        return made

    def _restrict(self, slope: FloatArray) -> FloatArray:
        made = np.zeros((self._nodes, 2))
        for node, weight in zip(self._at_vertices, self._vertices.weights, strict=True):
            for axis in (0, 1):
                made[:, axis] += np.bincount(node, weight * slope[axis::2], self._nodes)
        return made.ravel()

    def _prolong(self, x: FloatArray) -> FloatArray:
        made = np.zeros((self._n, 2))
        for node, weight in zip(self._at_vertices, self._vertices.weights, strict=True):
            made += weight[:, None] * x.reshape(-1, 2)[node]
        return made.ravel()
