"""Input that must be refused, or accepted with a warning; each input has a name.

`python tests/bad_input.py NAME ...` prints for each name how each method ends, as a line of JSON. It runs in
a process of its own, so that a crash is seen: the first name without a line crashed.
"""

from __future__ import annotations

import json
import sys

import numpy as np

# a grid of 4 x 3 vertices and 12 triangles; only vertices 5 and 6 are interior
V = np.array([[i % 4, i // 4, 0.1 * (i % 3)] for i in range(12)], dtype=float)
F = np.array(
    [t for i in (0, 1, 2, 4, 5, 6) for t in ([i, i + 1, i + 4], [i + 1, i + 5, i + 4])], dtype=np.int64
)


def vertex(i: int, value: list[float]) -> np.ndarray:
    changed = V.copy()
    changed[i] = value
    return changed


def face(t: int, value: list[int]) -> np.ndarray:
    changed = F.copy()
    changed[t] = value
    return changed


def tetrahedron() -> np.ndarray:
    return np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def torus(remove: int) -> tuple[np.ndarray, np.ndarray]:
    n = 6
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n)))
    u, v = 2 * np.pi * i / n, 2 * np.pi * j / n
    positions = np.column_stack(
        ((2 + np.cos(v)) * np.cos(u), (2 + np.cos(v)) * np.sin(u), np.sin(v) + 0.1 * np.cos(3 * u))
    )
    corner = [((i + a) % n) + n * ((j + b) % n) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = np.concatenate((np.column_stack(corner[:3]), np.column_stack((corner[0], *corner[2:]))))
    return positions, faces[remove:]


PINS = [[0.0, 0.0], [1.0, 0.0]]

# name: (V, F, pins, pattern of the message, which names the fault and its place)
REFUSED = {
    "no vertices": (np.empty((0, 3)), F, (), r"V has the shape \(0, 3\)"),
    "no faces": (V, np.empty((0, 3), dtype=int), (), r"F has the shape \(0, 3\)"),
    "empty lists": ([], [], (), r"V has the shape \(0,\)"),
    "flat V": (V.ravel(), F, (), r"V has the shape \(36,\)"),
    "V in 2-D": (V[:, :2], F, (), r"\(12, 2\).*column of zeros"),
    "quads": (V, np.zeros((2, 4), dtype=int), (), r"F has the shape \(2, 4\).*triangles"),
    "text": (V, [["a", "b", "c"]], (), "F is not an array of integers"),
    "ragged": (V, [[0, 1], [0, 1, 2]], (), "F is not an array of integers"),
    "complex V": (V + 1j, F, (), "V is not an array of real numbers"),
    "boolean F": (V, F > 3, (), "F is not an array of integers"),
    "fractional F": (V, F + np.where(F == 11, 0.5, 0), (), "faces 11 .*pass integers"),
    "NaN": (vertex(6, [0, np.nan, 0]), F, (), "vertices 6 are NaN"),
    "infinite": (vertex(0, [np.inf, 0, 0]), F, (), "vertices 0 are NaN or infinite"),
    "index too large": (V, face(3, [1, 5, 12]), (), r"faces 3 .*outside 0\.\.11"),
    "index huge": (V, face(3, [1, 5, 2**62]), (), r"faces 3 .*outside 0\.\.11"),
    "index negative": (V, face(3, [1, 5, -1]), (), r"faces 3 .*outside 0\.\.11"),
    "indices from 1": (V, F + 1, (), "subtract 1"),
    "unsigned beyond int64": (V, F.astype(np.uint64) + np.uint64(2**63), (), r"outside 0\.\.11"),
    "vertex twice": (V, face(4, [2, 2, 6]), (), "faces 4 hold a vertex twice"),
    "zero area": (vertex(5, V[6].tolist()), F, (), "faces 3, 8 have zero area"),
    "collinear": (vertex(5, [1.5, 0, 0.15]), F, (), "faces 2 have zero area"),
    "all in one point": (np.ones((12, 3)), F, (), "faces 0, 1, 2, 3, 4, ... .12 in all. have zero area"),
    "opposite orientation": (V, face(5, F[5][::-1].tolist()), (), r"faces \d+ and 5 have opposite orient"),
    "face twice": (V, np.vstack((F, F[4:5])), (), "faces 4, 12 are the same triangle"),
    "non-manifold edge": (
        np.vstack((V, [1.5, 1, 1])),
        np.vstack((F, [5, 6, 12])),
        (),
        r"edges \[.*\] have more than two faces .*12",
    ),
    "bowtie on the boundary": (
        np.vstack((V, [-1.0, 0, 0], [-1, -1, 0])),
        np.vstack((F, [0, 12, 13])),
        (),
        "vertices 0 several fans",
    ),
    "bowtie inside": (
        np.vstack((V, [[1, 1, 2], [2, 1, 2], [1, 2, 2]])),
        np.vstack((F, np.array([5, 12, 13, 14])[tetrahedron()])),
        (),
        "vertices 5 several fans",
    ),
    "two components": (np.vstack((V, V + 9)), np.vstack((F, F + 12)), (), "2 components, of 12, 12 faces"),
    "closed": (V[[0, 1, 4, 9]], tetrahedron(), (), "closed .*genus 0.*unwrap"),
    "closed torus": (*torus(0), (), "closed .*genus 1"),
    "torus with one hole": (*torus(1), (), "1 handle .*characteristic -1"),
    "one pin": (V, F, ([0], PINS[:1]), "pin two or more vertices"),
    "three pins, two positions": (V, F, ([0, 1, 2], PINS), "bc has 2 rows for 3 pins"),
    "no positions": (V, F, ([0, 3], None), "bc is missing"),
    "pin out of range": (V, F, ([0, 12], PINS), r"vertices 12 are not within 0\.\.11"),
    "pin negative": (V, F, ([0, -1], PINS), r"vertices -1 are not within"),
    "pin twice": (V, F, ([3, 3], PINS), "vertex 3 is pinned twice"),
    "pins in one place": (V, F, ([0, 3], [[1, 1], [1, 1]]), "finite positions that are not all the same"),
    "pin at infinity": (V, F, ([0, 3], [[0, 0], [np.inf, 0]]), "finite positions that are not all the same"),
    "pins in 3-D": (V, F, ([0, 3], [[0, 0, 0], [1, 0, 0]]), r"bc has the shape \(2, 3\)"),
    "fractional pins": (V, F, ([0.0, 3.5], PINS), "b is not an array of integers"),
    "pin on no face": (np.vstack((V, [9, 9, 9])), F, ([0, 12], PINS), "pinned vertices 12 belong to no face"),
}

WARNED = {
    "unreferenced at the end": (np.vstack((V, [9, 9, 9])), F, (), "vertices 12 belong to no face"),
    "unreferenced at the start": (np.vstack(([np.nan, 0, 0], V)), F + 1, (), "vertices 0 belong to no face"),
}


def main() -> None:
    from igl_linabf import MeshError, flatten
    from igl_linabf.flattening import METHODS

    for name in sys.argv[1:]:
        positions, faces, pins, _ = {**REFUSED, **WARNED}[name]
        ends = []
        for method in METHODS:
            try:
                uv = flatten(positions, faces, *pins, method=method).uv
                ends.append(
                    f"{method}: a map of {len(uv)}, not a number at {np.flatnonzero(np.isnan(uv[:, 0]))}"
                )
            except MeshError as error:
                ends.append(f"{method}: MeshError: {error}")
        print(json.dumps([name, ends]), flush=True)


if __name__ == "__main__":
    main()
