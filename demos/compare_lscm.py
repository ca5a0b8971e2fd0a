"""Methods side by side
====================

Flatten a mesh with `igl.lscm`, linear ABF and ABF, and print the quality and the time of each map::

    python demos/compare_lscm.py MESH [FOLDER]

The demo prints two tables and writes two files into FOLDER (default: `out`). Both are named after the mesh:
an OBJ file with the map of linear ABF as texture coordinates, and a PNG picture of all maps.

`igl-linabf compare MESH` prints the first table only.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from igl_linabf import MeshError, compare, quality
from igl_linabf.io import read_mesh, replacing, unit_square, write_obj
from igl_linabf.measures import Quality, format_table
from igl_linabf.plot import plot_compare


def show(
    V: np.ndarray,
    F: np.ndarray,
    stem: Path,
    others: Mapping[str, np.ndarray] | None = None,
    methods: Sequence[str] = ("lscm", "linabf", "abf"),
) -> dict[str, Quality]:
    """Print and draw the maps of several methods and `others`; return the quality of each by name."""
    comparison = compare(V, F, methods)
    maps = comparison.maps | dict(others or {})
    measured = {name: quality(V, F, uv) for name, uv in maps.items()}
    print(f"{comparison}\n\n{format_table(measured)}")
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
        show(*read_mesh(mesh), Path(*sys.argv[2:] or ["out"]) / mesh.stem)
    except (MeshError, OSError) as error:
        sys.exit(str(error))
