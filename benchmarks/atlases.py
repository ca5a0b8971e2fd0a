"""Atlases beside those of other programs: distortion, seams, packing and time.

    python benchmarks/atlases.py [--all]

The meshes are a cortex and those of the kinds closed, handles and multi in IGL_LINABF_MESHES, or of all
sound kinds. xatlas and uvunwrap are
added if they are installed (extra `peers`), and Blender's Smart UV Project if bpy is, here or in the Python
that BPY_PYTHON names. Prints Markdown.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter

import numpy as np
from meshes import shared
from unwrap import components

from igl_linabf import OutcomeWarning, quality, texture_seams, unwrap
from igl_linabf.textures import covered, near_sides

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from carried import pial

RESOLUTION, PADDING = 1024, 2
KINDS = ("closed", "handles", "multi")
ALL = (*KINDS, "holes", "disk", "stress", "flat2d")
Made = tuple[np.ndarray, np.ndarray, np.ndarray, float, float]  # TC in texels, FTC, origin, page, seconds

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


def ours(V: np.ndarray, F: np.ndarray, **options: object) -> Made:
    start = perf_counter()
    atlas = unwrap(V, F, resolution=RESOLUTION, padding=PADDING, **options)
    return atlas.TC * RESOLUTION, atlas.FTC, atlas.origin, RESOLUTION**2, perf_counter() - start


def even(V: np.ndarray, F: np.ndarray) -> Made:
    return ours(V, F, method="isometric")


def by_xatlas(V: np.ndarray, F: np.ndarray) -> Made:
    import xatlas

    atlas, wish = xatlas.Atlas(), xatlas.PackOptions()
    wish.resolution, wish.padding, wish.bilinear = RESOLUTION, PADDING, True
    start = perf_counter()
    atlas.add_mesh(V.astype(np.float32), F.astype(np.uint32))
    atlas.generate(pack_options=wish)
    seconds = perf_counter() - start
    origin, FTC, TC = atlas[0]
    page = np.array([atlas.width, atlas.height])
    return TC * page, FTC.astype(np.int64), origin.astype(np.int64), float(page.prod()), seconds


def by_uvunwrap(V: np.ndarray, F: np.ndarray) -> Made:
    import uvunwrap

    start = perf_counter()
    mesh = uvunwrap.Mesh(V.astype(np.float32), F.astype(np.uint32).ravel())
    atlas = uvunwrap.generate([mesh], page_size=RESOLUTION, padding=PADDING)
    seconds = perf_counter() - start
    page, made = np.array([atlas.width, atlas.height]), atlas.meshes[0]
    uv, FTC = np.array(made.uv, dtype=float).reshape(-1, 2), np.array(made.indices).reshape(-1, 3)
    return uv * page, FTC.astype(np.int64), np.array(made.xref).astype(np.int64), float(page.prod()), seconds


def blender() -> str | None:
    """A Python that has bpy."""
    return sys.executable if find_spec("bpy") else os.environ.get("BPY_PYTHON")


def by_blender(V: np.ndarray, F: np.ndarray) -> Made:
    with tempfile.TemporaryDirectory() as folder:
        there, back = os.path.join(folder, "in.npz"), os.path.join(folder, "out.npz")
        np.savez(there, V=V, F=F)
        command = [str(blender()), "-c", SMART, there, back]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        made = np.load(back)
        # corners of one vertex at one place are one row
        rows = np.column_stack((made["corner"], made["uv"]))
        unique, FTC = np.unique(rows, axis=0, return_inverse=True)
        texels, origin = unique[:, 1:] * RESOLUTION, unique[:, 0].astype(np.int64)
        return texels, FTC.reshape(-1, 3), origin, RESOLUTION**2, float(made["seconds"])


def touching(TC: np.ndarray, FTC: np.ndarray, chart: np.ndarray) -> int:
    """Charts that share a texel of a bilinear lookup with another one."""
    texels = TC[FTC] - 0.5
    inner = covered(texels, RESOLUTION)
    n = len(TC)
    tail, head = FTC, np.roll(FTC, -1, axis=1)
    face, k = np.nonzero(~np.isin(tail * n + head, head * n + tail, kind="sort"))
    near = near_sides(texels[face, k], texels[face, (k + 1) % 3], RESOLUTION)
    index = np.concatenate((inner.index, near.index))
    of = np.concatenate((chart[inner.face], chart[face[near.side]]))
    pairs = np.unique(np.column_stack((index, of)), axis=0)
    several = np.isin(pairs[:, 0], pairs[1:, 0][np.diff(pairs[:, 0]) == 0])
    return len(np.unique(pairs[several, 1]))


def figures(V: np.ndarray, F: np.ndarray, made: Made) -> list[float]:
    """Charts, seams, L2 stretch, spread of texel areas, fill, touching charts, seconds."""
    TC, FTC, origin, page, seconds = made
    keep = np.abs(doubled(TC, FTC)) > 0  # faces that a program leaves out, or that have no area
    _, chart = np.unique(components(FTC[keep]), return_inverse=True)
    solid = doubled_in_space(V, F) > 0
    q = quality(V[origin], FTC[keep & solid], TC)
    a, b = V[texture_seams(F, FTC).T]
    area = doubled_in_space(V, F).sum() / 2
    seams = np.linalg.norm(a - b, axis=1).sum() / np.sqrt(area)
    fill = np.abs(doubled(TC, FTC)).sum() / 2 / page
    touch = touching(TC, FTC[keep], chart)
    return [chart.max() + 1, seams, q.stretch_l2, q.texel_spread, fill, touch, seconds]


def doubled(TC: np.ndarray, FTC: np.ndarray) -> np.ndarray:
    a, b = TC[FTC[:, 1]] - TC[FTC[:, 0]], TC[FTC[:, 2]] - TC[FTC[:, 0]]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def doubled_in_space(V: np.ndarray, F: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]]), axis=1)


def programs() -> dict[str, Callable[[np.ndarray, np.ndarray], Made]]:
    found: dict[str, Callable[[np.ndarray, np.ndarray], Made]] = {"unwrap": ours, "unwrap, isometric": even}
    if find_spec("xatlas"):
        found["xatlas"] = by_xatlas
    if find_spec("uvunwrap"):
        found["uvunwrap"] = by_uvunwrap
    if blender():
        found["Blender"] = by_blender
    return found


def row(name: str, program: str, values: list[float]) -> str:
    charts, seams, stretch, spread, fill, touch, seconds = values
    cells = [
        f"{charts:.0f}",
        f"{seams:.1f}",
        f"{stretch:.3f}",
        f"{spread:.1f}",
        f"{fill:.2f}",
        f"{touch:.0f}",
    ]
    return f"| {name} | {program} | {' | '.join(cells)} | {seconds:.2f} |"


def main() -> None:
    warnings.simplefilter("ignore", OutcomeWarning)
    print(
        f"At {RESOLUTION} x {RESOLUTION} with {PADDING} texels of padding. Seams: length over the square\n"
        "root of the area. Spread: texel areas, 99th over 1st percentile. Fill: share of the page; those\n"
        "of xatlas and uvunwrap need not be square. Touching: charts that share a texel of a bilinear\n"
        "lookup with another one. s: seconds.\n"
    )
    heads = "mesh | by | charts | seams | L2 stretch | spread | fill | touching | s"
    print(f"| {heads} |\n|{'---|' * (heads.count('|') + 1)}")
    tables: dict[str, list[list[float]]] = {}
    for name, V, F in [("pial", *pial()), *shared(*(ALL if "--all" in sys.argv else KINDS))]:
        for program, run in programs().items():
            try:
                values = figures(V, F, run(V, F))
            except Exception as error:  # another program's, or our own: the table says so
                print(f"| {name} | {program} | {type(error).__name__} | | | | | | |", flush=True)
                print(name, program, error, file=sys.stderr)
                continue
            tables.setdefault(program, []).append(values)
            print(row(name, program, values), flush=True)
    for program, values in tables.items():
        print(row(f"median of {len(values)}", program, np.median(values, axis=0).tolist()))


if __name__ == "__main__":
    main()
