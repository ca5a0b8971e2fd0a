"""Hidden seams
============

Unwrap a machine part along its creases, and a figure along seams on its far side::

    python demos/hidden_seams.py

The nut consists of planar faces, a hole, and slivers between them. It is cut along its creases and laid flat
in one piece, with little distortion.

The bunny is unwrapped twice. On the left, the seams (red) may run anywhere. On the right, `hide=` gives the
outward direction of the far side, and the seams stay on that side. Both pictures show the bunny from the
front.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista
from stretch import bunny

from igl_linabf import Atlas, ChartOptions, Packing, unwrap
from igl_linabf.io import read_mesh, replacing

FAR = np.array([0.0, 0.0, -1.0])  # the far side: the camera looks from +z


def to_polydata(V: np.ndarray, F: np.ndarray) -> pyvista.PolyData:
    return pyvista.PolyData(V, np.column_stack((np.full(len(F), 3), F)))


def seam_lines(V: np.ndarray, seams: np.ndarray) -> pyvista.PolyData:
    return pyvista.PolyData(V, lines=np.column_stack((np.full(len(seams), 2), seams)))


def visible_share(V: np.ndarray, F: np.ndarray, atlas: Atlas) -> float:
    """Return the share of the seam length that faces the viewer."""
    normal = to_polydata(V, F).compute_normals(cell_normals=False, split_vertices=False)["Normals"]
    a, b = V[atlas.seams.T]
    length = np.linalg.norm(a - b, axis=1)
    return float(length[normal[atlas.seams].mean(axis=1) @ FAR < 0].sum() / length.sum())


if __name__ == "__main__":
    V, F = read_mesh(Path(pyvista.__file__).parent / "examples" / "nut.ply")
    net = unwrap(V, F, packing=Packing(cut_below=0))
    print(f"nut: {len(net.charts)} charts, L2 stretch {net.quality.stretch_l2:.4f}")
    assert net.good
    assert net.quality.stretch_l2 < 1.03
    assert net.quality.conformal_distortion < 1.05

    plotter = pyvista.Plotter(shape=(2, 2), off_screen=True, window_size=(1200, 1200), border=False)
    plotter.subplot(0, 0)
    looks = {"scalars": net.chart, "cmap": "tab10", "show_scalar_bar": False, "show_edges": True}
    plotter.add_mesh(to_polydata(V, F), **looks)
    plotter.add_mesh(seam_lines(V, net.seams), color="red", line_width=5)
    plotter.subplot(0, 1)
    flat = to_polydata(np.column_stack((net.TC, np.zeros(len(net.TC)))), net.FTC)
    plotter.add_mesh(
        flat, scalars=net.chart, cmap="tab10", show_scalar_bar=False, show_edges=True, lighting=False
    )
    plotter.view_xy()

    V, F = bunny()
    for column, hide in enumerate((None, FAR)):
        atlas = unwrap(V, F, charts=ChartOptions(hide=hide))
        visible = visible_share(V, F, atlas)
        where = "anywhere" if hide is None else "hidden"
        print(f"bunny, seams {where}: {visible:.0%} of them seen, L2 stretch {atlas.quality.stretch_l2:.3f}")
        assert atlas.good
        assert (visible < 0.25) == (hide is not None)
        plotter.subplot(1, column)
        plotter.add_mesh(to_polydata(V, F), color="lightgray", smooth_shading=True)
        plotter.add_mesh(seam_lines(V, atlas.seams), color="red", line_width=5)
        plotter.add_text(f"seams {where}", font_size=14, color="black")
        plotter.camera_position = [V.mean(axis=0) - 3 * np.ptp(V) * FAR, V.mean(axis=0), (0, 1, 0)]
        plotter.reset_camera()
        plotter.camera.zoom(1.4)
    Path("out").mkdir(exist_ok=True)
    with replacing("out/hidden_seams.png") as temporary:
        plotter.show(screenshot=temporary)
    print("wrote out/hidden_seams.png")
