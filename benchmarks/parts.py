"""Hard surfaces: parts with planes, cylinders and cones, and how exactly `unwrap` lays them flat.

    python benchmarks/parts.py [FILE ...]

The parts are made by code (tests/hard_surfaces.py); fandisk is added if IGL_LINABF_MESHES has it, and any
mesh files that are given. xatlas is added if it is installed. Prints Markdown.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from meshes import Mesh, shared
from peers import Made, by_xatlas, charts_of, relative_seams

from igl_linabf import clean, quality, unwrap
from igl_linabf.io import read_mesh

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from hard_surfaces import DEVELOPABLE, ROUNDED, plate_with_holes


def parts(files: list[str]) -> Iterator[Mesh]:
    """Names and meshes."""
    for name, make in (DEVELOPABLE | ROUNDED).items():
        yield name, *make()
    yield "plate with 40 holes", *plate_with_holes(40)
    yield from (mesh for mesh in shared("closed") if mesh[0] == "igl_fandisk")
    for path in files:
        V, F, *_ = clean(*read_mesh(path))
        yield Path(path).stem, V, F


def ours(V: np.ndarray, F: np.ndarray) -> Made:
    atlas = unwrap(V, F)
    return Made(atlas.origin, atlas.FTC, atlas.TC, 1.0, 0.0)


def cells(V: np.ndarray, F: np.ndarray, made: Made) -> list[str]:
    """Charts, seams, L2 stretch and conformal distortion."""
    figures = quality(V[made.origin], made.FTC, made.TC)
    charts = int(charts_of(made.FTC).max()) + 1
    seams = relative_seams(V, F, made.FTC)
    return [f"{charts}", f"{seams:.1f}", f"{figures.stretch_l2:.3f}", f"{figures.conformal_distortion:.3f}"]


def main() -> None:
    warnings.simplefilter("ignore")
    makers = [ours] + [by_xatlas] * bool(find_spec("xatlas"))
    print(
        "Seams: length over the square root of the area. L2 stretch and mean conformal distortion are 1\n"
        "where lengths and angles are kept.\n"
    )
    heads = ["part", "triangles", "charts", "seams", "L2 stretch", "conformal"]
    heads += [f"{head}, xatlas" for head in heads[2:]] * (len(makers) - 1)
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name, V, F in parts(sys.argv[1:]):
        row = [cell for make in makers for cell in cells(V, F, make(V, F))]
        print(f"| {name} | {len(F):,} | {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
