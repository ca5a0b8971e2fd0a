"""
Patterns to cut and join
========================

A lampshade is a cone, so its pattern is true in every length. A bodice is curved both ways, and
sewn of six panels: the two sides of its seams differ a little, and the table says by how much.

Each picture shows the surface with its seams, and beside it what `write_pattern` drew: outlines, numbers on
both sides of each seam, fold lines and the grain. The SVG, DXF and PDF files go to ``out/``::

    python demos/pattern.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista as pv

from igl_linabf import Atlas, unwrap, write_pattern
from igl_linabf.io import replacing
from igl_linabf.patterns import Pattern

Surface = tuple[np.ndarray, np.ndarray]


def around(radius: np.ndarray, height: np.ndarray, sides: int, flat: float = 1.0) -> Surface:
    """Quadrangles of a surface of revolution, `flat` times as deep as wide."""
    angle = np.arange(sides) * 2 * np.pi / sides
    V = np.stack(
        (
            radius[:, None] * np.cos(angle),
            flat * radius[:, None] * np.sin(angle),
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
    """A cone of 22 sides, in millimetres: 300 wide below, 120 above."""
    return around(np.linspace(150, 60, 12), np.linspace(0, 180, 12), 22)


def bodice() -> Surface:
    """From hip to chest, in millimetres; its waist is narrower."""
    height = np.linspace(0, 420, 30)
    return around(150 - 35 * np.sin(np.pi * height / 420) ** 2, height, 48, 0.7)


def panels(V: np.ndarray, sides: int, columns: tuple[int, ...]) -> np.ndarray:
    """Seams from hem to neck at some of the sides."""
    up = np.arange(0, len(V) - sides, sides)
    return np.concatenate([np.column_stack((up + j, up + j + sides)) for j in columns])


def show(plotter: pv.Plotter, row: int, surface: Surface, atlas: Atlas, pattern: Pattern) -> None:
    V, F = surface
    plotter.subplot(row, 0)
    plotter.add_mesh(
        pv.PolyData.from_regular_faces(V, F), color="#e8e2d8", show_edges=True, edge_color="#b0a898"
    )
    seams = np.insert(atlas.seams, 0, 2, axis=1)
    plotter.add_mesh(pv.PolyData(V, lines=seams.ravel()), color="#c02020", line_width=6)
    plotter.view_vector((0.4, -1, 0.5), (0, 0, 1))
    plotter.subplot(row, 1)
    for line in pattern.outlines:
        plotter.add_lines(flat(line), color="black", width=3, connected=True)
    for lines, colour in ((pattern.folds, "#2050c0"), (pattern.grain, "#208040")):
        for line in lines:
            plotter.add_lines(flat(line)[:2], color=colour, width=2)
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


def flat(line: np.ndarray) -> np.ndarray:
    """A closed line in space."""
    closed = np.vstack((line, line[:1]))
    return np.column_stack((closed, np.zeros(len(closed))))


if __name__ == "__main__":
    Path("out").mkdir(exist_ok=True)
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(2, 2), off_screen=True, window_size=[1400, 1200], border=False)
    shade, body = lampshade(), bodice()
    sewn = panels(body[0], 48, (0, 8, 16, 24, 32, 40))  # princess seams beside the side seams
    for row, (name, surface, seams) in enumerate((("lampshade", shade, None), ("bodice", body, sewn))):
        atlas = unwrap(*surface, seams, "isometric")
        for suffix in ("svg", "dxf", "pdf"):
            pattern = write_pattern(f"out/{name}.{suffix}", *surface, atlas, "mm", grain=(0, 0, 1))
        print(f"{name}:\n{pattern}\n")
        assert atlas.good
        assert pattern.error < (1e-6 if name == "lampshade" else 0.12)
        assert all(abs(seam.change) < (1e-6 if name == "lampshade" else 0.05) for seam in pattern.seams)
        show(plotter, row, surface, atlas, pattern)
    with replacing("out/pattern.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/pattern.png, and each pattern as SVG, DXF and PDF")
