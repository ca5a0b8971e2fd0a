"""Draw atlases side by side, on their surfaces, with checkerboards and seams."""

from __future__ import annotations

from typing import NamedTuple

import igl
import numpy as np
import pyvista as pv
from peers import TexelAtlas, relative_seams, unmirror
from PIL import Image

from igl_linabf.charts import texture_seams
from igl_linabf.plot import plot_checkerboard

Vector = tuple[float, float, float]


class Row(NamedTuple):
    """Atlases of one surface by name, the direction to the camera, and the upward direction."""

    V: np.ndarray
    atlases: dict[str, TexelAtlas]
    view: Vector
    up: Vector


def draw_atlases(path: str, rows: list[Row], panel: tuple[int, int] = (700, 700)) -> None:
    """Write a picture of 128 colours with a row for each surface and a column for each atlas.

    `panel` is the width and the height of an atlas in pixels.
    """
    columns = max(len(row.atlases) for row in rows)
    size = [panel[0] * columns, panel[1] * len(rows)]
    plotter = pv.Plotter(shape=(len(rows), columns), off_screen=True, window_size=size, border=False)
    for i, row in enumerate(rows):
        for k, (name, atlas) in enumerate(row.atlases.items()):
            uv, charts, _ = unmirror(atlas)
            plotter.subplot(i, k)
            # squares of the same size relative to the area of each atlas
            side = np.sqrt(igl.doublearea(uv, atlas.FTC).sum() / 2) / 60
            squares = float(np.ptp(uv, axis=0).max() / side)
            plot_checkerboard(row.V[atlas.origin], atlas.FTC, uv, frequency=squares, plotter=plotter)
            F = atlas.origin[atlas.FTC]
            lines = pv.PolyData(row.V, lines=np.insert(texture_seams(F, atlas.FTC), 0, 2, axis=1).ravel())
            plotter.add_mesh(lines, color="crimson", line_width=3)
            plotter.view_vector(row.view, viewup=row.up)
            plotter.camera.zoom(1.3)
            seam, plural = relative_seams(row.V, F, atlas.FTC), "s" * (charts > 1)
            text = f"{name}: {charts} chart{plural}, seams {seam:.1f} times the root of the area"
            plotter.add_text(text, font_size=9)
    pixels = plotter.screenshot(return_img=True)
    plotter.close()
    Image.fromarray(pixels).quantize(128).save(path, optimize=True)
