"""
A weave across the seam
=======================

The Stanford bunny, closed, is flattened twice along one seam. On the left the curvature is left at cones,
whose angles are multiples of 90 degrees. Both sides of each seam edge are then equally long in the map,
turned by a multiple of 90 degrees, and shifted by whole periods of a woven texture: each thread goes on
across the seam, over and under the others. On the right the boundary is free, as `flatten` leaves it: there
the threads meet at any angle.

The cones are spheres, and both sides of the seam have the same colour in the map. The close-ups show the
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

from igl_linabf import Atlas, Cones, find_cones, unwrap
from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import plot_checkerboard, plot_uv

LOOK = np.array([-0.1, 0.5, -0.85])  # of the camera, down on the back
PERIOD = 1 / 90  # of the weave, two threads, as a share of the page's side


def weave(pixels: int = 64) -> pv.Texture:
    """Threads over and under each other, two by two of them; the same when it is turned by 90 degrees."""
    at = (np.arange(2 * pixels) + 0.5) / pixels
    thread = np.floor(at).astype(int)
    bulge = np.sin(np.pi * (at % 1)) ** 0.5  # brightness across a thread
    above = (thread[:, None] + thread) % 2 == 0  # where the horizontal one is
    shade = np.where(above, bulge[:, None], bulge)
    dark, light = np.array([110, 45, 20]), np.array([250, 225, 185])
    texture = pv.Texture((dark + (light - dark) * shade[..., None] ** 2).astype(np.uint8))
    texture.repeat = texture.interpolate = texture.mipmap = True
    return texture


def frequency(atlas: Atlas, like: Atlas) -> float:
    """Threads along the longer side of a map, as wide on the surface as those of another one."""
    return float(2 / PERIOD * np.ptp(atlas.TC, axis=0).max() * like.scale / atlas.scale)


def turned(atlas: Atlas) -> float:
    """By how many degrees the sides of a seam edge are turned off a multiple of 90, at most."""
    corner, F = atlas.FTC, atlas.origin[atlas.FTC]
    side = np.roll(atlas.TC[corner], -1, axis=1) - atlas.TC[corner]
    angle = np.arctan2(side[..., 1], side[..., 0])
    ends = zip(F.ravel().tolist(), np.roll(F, -1, axis=1).ravel().tolist(), strict=True)
    of = dict(zip(ends, angle.ravel().tolist(), strict=True))
    off = np.array([(of[i, j] - of[j, i]) / (np.pi / 2) for i, j in atlas.seams.tolist()])
    return float(90 * np.abs(off - np.round(off)).max())


def close_up(V: np.ndarray, F: np.ndarray, atlas: Atlas) -> tuple[np.ndarray, np.ndarray]:
    """A vertex of the seam that is far from all cones and turned to the camera, and the normal there."""
    normal = igl.per_vertex_normals(V, F)
    there = np.unique(atlas.seams)
    there = there[normal[there] @ LOOK < -0.8]
    away = np.linalg.norm(V[there][:, None] - V[atlas.cones], axis=2).min(axis=1)
    chosen = there[np.argmax(away)]
    return V[chosen], normal[chosen]


if __name__ == "__main__":
    V, F = read_mesh(sys.argv[1]) if len(sys.argv) > 1 else bunny()
    cones = find_cones(V, F)
    matched = unwrap(V, F, cones=Cones(cones, angles="quarter", period=PERIOD))
    free = unwrap(V, F, matched.seams)
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(3, 2), off_screen=True, window_size=[1500, 2100], border=False)
    for column, (name, atlas) in enumerate({"quarter cones": matched, "free boundary": free}.items()):
        said = f"{name}: the sides of seams differ by {np.expm1(atlas.seam_mismatch):.1%} in length"
        said += f" and {turned(atlas):.2g} degrees\nF/3nt {atlas.quality.angle_distortion:.2e}"
        said += f", L2 stretch {atlas.quality.stretch_l2:.3g}, {len(atlas.cones)} cones"
        print(said)
        options = {"texture": weave(), "frequency": frequency(atlas, matched), "plotter": plotter}
        plotter.subplot(0, column)
        plot_checkerboard(V, F, atlas, seams=None if column == 0 else [], **options)
        plotter.view_vector((0.2, -1, 0.2), viewup=(0, 0, 1))
        plotter.add_text(said, font_size=10)
        plotter.subplot(1, column)
        plot_checkerboard(V, F, atlas, seams=[], **options)
        at, normal = close_up(V, F, matched)
        plotter.camera_position = [at + 0.3 * np.ptp(V, axis=0).max() * normal, at, (0, 0, 1)]
        plotter.camera.clipping_range = (1e-3 * np.ptp(V), 10 * np.ptp(V))
        plotter.subplot(2, column)
        plot_uv(atlas, atlas.FTC, **options)
    if len(sys.argv) == 1:
        assert matched.good
        assert matched.seam_mismatch < 1e-6 and turned(matched) < 1e-4
        assert free.seam_mismatch > 0.03 and turned(free) > 20
    Path("out").mkdir(exist_ok=True)
    with replacing("out/cones_bunny.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/cones_bunny.png")
