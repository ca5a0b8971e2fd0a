"""
Unwrapping a folder of meshes
=============================

`flatten_files` unwraps all meshes of a folder on all cores. A file that cannot be unwrapped gets a row in the
table of results, and the remaining files are still processed.
"""

import csv
import shutil
import tempfile
from pathlib import Path

import pyvista as pv
from pyvista import examples

from igl_linabf.batch import flatten_files
from igl_linabf.io import read_file

if __name__ == "__main__":  # each worker process imports this file
    # Collect three models of pyvista and a damaged file, in place of your folder.
    folder = Path(tempfile.mkdtemp())
    scans, maps = folder / "scans", folder / "maps"
    scans.mkdir()
    for file in (examples.antfile, examples.nutfile, examples.planefile):
        shutil.copy(file, scans)
    (scans / "damaged.ply").write_bytes(Path(examples.antfile).read_bytes()[:2000])

    # Unwrap the meshes, here in one process (default: one process per core). Each outcome is a row of the
    # table.
    flatten_files(scans, maps, method="isometric", format="glb", workers=1, progress=False)
    with open(maps / "results.csv", encoding="utf-8", newline="") as table:
        rows = {Path(row["input"]).stem: row for row in csv.DictReader(table)}
    for name, row in rows.items():
        print(
            name, row["outcome"], row["triangles"], row["charts"], row["stretch"], row["message"], sep=" | "
        )
    good = [name for name, row in rows.items() if row["outcome"] == "valid"]
    assert sorted(good) == ["airplane", "ant", "nut"]
    assert rows["damaged"]["message"]

    # Draw the maps.
    plotter = pv.Plotter(shape=(1, 3), off_screen=True, window_size=[1500, 500], border=False)
    for column, name in enumerate(sorted(good)):
        mesh = read_file(maps / f"{name}.glb")
        plotter.subplot(0, column)
        square = pv.PolyData.from_regular_faces([(*uv, 0) for uv in mesh.TC], mesh.FTC)
        plotter.add_mesh(square, color="#dce4ec", show_edges=True, lighting=False)
        plotter.add_text(f"{name}: {rows[name]['charts']} charts", font_size=14)
        plotter.view_xy()
    Path("out").mkdir(exist_ok=True)
    plotter.show(screenshot="out/folder_of_meshes.png")
    shutil.rmtree(folder)
