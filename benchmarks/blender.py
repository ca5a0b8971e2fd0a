"""Compare the extension with Blender's own Unwrap operator on the same seams.

    python benchmarks/blender.py [--repeat 3]
    python benchmarks/blender.py --subdivision

The benchmark needs the environment of `make blender`, or a Python with `bpy` named by IGL_LINABF_BPY. The
extension finds the seams. Seconds are the times of the operators, medians of alternating runs. With
--subdivision, it prints the spread of texel densities of cages with the modifier Subdivision Surface. Prints
Markdown.
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
DEFAULT_PYTHON = ROOT / ".venv" / "blender" / "bin" / "python"
OPERATORS = {
    "Blender, angle based": ("blender", {"method": "ANGLE_BASED", "fill_holes": False, "margin": 0.001}),
    "Blender, minimum stretch": ("blender", {"method": "MINIMUM_STRETCH", "margin": 0.001}),
    "linear ABF": ("ours", {"method": "linabf"}),
    "ABF": ("ours", {"method": "abf"}),
    "isometric": ("ours", {"method": "isometric"}),
}


def measure_in_blender(archive: str, meshes: list[str], repeat: int) -> None:
    """Measure all operators in the Python of Blender, and print the table to stderr."""
    os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp()
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
    import igl_linabf  # the package is part of the extension

    print("| mesh (triangles) | method | seconds | F/3nt | L2 stretch | flips |", file=sys.stderr)
    print("|---|---|---|---|---|---|", file=sys.stderr)
    for path in meshes:
        arrays = np.load(path)
        V, F = arrays["V"], arrays["F"]
        obj = replace_scene(bpy, V, F)
        bpy.ops.uv.linabf_unwrap(seams="FOUND")
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        seconds: dict[str, list[float]] = {name: [] for name in OPERATORS}
        measured = {}
        for run in range(repeat + 1):
            for name, (owner, settings) in OPERATORS.items():
                start = perf_counter()
                make_call(bpy, owner, settings)()
                if run:  # the first run imports the package and does not count
                    seconds[name].append(perf_counter() - start)
                bpy.ops.object.mode_set(mode="OBJECT")
                measured[name] = measure_quality(igl_linabf, V, F, read_corners(obj))
                bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        for name, values in seconds.items():
            mesh_label, found = f"{Path(path).stem} ({len(F):,})", measured[name]
            figures = f"{found.angle_distortion:.3g} | {found.stretch_l2:.3g} | {found.flips}"
            print(f"| {mesh_label} | {name} | {statistics.median(values):.2f} | {figures} |", file=sys.stderr)


def measure_subdivided(archive: str) -> None:
    """Measure texel densities on the subdivided surfaces of cages, and print the table to stderr."""
    os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp()
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
    add = bpy.ops.mesh
    cages = {
        "monkey": add.primitive_monkey_add,
        "cube": add.primitive_cube_add,
        "cylinder, 6 sides": lambda: add.primitive_cylinder_add(vertices=6),
        "sphere, 8 x 5": lambda: add.primitive_uv_sphere_add(segments=8, ring_count=5),
        "cone, 8 sides": lambda: add.primitive_cone_add(vertices=8),
    }
    names = (
        "extension, unwraps the cage",
        "extension, Use Modifiers",
        "Blender, unwraps the cage",
        "Blender, Use Subdivision Surface",
    )
    print(f"| cage | {' | '.join(names)} |\n|---|---|---|---|---|", file=sys.stderr)
    for cage, make in cages.items():
        for old in list(bpy.data.objects):
            bpy.data.objects.remove(old)
        make()
        obj = bpy.context.active_object
        bpy.ops.uv.linabf_unwrap(seams="FOUND")
        subdivision = obj.modifiers.new("subdivision", "SUBSURF")
        subdivision.levels, subdivision.uv_smooth = 2, "NONE"
        spread = []
        for modifiers in (False, True):
            bpy.ops.uv.linabf_unwrap(modifiers=modifiers)
            spread.append(measure_texel_spread(bpy, obj))
        for subdivided in (False, True):
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.uv.unwrap(method="MINIMUM_STRETCH", use_subsurf_data=subdivided, margin=0.001)
            bpy.ops.object.mode_set(mode="OBJECT")
            spread.append(measure_texel_spread(bpy, obj))
        print(f"| {cage} | {' | '.join(f'{value:.3f}' for value in spread)} |", file=sys.stderr)


def measure_texel_spread(bpy: object, obj: object) -> float:
    """Return the standard deviation of the logarithm of the texel density, with all modifiers."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    uv = np.array([corner.uv for corner in mesh.uv_layers.active.data])
    flat, area = [], []
    for face in mesh.polygons:
        x, y = uv[list(face.loop_indices)].T
        flat.append(abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2)
        area.append(face.area)
    evaluated.to_mesh_clear()
    density = np.log(np.sqrt(np.array(flat) / area))
    return float(np.sqrt(np.average((density - np.average(density, weights=area)) ** 2, weights=area)))


