"""Stretch of ABF and linear ABF
=============================

The table in section 6 of the paper lists the stretch of ABF and of linear ABF for the models horse and dino.

The demo searches for these models by name in the folder IGL_LINABF_MESHES, and skips a missing model with a
message. The Stanford bunny is always available: pymeshfix includes the scan and repairs it. All models are
closed. They are cut open along the seams of `find_seams`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pymeshfix import MeshFix
from pymeshfix.examples import bunny_scan

from igl_linabf import LinABF, cut, find_seams, flatten, quality
from igl_linabf.io import read_mesh, replacing
from igl_linabf.plot import plot_compare


def bunny() -> tuple[np.ndarray, np.ndarray]:
    """Return the Stanford bunny, with the holes of the scan filled."""
    repaired = MeshFix(*read_mesh(bunny_scan))
    repaired.repair()
    return np.asarray(repaired.points, dtype=float), np.asarray(repaired.faces, dtype=np.int64)


def models() -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield name, vertices and faces of horse and dino, as far as available, and of the bunny."""
    folder = Path(os.environ.get("IGL_LINABF_MESHES", "."))
    for name in ("horse", "dino"):
        paths = sorted(p for p in folder.glob(f"*{name}*") if p.suffix in (".obj", ".off", ".ply"))
        if paths:
            yield name, *read_mesh(paths[0])
        else:
            print(f"{name}: no such file under IGL_LINABF_MESHES")
    yield "bunny", *bunny()


if __name__ == "__main__":
    print("L2 stretch, F/3nt, flips")
    for name, V, F in models():
        V, F, _ = cut(V, F, find_seams(V, F))
        maps = {
            "igl.lscm": flatten(V, F, method="lscm").uv,
            "linABF, one step": flatten(V, F, method=LinABF(iterations=1)).uv,
            "linABF": flatten(V, F).uv,
            "ABF": flatten(V, F, method="abf").uv,
        }
        qualities = {label: quality(V, F, uv) for label, uv in maps.items()}
        print(f"\n{name}, {len(F):,} triangles")
        for label, q in qualities.items():
            print(f"{label:16}  {q.stretch_l2:9.4f}  {q.angle_distortion:9.3e}  {q.flips:4}")
        assert qualities["linABF"].flips == qualities["ABF"].flips == 0
        assert abs(qualities["linABF"].stretch_l2 / qualities["ABF"].stretch_l2 - 1) < 0.02
        assert qualities["ABF"].angle_distortion <= qualities["igl.lscm"].angle_distortion
        Path("out").mkdir(exist_ok=True)
        with replacing(f"out/stretch_{name}.png") as temporary:
            plot_compare(V, F, maps, off_screen=True, screenshot=temporary).close()
