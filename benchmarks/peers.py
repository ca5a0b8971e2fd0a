"""Functions with the same signature that make atlases with `unwrap` and with other programs."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import igl
import numpy as np

from igl_linabf import Packing, unwrap
from igl_linabf.charts import texture_seams
from igl_linabf.surface import label_face_components

RESOLUTION, PADDING = 1024, 2

SMART = f"""
import bpy, numpy as np, sys, time
data = np.load(sys.argv[1])
bpy.ops.wm.read_factory_settings(use_empty=True)
mesh = bpy.data.meshes.new("m")
mesh.from_pydata(data["V"].tolist(), [], data["F"].tolist())
thing = bpy.data.objects.new("m", mesh)
bpy.context.collection.objects.link(thing)
bpy.context.view_layer.objects.active = thing
thing.select_set(True)
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.select_all(action="SELECT")
start = time.perf_counter()
bpy.ops.uv.smart_project(island_margin={PADDING / RESOLUTION}, margin_method="FRACTION")
seconds = time.perf_counter() - start
bpy.ops.object.mode_set(mode="OBJECT")
uv = np.empty(2 * len(mesh.loops))
mesh.uv_layers.active.data.foreach_get("uv", uv)
corner = np.empty(len(mesh.loops), dtype=np.int64)
mesh.loops.foreach_get("vertex_index", corner)
np.savez(sys.argv[2], uv=uv.reshape(-1, 2), corner=corner, seconds=seconds)
"""


class TexelAtlas(NamedTuple):
    """An atlas: texture coordinates and area of the page, both in texels, and the time in seconds."""

    origin: np.ndarray
    FTC: np.ndarray
    TC: np.ndarray
    page: float
    seconds: float


Maker = Callable[[np.ndarray, np.ndarray], TexelAtlas]


def ours(V: np.ndarray, F: np.ndarray, resolution: int | None = RESOLUTION, **options: object) -> TexelAtlas:
    start = perf_counter()
    atlas = unwrap(V, F, packing=Packing(resolution=resolution, padding=PADDING), **options)
    return TexelAtlas(atlas.origin, atlas.FTC, atlas.TC * RESOLUTION, RESOLUTION**2, perf_counter() - start)


def unwrap_with_xatlas(V: np.ndarray, F: np.ndarray) -> TexelAtlas:
    import xatlas

    atlas, wish = xatlas.Atlas(), xatlas.PackOptions()
    wish.resolution, wish.padding, wish.bilinear = RESOLUTION, PADDING, True
    start = perf_counter()
    atlas.add_mesh(V.astype(np.float32), F.astype(np.uint32))
    atlas.generate(pack_options=wish)
    seconds = perf_counter() - start
    origin, FTC, TC = atlas[0]
    page = np.array([atlas.width, atlas.height])
    return TexelAtlas(origin.astype(np.int64), FTC.astype(np.int64), TC * page, float(page.prod()), seconds)


def unwrap_with_uvunwrap(V: np.ndarray, F: np.ndarray) -> TexelAtlas:
    import uvunwrap

    start = perf_counter()
    mesh = uvunwrap.Mesh(V.astype(np.float32), F.astype(np.uint32).ravel())
    atlas = uvunwrap.generate([mesh], page_size=RESOLUTION, padding=PADDING)
    seconds = perf_counter() - start
    page, result = np.array([atlas.width, atlas.height]), atlas.meshes[0]
    TC, FTC = np.array(result.uv, dtype=float).reshape(-1, 2), np.array(result.indices).reshape(-1, 3)
    origin = np.array(result.xref).astype(np.int64)
    return TexelAtlas(origin, FTC.astype(np.int64), TC * page, float(page.prod()), seconds)


def find_peers_folder() -> Path | None:
    """Return the folder with other programs that IGL_LINABF_PEERS names."""
    folder = os.environ.get("IGL_LINABF_PEERS")
    if folder is None:
        print("IGL_LINABF_PEERS is not set: the programs of that folder are left out", file=sys.stderr)
        return None
    return Path(folder).resolve()


def find_python(folder: Path, environment: str) -> str | None:
    """Return the Python of a virtual environment in a folder, or None if there is none."""
    python = folder / environment / "bin" / "python"
    return str(python) if python.exists() else None


def find_blender_python() -> str | None:
    """Return a Python with bpy: this one, or the one named by BPY_PYTHON."""
    return sys.executable if find_spec("bpy") else os.environ.get("BPY_PYTHON")


def run_script(
    python: str, script: str, V: np.ndarray, F: np.ndarray, timeout: float = 120, **more: np.ndarray
) -> TexelAtlas:
    """Return the atlas that a script makes in another Python, on a page of `RESOLUTION` texels.

    The script reads V, F and the arrays `more` from the file `sys.argv[1]`, and writes uv and the vertex of
    each corner, and its seconds, into the file `sys.argv[2]`.
    """
    with tempfile.TemporaryDirectory() as folder:
        mesh_file, map_file = os.path.join(folder, "in.npz"), os.path.join(folder, "out.npz")
        np.savez(mesh_file, V=V, F=F, **more)
        command = [python, "-c", script, mesh_file, map_file]
        env = os.environ | {"OMP_NUM_THREADS": "1"}
        subprocess.run(command, check=True, capture_output=True, timeout=timeout, cwd=folder, env=env)
        result = np.load(map_file)
    # corners with the same vertex and texture coordinates share a row
    rows = np.column_stack((result["corner"], result["uv"]))
    unique, FTC = np.unique(rows, axis=0, return_inverse=True)
    texels, origin = unique[:, 1:] * RESOLUTION, unique[:, 0].astype(np.int64)
    return TexelAtlas(origin, FTC.reshape(-1, 3), texels, RESOLUTION**2, float(result["seconds"]))


def unwrap_with_blender(V: np.ndarray, F: np.ndarray) -> TexelAtlas:
    """Return the atlas that Blender's Smart UV Project makes."""
    return run_script(str(find_blender_python()), SMART, V, F)


