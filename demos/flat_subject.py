"""Flattening a FreeSurfer subject
===============================

Flatten both hemispheres of a FreeSurfer subject, starting from its folder.

The subject is fsaverage5. Its surfaces are part of the nilearn package, and are written under the names that
FreeSurfer gives them. The left column shows the new maps. The right column shows the flat maps that are
distributed with fsaverage5: experts made the cuts, and FreeSurfer flattened the surfaces. Sulci are dark.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import nibabel.freesurfer as freesurfer
import numpy as np
import pyvista as pv
from nilearn.datasets import fetch_surf_fsaverage
from nilearn.surface import load_surf_mesh

from igl_linabf.cortex import compute_mean_curvatures, flatten_hemispheres, write_hemisphere
from igl_linabf.measures import distance_error
from igl_linabf.plot import plot_uv

OUT = Path("out/flat_subject")
SIDES = {"lh": "left", "rh": "right"}


def write_subject(folder: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Write the folder of fsaverage5; return its flat maps by FreeSurfer, (#V, 2), and their faces."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "surf").mkdir(parents=True)
    shipped, flat = fetch_surf_fsaverage("fsaverage5"), {}
    for hemisphere, side in SIDES.items():
        for name, key in (("white", "white"), ("pial", "pial"), ("sphere.reg", "sphere")):
            mesh = load_surf_mesh(shipped[f"{key}_{side}"])
            freesurfer.write_geometry(folder / "surf" / f"{hemisphere}.{name}", mesh.coordinates, mesh.faces)
        mesh = load_surf_mesh(shipped[f"flat_{side}"])
        flat[hemisphere] = np.asarray(mesh.coordinates, float)[:, :2], np.asarray(mesh.faces, np.int64)
    return flat


if __name__ == "__main__":
    freesurfer_maps = write_subject(OUT / "fsaverage5")
    flat_hemispheres = flatten_hemispheres(OUT / "fsaverage5")
    plotter = pv.Plotter(shape=(2, 2), off_screen=True, window_size=[1400, 1200], border=False)
    for row, flat in enumerate(flat_hemispheres):
        write_hemisphere(OUT, flat)
        V, name = flat.hemisphere.V, flat.hemisphere.name
        folds = compute_mean_curvatures(V, flat.hemisphere.F)
        uv, F = freesurfer_maps[name]
        errors = flat.quality.distance_error, distance_error(V, F, uv)
        for column, (title, map_, faces) in enumerate(
            (("igl_linabf", flat.uv, flat.F), ("FreeSurfer", uv, F))
        ):
            plotter.subplot(row, column)
            used = np.unique(faces)
            shade = np.full(len(V), np.nan)
            shade[used] = np.where(folds[used] < 0, 0.35, 0.75)
            colours = {"cmap": "gray", "clim": (0, 1), "show_scalar_bar": False}
            plot_uv(map_, faces, scalars=shade, plotter=plotter, **colours)
            plotter.add_text(f"{title}, {name}: distance error {100 * errors[column]:.1f} %", font_size=10)
        print(f"{name}: distance error {errors[0]:.3f}, of the shipped map {errors[1]:.3f}; {flat.left_out}")
        assert flat.quality.flips == flat.quality.overlaps == 0
        assert len(flat.cuts.paths) == 5
        assert errors[0] < errors[1]
    plotter.show(screenshot=OUT / "hemispheres.png")
