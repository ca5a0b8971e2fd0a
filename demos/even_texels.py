"""
Even texels
===========

The default method of `unwrap` is `"isometric"`. The isometric method and linear ABF need equally few seams.
Linear ABF preserves angles, but the squares of a checkerboard grow and shrink. The isometric map preserves
angles and sizes as well as possible, and no triangle flips.

The models are the Stanford bunny and a closed cortical hemisphere. If xatlas is installed, its atlas is shown
as well: the texels are equally even, but it has 50 to 200 charts instead of one or two.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from nilearn.datasets import fetch_surf_fsaverage
from nilearn.surface import load_surf_mesh
from stretch import bunny

from igl_linabf import quality, unwrap
from igl_linabf.io import replacing
from igl_linabf.plot import plot_checkerboard

Surface = tuple[np.ndarray, np.ndarray]


def decimate(V: np.ndarray, F: np.ndarray, triangles: int) -> Surface:
    """Return the surface with about `triangles` triangles."""
    V, F, *_ = igl.qslim(V, F, triangles)
    return np.asarray(V), np.asarray(F, dtype=np.int64)


def hemisphere() -> Surface:
    """Return the left pial surface of fsaverage5, which is part of the nilearn package."""
    pial = load_surf_mesh(fetch_surf_fsaverage("fsaverage5")["pial_left"])
    return decimate(np.asarray(pial.coordinates, dtype=float), np.asarray(pial.faces, dtype=np.int64), 8000)


MODELS: Mapping[str, tuple[Callable[[], Surface], tuple[float, float, float], tuple[int, int, int]]] = {
    "bunny": (lambda: decimate(*bunny(), 12000), (0.2, -1, 0.2), (0, 0, 1)),
    "hemisphere": (hemisphere, (-1, 0, 0), (0, 0, 1)),
}


def unwrap_with_xatlas(V: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Return positions, faces, map and number of charts of the atlas of xatlas, with no chart mirrored."""
    import xatlas

    packer = xatlas.Atlas()
    packer.add_mesh(V, F)
    packer.generate()
    origin, corners, uv = packer[0]
    corners, uv = corners.astype(np.int64), uv.astype(float)
    chart = igl.vertex_components(corners)
    mirrored = np.bincount(chart[corners[:, 0]], igl.doublearea(uv, corners)) < 0
    uv[mirrored[chart], 0] *= -1
    return V[origin], corners, uv, len(mirrored)


if __name__ == "__main__":
    columns = 3 if find_spec("xatlas") else 2
    with pv.vtk_verbosity("error"):
        size = [500 * columns, 500 * len(MODELS)]
        plotter = pv.Plotter(shape=(len(MODELS), columns), off_screen=True, window_size=size, border=False)
    for i, (name, (surface, view, up)) in enumerate(MODELS.items()):
        V, F = surface()
        atlases = {}
        for method in ("linabf", "isometric"):
            atlas = unwrap(V, F, method=method)
            assert atlas.good
            atlases[method] = V[atlas.origin], atlas.FTC, atlas.TC, len(atlas.charts)
        if columns == 3:
            atlases["xatlas"] = unwrap_with_xatlas(V, F)
        spread = {}
        for k, (method, (points, corners, uv, charts)) in enumerate(atlases.items()):
            measured = quality(points, corners, uv)
            spread[method] = measured.texel_spread
            caption = f"{name}, {method}: texels {measured.texel_spread:.1f} : 1, {charts} charts"
            print(f"{caption}, L2 stretch {measured.stretch_l2:.3f}, {measured.flips} flipped")
            plotter.subplot(i, k)
            # a square covers the same share of the surface in each atlas
            double = igl.doublearea(uv, corners).sum()
            side = np.sqrt(double / 2) / 30
            plot_checkerboard(
                points, corners, uv, frequency=float(np.ptp(uv, axis=0).max() / side), plotter=plotter
            )
            plotter.view_vector(view, viewup=up)
            plotter.camera.zoom(1.2)
            plotter.add_text(caption, font_size=9)
        assert spread["isometric"] < 3 < spread["linabf"] / 2
    Path("out").mkdir(exist_ok=True)
    with replacing("out/even_texels.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/even_texels.png")