def programs() -> dict[str, Maker]:
    """Return the functions that make atlases, by name: `unwrap` and the installed programs."""
    mine: dict[str, Maker] = {
        "unwrap, linabf": partial(ours, method="linabf"),
        "unwrap, isometric": partial(ours, method="isometric"),
    }
    return mine | peers()


def peers() -> dict[str, Maker]:
    """Return the functions of the other installed programs, by name."""
    found: dict[str, Maker] = {}
    if find_spec("xatlas"):
        found["xatlas"] = unwrap_with_xatlas
    if find_spec("uvunwrap"):
        found["uvunwrap"] = unwrap_with_uvunwrap
    if find_blender_python():
        found["Blender"] = unwrap_with_blender
    return found


def make_charts(FTC: np.ndarray) -> np.ndarray:
    """Return the index of the chart of each face."""
    return np.unique(label_face_components(FTC, int(FTC.max()) + 1), return_inverse=True)[1]


def unmirror(atlas: TexelAtlas) -> tuple[np.ndarray, int, np.ndarray]:
    """Return texture coordinates without mirrored charts, the number of charts, and the flipped faces."""
    chart, areas = make_charts(atlas.FTC), igl.doublearea(atlas.TC, atlas.FTC)
    mirrored = np.bincount(chart, areas) < 0
    TC = atlas.TC.copy()
    TC[np.unique(atlas.FTC[mirrored[chart]]), 0] *= -1
    return TC, len(mirrored), (areas > 0) == mirrored[chart]


def relative_seams(V: np.ndarray, F: np.ndarray, FTC: np.ndarray) -> float:
    """Return the length of the seams divided by the square root of the area."""
    a, b = V[texture_seams(F, FTC).T]
    return float(np.linalg.norm(a - b, axis=1).sum() / np.sqrt(igl.doublearea(V, F).sum() / 2))
