"""Flatten a mesh by linear ABF and by igl.lscm: one table, one picture, one OBJ.

    python demos/compare_lscm.py MESH [FOLDER]

writes MESH's name with .obj (linear ABF's map as texture coordinates) and .png into FOLDER, `out`
by default.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from igl_linabf import MeshError, Quality, flatten, quality
from igl_linabf.io import read_mesh, replacing, unit_square, write_obj
from igl_linabf.plot import plot_compare
from igl_linabf.quality import table


def compare(
    V: np.ndarray, F: np.ndarray, stem: Path, others: Mapping[str, np.ndarray] | None = None
) -> dict[str, Quality]:
    """Print and draw linear ABF, igl.lscm and `others`; returns the qualities by name."""
    results = {"linABF": flatten(V, F), "igl.lscm": flatten(V, F, "lscm")}
    maps = {name: result.uv for name, result in results.items()} | dict(others or {})
    measured = {name: quality(V, F, uv) for name, uv in maps.items()}
    seconds = {name: f"{result.seconds['total']:.3f}" for name, result in results.items()}
    outcome = {name: result.outcome.value for name, result in results.items()}
    print(table(measured, {"seconds, checks included": seconds, "outcome": outcome}))
    stem.parent.mkdir(parents=True, exist_ok=True)
    write_obj(stem.with_suffix(".obj"), V, F, unit_square(maps["linABF"]))
    with replacing(stem.with_suffix(".png")) as temporary:
        plot_compare(V, F, maps, off_screen=True, screenshot=temporary).close()
    print(f"\nwrote {stem.with_suffix('.obj')} and {stem.with_suffix('.png')}")
    return measured


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    try:
        mesh = Path(sys.argv[1])
        compare(*read_mesh(mesh), Path(*sys.argv[2:] or ["out"]) / mesh.stem)
    except (MeshError, OSError) as error:
        sys.exit(str(error))
