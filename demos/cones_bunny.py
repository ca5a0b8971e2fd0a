"""
A weave across the seam
=======================

The closed Stanford bunny is flattened twice along the same seam.

On the left, the curvature is concentrated at cones whose angles are multiples of 90 degrees. The two sides of
each seam edge then have the same length in the map. They differ by a rotation by a multiple of 90 degrees and
by a shift of whole periods of the woven texture. Therefore each thread continues across the seam.

On the right, the boundary is free, the default of `flatten`. There the threads of the two sides meet at
arbitrary angles.

Spheres mark the cones, and the two sides of a seam have the same colour in the map. The close-ups show the
same part of the seam, without lines on it::

    python demos/cones_bunny.py [MESH]
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from stretch import bunny

from igl_linabf import Atlas, Cones, unwrap
from igl_linabf.charts import find_cones
from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import plot_checkerboard, plot_uv

LOOK = np.array([-0.1, 0.5, -0.85])  # view direction of the camera, down on the back
PERIOD = 1 / 90  # width of two threads, as a share of the side of the page


def make_weave(pixels: int = 64) -> pv.Texture:
    """Return a texture of two by two woven threads that does not change when turned by 90 degrees."""
    at = (np.arange(2 * pixels) + 0.5) / pixels
    thread = np.floor(at).astype(int)
    bulge = np.sin(np.pi * (at % 1)) ** 0.5  # brightness across a thread
    above = (thread[:, None] + thread) % 2 == 0  # where the horizontal thread lies on top
    shade = np.where(above, bulge[:, None], bulge)
    dark, light = np.array([110, 45, 20]), np.array([250, 225, 185])
    texture = pv.Texture((dark + (light - dark) * shade[..., None] ** 2).astype(np.uint8))
    texture.repeat = texture.interpolate = texture.mipmap = True
    return texture


def count_threads(atlas: Atlas, reference: Atlas) -> float:
    """Return the number of threads along the longer side of a map, for the thread width of `reference`."""
    return float(2 / PERIOD * np.ptp(atlas.TC, axis=0).max() * reference.report.scale / atlas.report.scale)


def rotation_error(atlas: Atlas) -> float:
    """Return the largest deviation of the rotation across a seam edge from a multiple of 90 degrees."""
    corner, F = atlas.FTC, atlas.origin[atlas.FTC]
    side = np.roll(atlas.TC[corner], -1, axis=1) - atlas.TC[corner]
    angle = np.arctan2(side[..., 1], side[..., 0])
    ends = zip(F.ravel().tolist(), np.roll(F, -1, axis=1).ravel().tolist(), strict=True)
    angle_of_edge = dict(zip(ends, angle.ravel().tolist(), strict=True))
    quarter_turns = np.array(
        [(angle_of_edge[i, j] - angle_of_edge[j, i]) / (np.pi / 2) for i, j in atlas.seams.tolist()]
    )
    return float(90 * np.abs(quarter_turns - np.round(quarter_turns)).max())


def find_close_up(V: np.ndarray, F: np.ndarray, atlas: Atlas) -> tuple[np.ndarray, np.ndarray]:
    """Return a seam vertex that faces the camera far from all cones, and its normal."""
    normal = igl.per_vertex_normals(V, F)
    candidates = np.unique(atlas.seams)
    candidates = candidates[normal[candidates] @ LOOK < -0.8]
    distance = np.linalg.norm(V[candidates][:, None] - V[atlas.report.cones], axis=2).min(axis=1)
    chosen = candidates[np.argmax(distance)]
    return V[chosen], normal[chosen]


if __name__ == "__main__":
    V, F = read_mesh(sys.argv[1]) if len(sys.argv) > 1 else bunny()
    cones = find_cones(V, F)
    matched = unwrap(V, F, cones=Cones(cones, angles="quarter", period=PERIOD))
    free = unwrap(V, F, matched.seams)
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(3, 2), off_screen=True, window_size=[1500, 2100], border=False)
    for column, (name, atlas) in enumerate({"quarter cones": matched, "free boundary": free}.items()):
        caption = f"{name}: the sides of seams differ by {np.expm1(atlas.report.seam_mismatch):.1%} in length"
        caption += f" and {rotation_error(atlas):.2g} degrees\nF/3nt {atlas.quality.angle_distortion:.2e}"
        caption += f", L2 stretch {atlas.quality.stretch_l2:.3g}, {len(atlas.report.cones)} cones"
        print(caption)
        options = {"texture": make_weave(), "frequency": count_threads(atlas, matched), "plotter": plotter}
        plotter.subplot(0, column)
        plot_checkerboard(V, F, atlas, seams=None if column == 0 else [], **options)
        plotter.view_vector((0.2, -1, 0.2), viewup=(0, 0, 1))
        plotter.add_text(caption, font_size=10)
        plotter.subplot(1, column)
        plot_checkerboard(V, F, atlas, seams=[], **options)
        at, normal = find_close_up(V, F, matched)
        plotter.camera_position = [at + 0.3 * np.ptp(V, axis=0).max() * normal, at, (0, 0, 1)]
        plotter.camera.clipping_range = (1e-3 * np.ptp(V), 10 * np.ptp(V))
        plotter.subplot(2, column)
        plot_uv(atlas, atlas.FTC, **options)
    if len(sys.argv) == 1:
        assert matched.good
        assert matched.report.seam_mismatch < 1e-6 and rotation_error(matched) < 1e-4
        assert free.report.seam_mismatch > 0.03 and rotation_error(free) > 20
    Path("out").mkdir(exist_ok=True)
    with replacing("out/cones_bunny.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/cones_bunny.png")
