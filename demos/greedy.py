"""Greedy against least-squares layout
===================================

Section 5 of the paper compares two layouts. Here, both layouts use the same angles of a large mesh::

    python demos/greedy.py [MESH]

The default mesh is the cortex, with each triangle split into sixteen (298,464 triangles). After one linear
step, the angles do not yet fit together exactly in the plane. Greedy layout accumulates these errors along
its tree of triangles. Therefore the distance between its map and the least-squares map grows with the
distance from the seed. After convergence, both maps agree.
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
from cortex import cortex
from scipy import sparse
from scipy.sparse import csgraph

from igl_linabf import LinABF, flatten, quality
from igl_linabf.io import read_mesh, replacing
from igl_linabf.layouts import layout
from igl_linabf.plot import fit, plot_compare

BANDS = 5


def face_depths(F: np.ndarray, seed: int) -> np.ndarray:
    """Return the number of edges between face `seed` and each face."""
    beside, _ = igl.triangle_triangle_adjacency(F)
    t, k = np.nonzero(beside >= 0)
    graph = sparse.csr_array((np.ones(len(t)), (t, beside[t, k])), shape=(len(F), len(F)))
    return csgraph.shortest_path(graph, indices=seed, unweighted=True).astype(int)


def compare_layouts(V: np.ndarray, F: np.ndarray, iterations: int) -> tuple[np.ndarray, np.ndarray, list]:
    """Return both maps, and their depth, flips and rms distance in bands around the seed."""
    angles = flatten(V, F, method=LinABF(iterations=iterations)).angles
    greedy, least = (layout(F, angles, method=method) for method in ("greedy", "least-squares"))
    depth = face_depths(F, int(np.argmax(angles.min(axis=1))))
    greedy = fit(greedy, least)
    apart = np.linalg.norm(greedy - least, axis=1)[F].mean(axis=1) / np.ptp(least, axis=0).max()
    flipped = igl.doublearea(np.ascontiguousarray(greedy), F) <= 0
    bands = []
    for part in np.array_split(np.argsort(depth, kind="stable"), BANDS):
        bands.append((depth[part].max(), int(flipped[part].sum()), float(np.sqrt((apart[part] ** 2).mean()))))
    return greedy, least, bands


if __name__ == "__main__":
    if len(sys.argv) > 1:
        V, F = read_mesh(sys.argv[1])
    else:
        V, F = igl.upsample(*cortex()[:2], 2)
    for iterations in (1, 12):
        greedy, least, bands = compare_layouts(V, F, iterations)
        g, s = quality(V, F, greedy), quality(V, F, least)
        print(f"\n{len(F):,} triangles, {'one step' if iterations == 1 else 'converged'}")
        print(f"greedy: F/3nt {g.angle_distortion:.3g}, {g.flips} flipped", end="; ")
        print(f"least squares: F/3nt {s.angle_distortion:.3g}, {s.flips} flipped")
        print("largest depth from the seed, flipped triangles, rms distance of the maps over their size")
        for depth, flips, distance in bands:
            print(f"{depth:10}  {flips:6}  {distance:.1e}")
        if iterations == 1:
            if len(sys.argv) == 1:
                assert g.flips > s.flips == 0
                assert g.angle_distortion > 2 * s.angle_distortion
                assert bands[-1][1] > bands[0][1]
            Path("out").mkdir(exist_ok=True)
            maps = {"least squares": least, "greedy": greedy}
            with replacing("out/greedy.png") as temporary:
                plot_compare(V, F, maps, off_screen=True, screenshot=temporary).close()
        elif len(sys.argv) == 1:
            assert g.flips == s.flips == 0
            assert max(distance for *_, distance in bands) < 1e-6
    print("\nwrote out/greedy.png")
