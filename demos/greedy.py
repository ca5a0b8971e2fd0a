"""Greedy against least-squares layout
===================================

Section 5 of the paper: both layouts of the same angles, on a large mesh::

    python demos/greedy.py [MESH]

The default mesh is the cortex with every triangle split into sixteen (298,464 triangles). After one
linear step the angles are not quite those of a flat mesh. Greedy layout accumulates these errors along
its tree of triangles: the farther from the seed, the farther its map is from the least-squares map.
After convergence both maps agree.
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
from cortex import cortex
from scipy import sparse
from scipy.sparse import csgraph

from igl_linabf import LinABF, flatten, layout, quality
from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import fit, plot_compare

BANDS = 5


def depths(F: np.ndarray, seed: int) -> np.ndarray:
    """Number of edges to cross from face `seed` to each face."""
    beside, _ = igl.triangle_triangle_adjacency(F)
    t, k = np.nonzero(beside >= 0)
    graph = sparse.csr_array((np.ones(len(t)), (t, beside[t, k])), shape=(len(F), len(F)))
    return csgraph.shortest_path(graph, indices=seed, unweighted=True).astype(int)


def compare_layouts(V: np.ndarray, F: np.ndarray, iterations: int) -> tuple[np.ndarray, np.ndarray, list]:
    """Both maps, and for bands of distance from the seed: depth, flipped triangles, rms distance."""
    angles = flatten(V, F, LinABF(iterations=iterations)).angles
    greedy, least = (layout(F, angles, method=method) for method in ("greedy", "least-squares"))
    depth = depths(F, int(np.argmax(angles.min(axis=1))))
    greedy = fit(greedy, least)
    away = np.linalg.norm(greedy - least, axis=1)[F].mean(axis=1) / np.ptp(least, axis=0).max()
    flipped = igl.doublearea(np.ascontiguousarray(greedy), F) <= 0
    bands = []
    for part in np.array_split(np.argsort(depth, kind="stable"), BANDS):
        bands.append((depth[part].max(), int(flipped[part].sum()), float(np.sqrt((away[part] ** 2).mean()))))
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
        print("up to this many triangles from the seed: flipped, rms distance of the maps over their size")
        for depth, flips, away in bands:
            print(f"{depth:10}  {flips:6}  {away:.1e}")
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
            assert max(away for *_, away in bands) < 1e-6
    print("\nwrote out/greedy.png")
