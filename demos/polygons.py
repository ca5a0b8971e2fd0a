"""
Quadrangles remain quadrangles
==============================

Artists model with quadrangles. Seams run along the edges of the quadrangles, never along the diagonals that
split them into triangles, and a file keeps its faces.

The mesh is a knot made of quadrangles. The pictures show the knot with its seams, and its atlas, whose faces
have four corners, too. The demo writes the knot as OBJ, PLY and GLB, and reads the files back::

    python demos/polygons.py [MESH]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pyvista as pv

from igl_linabf import ChartOptions, unwrap
from igl_linabf.io import MeshFile, read_file, replacing, write_file, write_mesh
from igl_linabf.surface import Polygons


def knot(n: int = 120, m: int = 12, thick: float = 0.45) -> tuple[np.ndarray, np.ndarray]:
    """Return a closed tube of quadrangles around a trefoil knot; it has one handle."""
    t = np.arange(n) * 2 * np.pi / n
    centre = np.stack((np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)), axis=1)
    along = np.roll(centre, -1, axis=0) - np.roll(centre, 1, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    out = np.cross(along, np.cross([0.0, 0, 1], along))
    out /= np.linalg.norm(out, axis=1)[:, None]
    up = np.cross(along, out)
    angle = np.arange(m) * 2 * np.pi / m
    ring = np.cos(angle)[:, None] * out[:, None] + np.sin(angle)[:, None] * up[:, None]
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    right, above = (i + 1) % n, (j + 1) % m
    F = np.column_stack((i * m + j, i * m + above, right * m + above, right * m + j))[:, ::-1]
    return (centre[:, None] + thick * ring).reshape(-1, 3), F


def edges_of(mesh: MeshFile) -> set[tuple[int, int]]:
    """Return the edges of all faces."""
    corners = mesh.polygons.corners
    pairs = np.column_stack((corners, corners[mesh.polygons.next_corner]))
    return set(map(tuple, np.sort(pairs, axis=1).tolist()))


def to_polydata(points: np.ndarray, F: object) -> pv.PolyData:
    """Return polygons as a mesh of pyvista; points of the plane get z = 0."""
    if points.shape[1] == 2:
        points = np.column_stack((points, np.zeros(len(points))))
    polygons = Polygons.from_faces(F)
    return pv.PolyData(points, np.insert(polygons.corners, polygons.starts, polygons.sizes))


if __name__ == "__main__":
    Path("out").mkdir(exist_ok=True)
    if len(sys.argv) > 1:
        mesh = read_file(sys.argv[1])
    else:
        V, F = knot()
        mesh = MeshFile(V, Polygons.from_faces(F))
    atlas = unwrap(mesh.V, mesh.F, charts=ChartOptions(trade=12))
    seams = set(map(tuple, np.sort(atlas.seams, axis=1).tolist()))
    print(atlas)
    print(f"{len(seams)} seam edges, {len(seams - edges_of(mesh))} of them diagonals")
    assert seams <= edges_of(mesh)
    for suffix in ("obj", "ply", "glb"):
        path = f"out/polygons.{suffix}"
        write_file(path, mesh, atlas.TC, atlas.FTC)
        back = read_file(path)
        sizes = np.bincount(back.polygons.sizes)
        print(f"{path}: " + ", ".join(f"{n:,} faces of {k} corners" for k, n in enumerate(sizes) if n))
        assert len(back.polygons) == len(mesh.polygons)
    write_mesh("out/polygons_flat.obj", np.column_stack((atlas.TC, 0 * atlas.TC[:, 0])), atlas.FTC, atlas.TC)
    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
    plotter.subplot(0, 0)
    plotter.add_mesh(to_polydata(mesh.V, mesh.F), color="#d9dde8", show_edges=True, edge_color="#8890a8")
    lines = np.insert(atlas.seams, 0, 2, axis=1).ravel()
    plotter.add_mesh(pv.PolyData(mesh.V, lines=lines), color="#c02020", line_width=7)
    plotter.view_xy()
    plotter.camera.zoom(1.2)
    plotter.subplot(0, 1)
    plotter.add_mesh(to_polydata(atlas.TC, atlas.FTC), color="#d9dde8", show_edges=True, edge_color="#8890a8")
    plotter.view_xy()
    plotter.camera.zoom(1.3)
    with replacing("out/polygons.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/polygons.png")
