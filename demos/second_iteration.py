"""Why a second iteration
======================

One iteration fails on the one-ring in Figure 5 of the paper, but two iterations succeed.

The one-ring has an obtuse solid angle (10.6 radians around its vertex) and sheared triangles. It was found by
random search, because most such one-rings need only one iteration.

Greedy layout gives each triangle its target angles exactly. After one step, the residual of the nonlinear
wheel constraint is so large that the last triangle flips. Least-squares layout distributes the residual over
all triangles.
"""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np

from igl_linabf import LinABF, flatten
from igl_linabf.io import replacing
from igl_linabf.plot import plot_compare

V = np.array(
    [
        [0, 0, 0],
        [0.121, 0.053, 0.136],
        [0.347, 1, -0.264],
        [-0.011, 0.05, -0.724],
        [-0.038, 0.123, 0.296],
        [-0.064, -0.03, -0.154],
    ]
)
F = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]])

if __name__ == "__main__":
    solid = igl.internal_angles(V, F)[:, 0].sum()
    print(f"angle around the vertex: {solid:.2f} rad")
    print("iterations  wheel residual  flipped, greedy  flipped, least squares")
    maps, flips = {}, []
    for iterations in (1, 2, 3):
        greedy, least = (
            flatten(V, F, method=LinABF(iterations=iterations, layout=layout))
            for layout in ("greedy", "least-squares")
        )
        flips.append((len(greedy.flipped), len(least.flipped)))
        print(f"{iterations:10}  {greedy.after.wheel:14.1e}  {flips[-1][0]:15}  {flips[-1][1]:22}")
        maps[f"iteration {iterations}"] = greedy.uv
    default = flatten(V, F)
    report = default.report
    print(f"by default: {len(default.flipped)} flipped, {report.iterations} solves, {report.layout} layout")
    assert solid > 10
    assert flips == [(1, 0), (0, 0), (0, 0)]
    assert len(default.flipped) == 0
    Path("out").mkdir(exist_ok=True)
    with replacing("out/second_iteration.png") as temporary:
        plot_compare(V, F, maps, frequency=12, off_screen=True, screenshot=temporary).close()
    print("wrote out/second_iteration.png")
