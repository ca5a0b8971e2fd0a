"""The meshes of the benchmarks."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
from nilearn.datasets import fetch_surf_fsaverage
from nilearn.surface import load_surf_mesh

from igl_linabf.io import read_mesh

sys.path.insert(0, str(Path(__file__).parent.parent / "demos"))
from cortex import cortex
from holes import crown_without_tips
from stretch import bunny

Mesh = tuple[str, np.ndarray, np.ndarray]


def shared(*kinds: str) -> Iterator[Mesh]:
    """Meshes of these kinds in the folder IGL_LINABF_MESHES, with their names."""
    folder = os.environ.get("IGL_LINABF_MESHES")
    if folder is None:
        print(
            "IGL_LINABF_MESHES is not set: only the meshes that come with packages are used", file=sys.stderr
        )
        return
    for kind in kinds:
        for path in sorted(Path(folder).glob(f"{kind}__*")):
            yield path.stem.split("__")[1], *read_mesh(path)


def brain() -> Mesh:
    """The cortex of the demo."""
    V, F, _ = cortex()
    return "cortex", V, F


def pial() -> Mesh:
    """The closed cortex that it was cut from."""
    surface = load_surf_mesh(fetch_surf_fsaverage("fsaverage5")["pial_left"])
    return "pial", np.asarray(surface.coordinates, dtype=float), np.asarray(surface.faces, dtype=np.int64)


def subdivided(mesh: Mesh, times: int) -> Mesh:
    """Every triangle split into four, `times` times."""
    name, V, F = mesh
    return f"{name}, {4**times} x", *igl.upsample(V, F, times)


def crown() -> Mesh:
    """The demo's disk with seven holes."""
    return "crown", *crown_without_tips()


def stanford() -> Mesh:
    """The Stanford bunny of the demos."""
    return "bunny", *bunny()