def replace_scene(bpy: object, V: np.ndarray, F: np.ndarray) -> object:
    """Replace all objects of the scene with one mesh, and return it."""
    for old in list(bpy.data.objects):
        bpy.data.objects.remove(old)
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(V.tolist(), [], F.tolist())
    obj = bpy.data.objects.new("mesh", data)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def make_call(bpy: object, owner: str, settings: dict[str, object]) -> Callable[[], object]:
    if owner == "blender":
        return lambda: bpy.ops.uv.unwrap(**settings)
    return lambda: bpy.ops.uv.linabf_unwrap(seams="MARKED", extend=False, **settings)


def read_corners(obj: object) -> np.ndarray:
    """Return the texture coordinates at the corners of the faces, (#F, 3, 2)."""
    uv = np.empty(2 * len(obj.data.loops), dtype=np.float32)
    obj.data.uv_layers.active.data.foreach_get("uv", uv)
    return uv.reshape(-1, 3, 2).astype(float)


def measure_quality(igl_linabf: object, V: np.ndarray, F: np.ndarray, uv: np.ndarray) -> object:
    """Return the quality of the map, with one vertex per pair of position and texture coordinates."""
    keys = np.column_stack((F.ravel(), uv.reshape(-1, 2)))
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return igl_linabf.quality(V[F.ravel()[first]], index.reshape(-1, 3), uv.reshape(-1, 2)[first])


def list_meshes() -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Return the names and arrays of the meshes."""
    import igl
    from meshes import load_shared_meshes, stanford

    bunny = igl.qslim(*stanford()[1:], 20_000)[:2]  # Blender takes minutes for the full bunny
    return [("bunny", *bunny), *load_shared_meshes("closed")]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--subdivision", action="store_true", help="compare cages of subdivided surfaces")
    parser.add_argument("--in-blender", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.in_blender:
        archive, *meshes = options.in_blender
        if options.subdivision:
            measure_subdivided(archive)
            return 0
        measure_in_blender(archive, meshes, options.repeat)
        return 0
    python = os.environ.get("IGL_LINABF_BPY") or DEFAULT_PYTHON
    if not Path(python).exists():
        print("there is no Python with bpy: run `make blender` to create one", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        build = [sys.executable, ROOT / "scripts" / "blender_extension.py", "--into", folder]
        subprocess.run(build, check=True, stdout=subprocess.DEVNULL)
        (archive,) = Path(folder).glob("*.zip")
        paths = []
        for name, V, F in () if options.subdivision else list_meshes():
            paths.append(Path(folder) / f"{name}.npz")
            np.savez(paths[-1], V=V, F=F)
        mode = ["--subdivision"] if options.subdivision else ["--repeat", str(options.repeat)]
        command = [python, __file__, *mode, "--in-blender", archive, *paths]
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        process = subprocess.run(command, capture_output=True, encoding="utf-8", env=environment, check=False)
        table = [line for line in process.stderr.splitlines() if line.startswith("|")]
        print("\n".join(table) if process.returncode == 0 else process.stderr)
        return process.returncode


if __name__ == "__main__":
    sys.exit(main())
