"""The paper's full system, as it stands there, to hold the library's reduced one against."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from igl_linabf.linalg import Solvers
from igl_linabf.surface import Topology


def rows(topology: Topology, alpha: np.ndarray) -> sparse.csr_array:
    """Vertex and wheel rows (eq. 5 and 10) on the angle errors, two by two for each row.

    Column 3 t + k is the error at corner k of triangle t.
    """
    entries = []
    for k in range(3):
        vertex = topology.corner[k]
        row = topology.row[vertex]
        inside = row >= 0
        t = np.arange(len(row))
        left, right = (k + 1) % 3, (k + 2) % 3
        entries += [
            (2 * row[inside], (3 * t + k)[inside], np.ones(inside.sum())),
            (2 * row[inside] + 1, (3 * t + left)[inside], 1 / np.tan(alpha[left, inside])),
            (2 * row[inside] + 1, (3 * t + right)[inside], -1 / np.tan(alpha[right, inside])),
        ]
    i, j, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    return sparse.csr_array((values, (i, j)), shape=(2 * len(topology.target), alpha.size))


def right_hand_sides(topology: Topology, alpha: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the vertex and wheel rows, and what the triangle rows (eq. 6), ask for."""
    wanted = np.zeros((len(topology.target), 2))
    wanted[:, 0] = topology.target
    for k in range(3):
        row = topology.row[topology.corner[k]]
        inside = row >= 0
        left, right = alpha[(k + 1) % 3], alpha[(k + 2) % 3]
        np.subtract.at(wanted[:, 0], row[inside], alpha[k, inside])
        np.add.at(wanted[:, 1], row[inside], np.log(np.sin(right[inside]) / np.sin(left[inside])))
    return wanted.ravel(), np.pi - alpha.sum(axis=0)


def full_step(topology: Topology, alpha: np.ndarray) -> np.ndarray:
    """Least norm solution e of A e = b in the weights 1 / alpha, (3, #F): (C C^T) x = b (eq. 16)."""
    m = alpha.shape[1]
    triangles = sparse.kron(sparse.eye_array(m), np.ones((1, 3)))
    A = sparse.vstack((rows(topology, alpha), triangles)).tocsr()
    b = np.concatenate(right_hand_sides(topology, alpha))
    C = A @ sparse.diags_array(alpha.T.ravel())
    whole = (C @ C.T).tocsc()
    lower = sparse.tril(whole).tocsc()
    factor = Solvers("direct").whole(lower)
    factor.factor(lower)
    x = factor.solve(b)
    x += factor.solve(b - whole @ x)  # one refinement: the reference is to be exact
    return (alpha.T.ravel() * (C.T @ x)).reshape(m, 3).T
