"""Boundaries of a given shape
===========================

Map the face of the Stanford bunny to a circle and to a rectangle, and unroll a sleeve to a rectangle. Both
surfaces are shown beside their maps with a free boundary::

    python demos/boundaries.py [MESH]

The shape only prescribes the sums of the angles at the boundary vertices: 180 degrees along a straight side,
90 degrees at a corner, and the angles of the inscribed polygon on a circle. Each map changes the angles least
among all maps with these sums. The corners of the rectangle are given for the sleeve, so that its seam
becomes two straight sides, as a tailor needs them.
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from stretch import bunny

from igl_linabf import flatten, quality
from igl_linabf.flattening import Flattening
from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import plot_checkerboard, plot_uv
from igl_linabf.surface import split_chords

SHAPES = ("free", "circle", "rectangle")
AHEAD = np.array([-0.5, -0.85, 0.1])  # direction towards which the bunny looks


def face(radius: float = 9.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of the Stanford bunny within `radius` of the tip of its nose."""
    V, F = bunny()
    head = np.flatnonzero(V[:, 2] > 24)
    nose = V[head[np.argmax(V[head] @ AHEAD)]]
    F = F[np.linalg.norm(V[F].mean(axis=1) - nose, axis=1) < radius]
    # a triangle with two boundary edges cannot lie along a straight side
    return split_chords(*igl.remove_unreferenced(V, F)[:2])


def sleeve(around: int = 48, along: int = 60) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Return a bent, tapered tube that is open along its seam, and the four ends of the seam."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, around + 1), np.linspace(0, 1, along + 1))
    radius, bend = 1.2 - 0.5 * v, 1.2 * v**2
    z, x = 4 * v - radius * np.cos(u) * np.sin(bend), 3 * v**2 + radius * np.cos(u) * np.cos(bend)
    V = np.column_stack([part.ravel() for part in (x, radius * np.sin(u), z)])
    i, j = (k.ravel() for k in np.meshgrid(np.arange(along), np.arange(around), indexing="ij"))
    a, b = i * (around + 1) + j, i * (around + 1) + j + 1
    c, d = b + around + 1, a + around + 1
    F = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    last = along * (around + 1)
    return V, F, [0, around, last + around, last]


def shape_error(result: Flattening, loop: np.ndarray) -> float:
    """Return how far a loop is from its circle or upright rectangle, relative to the size of the map."""
    z = result.uv[loop]
    if result.report.boundary == "circle":
        system = np.column_stack((z, np.ones(len(z))))
        centre = np.linalg.lstsq(system, (z**2).sum(axis=1), rcond=None)[0][:2] / 2
        radius = np.linalg.norm(z - centre, axis=1)
        return float(np.ptp(radius) / radius.mean())
    low, high = z.min(axis=0), z.max(axis=0)
    return float(np.minimum(z - low, high - z).min(axis=1).max() / np.linalg.norm(high - low))


def show(
    name: str, V: np.ndarray, F: np.ndarray, corners: list[int] | None = None, look: np.ndarray | None = None
) -> dict[str, Flattening]:
    """Print and draw the maps with a free boundary, on a circle and on a rectangle."""
    results = {}
    for shape in SHAPES:
        chosen = corners if shape == "rectangle" else None
        results[shape] = result = flatten(V, F, boundary=shape, corners=chosen)
        q = quality(V, F, result.uv)
        caption = f"{name}, {shape}: {result.outcome.value}, F/3nt {q.angle_distortion:.2e}"
        print(
            f"{caption}, L2 stretch {q.stretch_l2:.3g}, {q.flips} flipped, {result.report.iterations} solves"
        )
        assert q.flips == 0
    path = Path("out") / f"{name}_shapes.png"
    path.parent.mkdir(exist_ok=True)
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(2, 3), off_screen=True, window_size=[1500, 1000], border=False)
    for i, (shape, result) in enumerate(results.items()):
        plotter.subplot(0, i)
        plot_checkerboard(V, F, result.uv, plotter=plotter)
        plotter.add_text(shape, font_size=12, color="black")
        if look is not None:
            plotter.view_vector(look, viewup=(0, 0, 1))
        plotter.camera.zoom(1.3)
        plotter.subplot(1, i)
        plot_uv(result.uv, F, plotter=plotter)
    with replacing(path) as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print(f"wrote {path}")
    return results


if __name__ == "__main__":
    if len(sys.argv) > 1:
        show(Path(sys.argv[1]).stem, *split_chords(*read_mesh(sys.argv[1])))
    else:
        V, F = face()
        front = show("face", V, F, look=AHEAD)
        W, G, corners = sleeve()
        arm = show("sleeve", W, G, corners)
        for results, faces in ((front, F), (arm, G)):
            for shape in SHAPES[1:]:
                assert shape_error(results[shape], igl.boundary_loop(faces)) < 1e-6
        # the two sides that are sewn together are straight, and the sleeve shrinks only a little
        assert quality(W, G, arm["rectangle"].uv).stretch_l2 < 1.3
