"""Synthetic FreeSurfer subjects: fsaverage5 resampled on other meshes, with known correct cuts."""

from __future__ import annotations

from pathlib import Path

import igl
import nibabel.freesurfer as freesurfer
import numpy as np
from nilearn.datasets import fetch_surf_fsaverage
from nilearn.surface import load_surf_mesh

SIDES = {"lh": "left", "rh": "right"}


def fsaverage5(hemisphere: str, *names: str) -> list[np.ndarray]:
    """Return the vertices of surfaces of fsaverage5 ("white", "pial", "sphere"), and their faces."""
    shipped = fetch_surf_fsaverage("fsaverage5")
    meshes = [load_surf_mesh(shipped[f"{name}_{SIDES[hemisphere]}"]) for name in names]
    return [*(np.asarray(mesh.coordinates, float) for mesh in meshes), np.asarray(meshes[0].faces, np.int64)]


def ball(subdivisions: int) -> tuple[np.ndarray, np.ndarray]:
    """Return an icosahedron, subdivided and projected to the unit sphere."""
    V, F = igl.upsample(*igl.icosahedron(), subdivisions)
    return V / np.linalg.norm(V, axis=1)[:, None], np.asarray(F, np.int64)


def made_up_subject(folder: Path, subdivisions: int = 5, hemispheres: tuple[str, ...] = ("lh", "rh")) -> Path:
    """Write a subject: fsaverage5 on a rotated icosphere (163,842 vertices at 7 subdivisions)."""
    (folder / "surf").mkdir(parents=True)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    points, F = ball(subdivisions)
    points = points @ turn.T
    for hemisphere in hemispheres:
        white, pial, sphere, coarse = fsaverage5(hemisphere, "white", "pial", "sphere")
        finer = max(subdivisions - 5, 0)
        for _ in range(finer):
            (white, _), (pial, _), (sphere, finest) = (igl.loop(V, coarse, 1) for V in (white, pial, sphere))
            coarse = np.asarray(finest, np.int64)
        sphere /= np.linalg.norm(sphere, axis=1)[:, None]
        _, face, nearest = igl.point_mesh_squared_distance(points, sphere, coarse)
        weights = igl.barycentric_coordinates(nearest, *(sphere[coarse[face, k]] for k in range(3)))
        for name, V in (("white", white), ("smoothwm", white), ("pial", pial)):
            resampled = np.einsum("nk,nkd->nd", weights, V[coarse[face]])
            freesurfer.write_geometry(folder / "surf" / f"{hemisphere}.{name}", resampled, F)
        freesurfer.write_geometry(folder / "surf" / f"{hemisphere}.sphere.reg", 100 * points, F)
    return folder
