"""Seams where they do not show
============================

A machine part falls into its net, and a figure is cut on the side that is not seen::

    python demos/hidden_seams.py

The nut has planes, a hole, and slivers between them: cut along its creases, it is laid flat without
distortion. The bunny is unwrapped twice, with seams (red) anywhere and with `hide=`, the direction in which
the far side looks. Both pictures show it from the front.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista
from stretch import bunny

from igl_linabf import Atlas, Seams, unwrap
from igl_linabf.io import read_mesh, replacing

FAR = np.array([0.0, 0.0, -1.0])  # the bunny is seen from +z


def surface(V: np.ndarray, F: np.ndarray) -> pyvista.PolyData:
    return pyvista.PolyData(V, np.column_stack((np.full(len(F), 3), F)))


def seam_lines(V: np.ndarray, seams: np.ndarray) -> pyvista.PolyData:
    return pyvista.PolyData(V, lines=np.column_stack((np.full(len(seams), 2), seams)))


def seen_share(V: np.ndarray, F: np.ndarray, atlas: Atlas) -> float:
    """Share of the seam length that looks at the viewer."""
    normal = surface(V, F).compute_normals(cell_normals=False, split_vertices=False)["Normals"]
    a, b = V[atlas.seams.T]
    length = np.linalg.norm(a - b, axis=1)
    return float(length[normal[atlas.seams].mean(axis=1) @ FAR < 0].sum() / length.sum())


if __name__ == "__main__":
    V, F = read_mesh(Path(pyvista.__file__).parent / "examples" / "nut.ply")
    net = unwrap(V, F)
    print(f"nut: {len(net.charts)} charts, L2 stretch {net.quality.stretch_l2:.4f}")
    assert net.good
    assert net.quality.stretch_l2 < 1.01
    assert net.quality.conformal_distortion < 1.01

    plotter = pyvista.Plotter(shape=(2, 2), off_screen=True, window_size=(1200, 1200), border=False)
    plotter.subplot(0, 0)
    looks = {"scalars": net.chart, "cmap": "tab10", "show_scalar_bar": False, "show_edges": True}
    plotter.add_mesh(surface(V, F), **looks)
    plotter.add_mesh(seam_lines(V, net.seams), color="red", line_width=5)
    plotter.subplot(0, 1)
    flat = surface(np.column_stack((net.TC, np.zeros(len(net.TC)))), net.FTC)
    plotter.add_mesh(
        flat, scalars=net.chart, cmap="tab10", show_scalar_bar=False, show_edges=True, lighting=False
    )
    plotter.view_xy()

    V, F = bunny()
    for column, hide in enumerate((None, FAR)):
        atlas = unwrap(V, F, Seams(hide=hide))
        share = seen_share(V, F, atlas)
        said = "anywhere" if hide is None else "hidden"
        print(f"bunny, seams {said}: {share:.0%} of them seen, L2 stretch {atlas.quality.stretch_l2:.3f}")
        assert atlas.good
        assert (share < 0.25) == (hide is not None)
        plotter.subplot(1, column)
        plotter.add_mesh(surface(V, F), color="lightgray", smooth_shading=True)
        plotter.add_mesh(seam_lines(V, atlas.seams), color="red", line_width=5)
        plotter.add_text(f"seams {said}", font_size=14, color="black")
        plotter.camera_position = [V.mean(axis=0) - 3 * np.ptp(V) * FAR, V.mean(axis=0), (0, 1, 0)]
        plotter.reset_camera()
        plotter.camera.zoom(1.4)
    Path("out").mkdir(exist_ok=True)
    with replacing("out/hidden_seams.png") as temporary:
        plotter.show(screenshot=temporary)
    print("wrote out/hidden_seams.png")
