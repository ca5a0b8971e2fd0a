"""The extension beside Blender's own Unwrap, on the same seams, in Blender.

    python benchmarks/blender.py [--repeat 3]

Needs the environment of `make blender`, or a Python with `bpy` in IGL_LINABF_BPY. The seams are those that
the extension finds. Seconds are those of the operators, medians of alternating runs. Prints Markdown.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
OWN = ROOT / ".venv" / "blender" / "bin" / "python"
WAYS = {
    "Blender, angle based": ("blender", {"method": "ANGLE_BASED", "fill_holes": False, "margin": 0.001}),
    "Blender, minimum stretch": ("blender", {"method": "MINIMUM_STRETCH", "margin": 0.001}),
    "linear ABF": ("ours", {"method": "linabf"}),
    "ABF": ("ours", {"method": "abf"}),
    "isometric": ("ours", {"method": "isometric"}),
}


def in_blender(archive: str, meshes: list[str], repeat: int) -> None:
    """Runs in Blender's Python."""
    os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp()
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
    import igl_linabf  # of the extension's wheels

    print("| mesh (triangles) | way | seconds | F/3nt | L2 stretch | flips |", file=sys.stderr)
    print("|---|---|---|---|---|---|", file=sys.stderr)
    for path in meshes:
        held = np.load(path)
        V, F = held["V"], held["F"]
        thing = put(bpy, V, F)
        bpy.ops.uv.linabf_unwrap(seams="FOUND")
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        taken: dict[str, list[float]] = {name: [] for name in WAYS}
        said = {}
        for run in range(repeat + 1):
            for name, (whose, settings) in WAYS.items():
                start = perf_counter()
                way(bpy, whose, settings)()
                if run:  # the first one imports and compiles
                    taken[name].append(perf_counter() - start)
                bpy.ops.object.mode_set(mode="OBJECT")
                said[name] = measured(igl_linabf, V, F, corners(thing))
                bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        for name, seconds in taken.items():
            of, found = f"{Path(path).stem} ({len(F):,})", said[name]
            figures = f"{found.angle_distortion:.3g} | {found.stretch_l2:.3g} | {found.flips}"
            print(f"| {of} | {name} | {statistics.median(seconds):.2f} | {figures} |", file=sys.stderr)


def put(bpy: object, V: np.ndarray, F: np.ndarray) -> object:
    """The only object of the scene."""
    for old in list(bpy.data.objects):
        bpy.data.objects.remove(old)
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(V.tolist(), [], F.tolist())
    thing = bpy.data.objects.new("mesh", data)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    return thing


def way(bpy: object, whose: str, settings: dict[str, object]) -> Callable[[], object]:
    if whose == "blender":
        return lambda: bpy.ops.uv.unwrap(**settings)
    return lambda: bpy.ops.uv.linabf_unwrap(seams="MARKED", complete=False, **settings)


def corners(thing: object) -> np.ndarray:
    """The (#F, 3, 2) map."""
    uv = np.empty(2 * len(thing.data.loops), dtype=np.float32)
    thing.data.uv_layers.active.data.foreach_get("uv", uv)
    return uv.reshape(-1, 3, 2).astype(float)


def measured(igl_linabf: object, V: np.ndarray, F: np.ndarray, uv: np.ndarray) -> object:
    """The quality, with a vertex for each pair of a place and its texture coordinates."""
    keys = np.column_stack((F.ravel(), uv.reshape(-1, 2)))
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return igl_linabf.quality(V[F.ravel()[first]], index.reshape(-1, 3), uv.reshape(-1, 2)[first])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--in-blender", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.in_blender:
        archive, *meshes = options.in_blender
        in_blender(archive, meshes, options.repeat)
        return 0
    import igl
    from meshes import shared, stanford

    python = os.environ.get("IGL_LINABF_BPY") or OWN
    if not Path(python).exists():
        print("no Python with bpy is there: `make blender` makes one", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        build = [sys.executable, ROOT / "scripts" / "blender_extension.py", "--into", folder]
        subprocess.run(build, check=True, stdout=subprocess.DEVNULL)
        (archive,) = Path(folder).glob("*.zip")
        paths = []
        bunny = igl.qslim(*stanford()[1:], 20_000)[:2]  # Blender's own takes minutes of the whole
        for name, V, F in (("bunny", *bunny), *shared("closed")):
            paths.append(Path(folder) / f"{name}.npz")
            np.savez(paths[-1], V=V, F=F)
        command = [python, __file__, "--repeat", str(options.repeat), "--in-blender", archive, *paths]
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        done = subprocess.run(command, capture_output=True, encoding="utf-8", env=environment, check=False)
        table = [line for line in done.stderr.splitlines() if line.startswith("|")]
        print("\n".join(table) if done.returncode == 0 else done.stderr)
        return done.returncode


if __name__ == "__main__":
    sys.exit(main())
