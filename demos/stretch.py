"""The table of the paper's section 6: stretch of ABF against linear ABF, on horse and dino.

The models are looked up by name under IGL_LINABF_MESHES; one that is not there is said to be
missing. The Stanford bunny, a scan that pymeshfix brings along and repairs, is always there. All
are closed: a tree of shortest paths between far points cuts them open.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
from pymeshfix import MeshFix
from pymeshfix.examples import bunny_scan
from scipy import sparse
from scipy.sparse import csgraph

from igl_linabf import flatten, quality
from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import plot_compare

LEAVES = 6


def tree_cut(V: np.ndarray, F: np.ndarray, leaves: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed surface without handles, cut to a disk along paths from far points to each other."""
    edges = igl.edges(F)
    length = np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1)
    graph = sparse.csr_array((length, edges.T), shape=(len(V), len(V)))

    def from_all(sources: list[int]) -> tuple[np.ndarray, np.ndarray]:
        distance, before, _ = csgraph.dijkstra(
            graph, directed=False, indices=sources, min_only=True, return_predecessors=True
        )
        return distance, before

    tree = [int(np.argmax(from_all([0])[0]))]
    seam = np.zeros((0, 2), dtype=np.int64)
    for _ in range(leaves - 1):
        distance, before = from_all(tree)
        path = [int(np.argmax(distance))]
        while before[path[-1]] >= 0:
            path.append(int(before[path[-1]]))
        seam = np.concatenate((seam, np.column_stack((path[:-1], path[1:]))))
        tree += path[:-1]
    on_seam = {tuple(sorted(edge)) for edge in seam.tolist()}
    mask = [[tuple(sorted((f[k], f[(k + 1) % 3]))) in on_seam for k in range(3)] for f in F.tolist()]
    cut_V, cut_F, *_ = igl.cut_mesh(V, F, np.array(mask, dtype=np.int32))
    return cut_V, cut_F


def models() -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Horse and dino where they are, and the bunny."""
    folder = Path(os.environ.get("IGL_LINABF_MESHES", "."))
    for name in ("horse", "dino"):
        found = sorted(p for p in folder.glob(f"*{name}*") if p.suffix in (".obj", ".off", ".ply"))
        if found:
            yield name, *read_mesh(found[0])
        else:
            print(f"{name}: no such file under IGL_LINABF_MESHES")
    repaired = MeshFix(*read_mesh(bunny_scan))
    repaired.repair()
    yield "bunny", np.asarray(repaired.points, dtype=float), np.asarray(repaired.faces, dtype=np.int64)


if __name__ == "__main__":
    print("L2 stretch, F/3nt, flips")
    for name, V, F in models():
        V, F = tree_cut(V, F, LEAVES)
        maps = {
            "igl.lscm": flatten(V, F, "lscm").uv,
            "linABF, one step": flatten(V, F, iterations=1).uv,
            "linABF": flatten(V, F).uv,
            "ABF": flatten(V, F, "abf").uv,
        }
        measured = {label: quality(V, F, uv) for label, uv in maps.items()}
        print(f"\n{name}, {len(F):,} triangles")
        for label, q in measured.items():
            print(f"{label:16}  {q.stretch_l2:9.4f}  {q.angle_distortion:9.3e}  {q.flips:4}")
        assert measured["linABF"].flips == measured["ABF"].flips == 0
        assert abs(measured["linABF"].stretch_l2 / measured["ABF"].stretch_l2 - 1) < 0.02
        assert measured["ABF"].angle_distortion <= measured["igl.lscm"].angle_distortion
        Path("out").mkdir(exist_ok=True)
        with replacing(f"out/stretch_{name}.png") as temporary:
            plot_compare(V, F, maps, off_screen=True, screenshot=temporary).close()
