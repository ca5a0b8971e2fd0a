"""Three obtuse triangles
======================

Figure 4 of the paper shows three triangles around a vertex with an angle deficit of 4.56.

Because the deficit is so large, linear ABF uses the exponential map of section 4.2. LSCM and DNCP flip a
triangle for every choice of two pinned boundary vertices. The map of linear ABF is valid and agrees with the
map of ABF.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np

from igl_linabf import ABF, LinABF, flatten
from igl_linabf.io import replacing
from igl_linabf.plot import fit, plot_compare

F = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1]])
SPOKES = (0.72, 1.0, 0.71)  # lengths of the three edges at the middle vertex
BETWEEN = (0.631, 0.616)  # angles between the first and the second edge, and between the second and the third
DEFICIT = 4.56


def obtuse() -> np.ndarray:
    """Return four vertices: the middle one, and the ends of three spokes with the given deficit."""
    a, b = BETWEEN
    c = 2 * np.pi - DEFICIT - a - b
    x, y = np.cos(c), (np.cos(b) - np.cos(a) * np.cos(c)) / np.sin(a)
    directions = np.array([[1, 0, 0], [np.cos(a), np.sin(a), 0], [x, y, np.sqrt(1 - x**2 - y**2)]])
    return np.vstack((np.zeros(3), directions * np.array(SPOKES)[:, None]))


if __name__ == "__main__":
    V = obtuse()
    maps = {}
    for method in ("lscm", "dncp", "scp"):
        flips = []
        for pair in combinations((1, 2, 3), 2):
            pinned = flatten(V, F, pair, [[0, 0], [1, 0]], method=method)
            flips.append(len(pinned.flipped))
        print(f"{method:8} flipped triangles with each pair of pins: {flips}")
        assert min(flips) > 0
        maps[method] = flatten(V, F, method=method).uv
    abf = flatten(V, F, method=ABF(tol=1e-10))
    for label, result in (("linABF", flatten(V, F, method=LinABF(iterations=1))), ("ABF", abf)):
        uv = fit(result.uv, abf.uv)
        distance = np.linalg.norm(uv - abf.uv, axis=1).max() / np.ptp(abf.uv, axis=0).max()
        angle = np.degrees(np.abs(result.angles - abf.angles).max())
        print(
            f"{label:8} flipped triangles: {len(result.flipped)}; from ABF at most {angle:.2f} degrees "
            f"and {distance:.1e} of the map's size; {result.report.iterations} iterations"
        )
        assert len(result.flipped) == 0
        assert distance < 1e-3
        maps[label] = result.uv
    for name, threshold in (("with", 1.0), ("without", 7.0)):
        step = flatten(V, F, method=LinABF(iterations=1, threshold=threshold))
        residual = step.after.vertex
        print(f"{name} the exponential map, residual of the {DEFICIT} rad after one step: {residual:.1e}")
        assert (residual < 1e-4) if name == "with" else (residual > 0.5)
    Path("out").mkdir(exist_ok=True)
    with replacing("out/obtuse.png") as temporary:
        plot_compare(V, F, maps, frequency=12, off_screen=True, screenshot=temporary).close()
    print("wrote out/obtuse.png")
