"""Meshes of every kind that are always available: generated, or part of packages that the tests require."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product
from pathlib import Path

import igl
import numpy as np

Surface = tuple[np.ndarray, np.ndarray]


@cache
def hemisphere(shape: str) -> Surface:
    """Return a hemisphere of fsaverage5 (from nilearn): closed "pial_left", or the disk "flat_right"."""
    from nilearn.datasets import fetch_surf_fsaverage
    from nilearn.surface import load_surf_mesh

    fsaverage = fetch_surf_fsaverage("fsaverage5")
    side = shape.split("_")[1]
    V = np.asarray(load_surf_mesh(fsaverage[f"pial_{side}"]).coordinates, dtype=float)
    F = np.asarray(load_surf_mesh(fsaverage[shape]).faces, dtype=np.int64)
    return igl.remove_unreferenced(V, F)[:2]


@cache
def pial() -> Surface:
    """Return the closed left hemisphere, decimated to 3,000 triangles."""
    V, F = igl.qslim(*hemisphere("pial_left"), 3000)[:2]
    return np.asarray(V), np.asarray(F, dtype=np.int64)


def limb() -> Surface:
    """Return the hemisphere, stretched and cut along one path; the scales of its map exceed doubles."""
    from conftest import tree_cut

    V, F = pial()
    return tree_cut(V * [1, 15, 1], F, 2, 1)


def pial_with_holes() -> Surface:
    """Return the cortex of the right hemisphere with three holes."""
    V, F = hemisphere("flat_right")
    inside = np.linalg.norm(V[:, None] - V[[2000, 5000, 8000]], axis=2).min(axis=1)
    return igl.remove_unreferenced(V, F[~(inside < 6)[F].any(axis=1)])[:2]


def ball() -> Surface:
    """Return a rough ball without one triangle, a disk that contains nearly all curvature of the ball."""
    V, F = igl.upsample(*igl.icosahedron(), 3)
    rough = 1 + 0.15 * np.random.default_rng(0).normal(size=len(V))
    return V / np.linalg.norm(V, axis=1)[:, None] * rough[:, None], F[1:]


def tube(length: float = 30.0, around: int = 24) -> Surface:
    """Return a rough tube, closed at one end; the scale of its map falls by a factor of e per radius."""
    side = 2 * np.pi / around
    rows = int(length / side)
    k, i = np.arange(around), np.arange(rows + 1)[:, None]
    z = np.exp(1j * side * k)
    rim = np.stack(np.broadcast_arrays(z.real, z.imag, side * i), axis=2).reshape(-1, 3)
    V = np.vstack((rim, [0, 0, (rows + 1) * side]))
    a = (around * i[:-1] + k).ravel()
    b = (around * i[:-1] + (k + 1) % around).ravel()
    last = around * rows + k
    tip = np.column_stack((last, around * rows + (k + 1) % around, np.full(around, len(V) - 1)))
    F = np.concatenate(
        (np.column_stack((a, b, b + around)), np.column_stack((a, b + around, a + around)), tip)
    )
    return V + 0.08 * np.random.default_rng(0).normal(size=V.shape), F


def load_pyvista_mesh(name: str) -> Surface:
    """Return a mesh of pyvista: a closed "nut" with one handle, or an "ant" of fifteen closed pieces."""
    import pyvista

    from igl_linabf.io import read_mesh

    return read_mesh(Path(pyvista.__file__).parent / "examples" / f"{name}.ply")


def punctured_nut() -> Surface:
    """Return the nut without one triangle."""
    V, F = load_pyvista_mesh("nut")
    return V, F[1:]


def double_torus() -> Surface:
    """Return a closed surface with two handles."""
    from checkerboards import double_torus

    return double_torus()


def crown() -> Surface:
    """Return a crown without its seven tips, a disk with seven holes."""
    from holes import crown_without_tips

    return crown_without_tips()


def cortex() -> Surface:
    from cortex import cortex

    return cortex()[:2]


def quads(n: int = 4) -> Surface:
    """Return a rough cube with n x n quadrangles per side."""
    corners: dict[tuple[int, ...], int] = {}
    F = []
    for axis, end, i, j in product(range(3), (0, n), range(n), range(n)):
        face = []
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
            place = [0, 0, 0]
            place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = end, i + a, j + b
            face.append(corners.setdefault(tuple(place), len(corners)))
        F.append(face if end else face[::-1])
    V = np.array(list(corners), dtype=float)
    return V + np.random.default_rng(0).normal(scale=0.1, size=V.shape), np.array(F)


def torus_of_quads(n: int = 30, m: int = 16) -> Surface:
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    r = 2 + np.cos(v)
    V = np.stack((r * np.cos(u), r * np.sin(u), np.sin(v)), axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    right, up = (i + 1) % n, (j + 1) % m
    return V, np.stack((i * m + j, right * m + j, right * m + up, i * m + up), axis=-1).reshape(-1, 4)


def dual() -> tuple[np.ndarray, list[list[int]]]:
    """Return the dual of a rough ball: twelve pentagons and many hexagons, some of them concave."""
    W, T = igl.upsample(*igl.icosahedron(), 3)
    W /= np.linalg.norm(W, axis=1)[:, None]
    following: list[dict[int, tuple[int, int]]] = [{} for _ in W]
    for t, (x, y, z) in enumerate(T.tolist()):
        for p, q, r in ((x, y, z), (y, z, x), (z, x, y)):
            following[p][q] = r, t
    F = []
    for around in following:
        q, face = next(iter(around)), []
        for _ in around:
            q, t = around[q]
            face.append(t)
        F.append(face)
    V = W[T].mean(axis=1)
    return V * (1 + 0.3 * np.sin(5 * V)), F


MESHES: dict[str, Callable[[], Surface]] = {
    "cortex": cortex,
    "cortex_right": lambda: hemisphere("flat_right"),
    "ball": ball,
    "tube": tube,
    "limb": limb,
    "pial": pial,
    "nut": lambda: load_pyvista_mesh("nut"),
    "ant": lambda: load_pyvista_mesh("ant"),
    "punctured_nut": punctured_nut,
    "double_torus": double_torus,
    "crown": crown,
    "pial_with_holes": pial_with_holes,
}
