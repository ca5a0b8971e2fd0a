"""
Patterns for cutting and sewing
===============================

A lampshade is a cone. Therefore all lengths in its pattern are exact. It is made of paper, with a glue tab. A
bodice is curved in both directions and is sewn from six panels, with a seam allowance of 12 mm. The two sides
of each seam differ slightly in length, and a table lists the differences.

Each row shows the surface with its seams, and beside it the drawing of `write_pattern`: outlines, numbers on
both sides of each seam, and the grain. The demo writes SVG, DXF and PDF files to ``out/``::

    python demos/pattern.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista as pv

from igl_linabf import Atlas, unwrap
from igl_linabf.io import replacing
from igl_linabf.patterns import Pattern, write_pattern

Surface = tuple[np.ndarray, np.ndarray]


def revolve(radius: np.ndarray, height: np.ndarray, sides: int, depth: float = 1.0) -> Surface:
    """Return the quadrangles of a surface of revolution that is `depth` times as deep as it is wide."""
    angle = np.arange(sides) * 2 * np.pi / sides
    V = np.stack(
        (
            radius[:, None] * np.cos(angle),
            depth * radius[:, None] * np.sin(angle),
            np.repeat(height[:, None], sides, axis=1),
        ),
        axis=-1,
    ).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(len(radius) - 1), np.arange(sides), indexing="ij"))
    right = (j + 1) % sides
    return V, np.column_stack(
        (i * sides + j, i * sides + right, (i + 1) * sides + right, (i + 1) * sides + j)
    )


def lampshade() -> Surface:
    """Return a cone of 22 sides, 300 mm wide at the bottom and 120 mm at the top."""
    return revolve(np.linspace(150, 60, 12), np.linspace(0, 180, 12), 22)


def bodice() -> Surface:
    """Return a surface from hip to chest with a narrower waist, in millimetres."""
    height = np.linspace(0, 420, 30)
    return revolve(150 - 35 * np.sin(np.pi * height / 420) ** 2, height, 48, 0.7)


def panel_seams(V: np.ndarray, sides: int, columns: tuple[int, ...]) -> np.ndarray:
    """Return seams from hem to neck along some of the sides."""
    up = np.arange(0, len(V) - sides, sides)
    return np.concatenate([np.column_stack((up + j, up + j + sides)) for j in columns])


def show(plotter: pv.Plotter, row: int, surface: Surface, atlas: Atlas, pattern: Pattern) -> None:
    """Draw a surface with its seams, and its pattern beside it."""
    V, F = surface
    plotter.subplot(row, 0)
    plotter.add_mesh(
        pv.PolyData.from_regular_faces(V, F), color="#e8e2d8", show_edges=True, edge_color="#b0a898"
    )
    seams = np.insert(atlas.seams, 0, 2, axis=1)
    plotter.add_mesh(pv.PolyData(V, lines=seams.ravel()), color="#c02020", line_width=6)
    plotter.view_vector((0.4, -1, 0.5), (0, 0, 1))
    plotter.subplot(row, 1)
    for line in pattern.cut_lines:
        plotter.add_lines(close_line(line), color="black", width=3, connected=True)
    for line in pattern.outlines:
        plotter.add_lines(close_line(line), color="#707070", width=1, connected=True)
    for lines, colour in ((pattern.folds, "#2050c0"), (pattern.grain, "#208040")):
        for line in lines:
            plotter.add_lines(close_line(line)[:2], color=colour, width=2)
    marks = [(side[len(side) // 2], seam.number) for seam in pattern.seams for side in seam.sides]
    if marks:
        places, numbers = (np.array(of) for of in zip(*marks, strict=True))
        plotter.add_point_labels(
            np.column_stack((places, 0 * places[:, 0])),
            numbers,
            text_color="#c02020",
            shape=None,
            font_size=26,
            show_points=False,
            always_visible=True,
        )
    plotter.view_xy()
    plotter.camera.zoom(1.3)


def close_line(line: np.ndarray) -> np.ndarray:
    """Return a line of the plane as a closed line in space."""
    closed = np.vstack((line, line[:1]))
    return np.column_stack((closed, np.zeros(len(closed))))


if __name__ == "__main__":
    Path("out").mkdir(exist_ok=True)
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(2, 2), off_screen=True, window_size=[1400, 1200], border=False)
    shade, body = lampshade(), bodice()
    sewn_seams = panel_seams(body[0], 48, (0, 8, 16, 24, 32, 40))  # two side seams and four princess seams
    models = (("lampshade", shade, None, {"tabs": 12.0}), ("bodice", body, sewn_seams, {"allowance": 12.0}))
    for row, (name, surface, seams, finish) in enumerate(models):
        atlas = unwrap(*surface, seams)
        for suffix in ("svg", "dxf", "pdf"):
            pattern = write_pattern(f"out/{name}.{suffix}", *surface, atlas, "mm", grain=(0, 0, 1), **finish)
        print(f"{name}:\n{pattern}\n")
        assert atlas.good
        assert pattern.error < (1e-6 if name == "lampshade" else 0.05)
        assert all(abs(seam.difference) < (1e-6 if name == "lampshade" else 0.05) for seam in pattern.seams)
        show(plotter, row, surface, atlas, pattern)
    with replacing("out/pattern.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/pattern.png, and each pattern as SVG, DXF and PDF")
