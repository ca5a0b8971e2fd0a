"""Meshes of the benchmarks, from installed packages and the folder IGL_LINABF_MESHES."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
from nilearn.datasets import fetch_surf_fsaverage
from nilearn.surface import load_surf_mesh

from igl_linabf import cut
from igl_linabf.charts import texture_seams
from igl_linabf.io import read_file, read_mesh

sys.path.insert(0, str(Path(__file__).parent.parent / "demos"))
from cortex import cortex
from holes import crown_without_tips
from stretch import bunny

Mesh = tuple[str, np.ndarray, np.ndarray]


def _list_shared_files(*kinds: str) -> Iterator[tuple[str, Path]]:
    """Yield names and paths of the meshes of the given kinds in the folder IGL_LINABF_MESHES."""
    folder = os.environ.get("IGL_LINABF_MESHES")
    if folder is None:
        print("IGL_LINABF_MESHES is not set: using only the meshes of installed packages", file=sys.stderr)
        return
    for kind in kinds:
        for path in sorted(Path(folder).glob(f"{kind}__*")):
            yield path.stem.split("__")[1], path


def load_shared_meshes(*kinds: str) -> Iterator[Mesh]:
    """Yield the meshes of the given kinds in the folder IGL_LINABF_MESHES, with their names."""
    for name, path in _list_shared_files(*kinds):
        yield name, *read_mesh(path)


def load_texture_cuts() -> Iterator[Mesh]:
    """Yield the meshes of the kind `uv` in the folder, cut along the seams of their texture coordinates."""
    for name, path in _list_shared_files("uv"):
        mesh = read_file(path)
        yield name, *cut(mesh.V, mesh.F, texture_seams(mesh.F, mesh.FTC))[:2]


def brain() -> Mesh:
    """Return the cut cortex of the demo."""
    V, F, _ = cortex()
    return "cortex", V, F


def pial() -> Mesh:
    """Return the closed cortex of the demo."""
    surface = load_surf_mesh(fetch_surf_fsaverage("fsaverage5")["pial_left"])
    return "pial", np.asarray(surface.coordinates, dtype=float), np.asarray(surface.faces, dtype=np.int64)


def subdivide(mesh: Mesh, times: int) -> Mesh:
    """Split each triangle into four, `times` times."""
    name, V, F = mesh
    return f"{name}, {4**times} x", *igl.upsample(V, F, times)


def split_triangles(mesh: Mesh, k: int) -> Mesh:
    """Split each triangle into k^2 equal triangles."""
    name, V, F = mesh
    n, m = len(V), len(F)
    tail, head = F[:, [1, 2, 0]].T, F[:, [2, 0, 1]].T  # ends of the side opposite to each corner
    key, side = np.unique(np.minimum(tail, head) * n + np.maximum(tail, head), return_inverse=True)
    side, low, share = side.reshape(3, m), key // n, np.arange(1, k)[:, None] / k
    on_edges = V[low][:, None] * (1 - share) + V[key % n][:, None] * share
    inside = [(i, j) for i in range(1, k) for j in range(1, k - i)]
    weights = np.array([(k - i - j, i, j) for i, j in inside]).reshape(-1, 3) / k
    # at[i, j] is the point i steps towards corner 1 and j steps towards corner 2
    at = np.empty((k + 1, k + 1, m), dtype=np.int64)
    at[0, 0], at[k, 0], at[0, k] = F.T
    for s in range(1, k):
        along = n + side * (k - 1) + np.where(tail == low[side], s, k - s) - 1
        at[k - s, s], at[0, k - s], at[s, 0] = along
    for number, (i, j) in enumerate(inside):
        at[i, j] = n + len(key) * (k - 1) + np.arange(m) * len(inside) + number
    corners = [((i, j), (i + 1, j), (i, j + 1)) for i in range(k) for j in range(k - i)]
    corners += [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i in range(k) for j in range(k - i - 1)]
    faces = np.stack([np.stack([at[i, j] for i, j in three], axis=1) for three in corners], axis=1)
    points = np.concatenate(
        (V, on_edges.reshape(-1, 3), np.einsum("pc,mcx->mpx", weights, V[F]).reshape(-1, 3))
    )
    return name if k == 1 else f"{name}, {k * k} x", points, faces.reshape(-1, 3)


def crown() -> Mesh:
    """Return the crown of the demo, a disk with seven holes."""
    return "crown", *crown_without_tips()


def stanford() -> Mesh:
    """Return the Stanford bunny of the demos."""
    return "bunny", *bunny()
