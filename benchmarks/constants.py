"""Halve and double each numeric constant of a subpackage, and compare the maps.

    python benchmarks/constants.py charts.packing          # a subpackage and its own subpackages
    python benchmarks/constants.py charts --only STRETCH   # only constants whose names contain this word

A constant is a number or a tuple of numbers that a module of the subpackage assigns to a name in capitals at
its top level. Each row of the table is a constant at half or twice its value, measured in a separate process.
The row has the number of results that change, and the medians before and after over these results: number of
charts, length of the seams relative to the size of the mesh, L2 stretch, F/3nt, share of the pages that is
filled, and flips. If IGL_LINABF_MESHES is set, the meshes in that folder are included. Prints Markdown.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import math
import os
import re
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from statistics import median
from types import CodeType

import numpy as np

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "igl_linabf"
FACTORS = (0.5, 2.0)
LARGEST = 10_500  # triangles of the largest mesh; bodies with limbs and overlapping maps are smaller
# meshes that are left out, because they take a third of the time and add few results
SLOW = ("a thousand loose triangles", "rounded plate, finer")
TIMEOUT = 300  # time limit of a process in seconds
FIGURES = ("charts", "seam", "L2 stretch", "F/3nt", "fill", "flips")


def is_number(value: object) -> bool:
    """Return True for a finite int or float, and for a tuple of these."""
    if isinstance(value, tuple):
        return bool(value) and all(map(is_number, value))
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def evaluate(node: ast.expr) -> object:
    """Return the value of an expression of numbers, `np` and `math`; None for all other expressions."""
    try:
        return eval(compile(ast.Expression(node), "<constant>", "eval"), {"np": np, "math": math})
    except Exception:  # the expression uses other names of the module
        return None


def find_constants(tree: ast.Module) -> Iterator[tuple[str, ast.Assign | ast.AnnAssign, object]]:
    """Yield name, assignment and value of the numeric constants at the top level of a module."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target = node.targets[0]
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            target = node.target
        else:
            continue
        if isinstance(target, ast.Name) and re.fullmatch(r"_?[A-Z][A-Z0-9_]*", target.id):
            value = evaluate(node.value)
            if is_number(value):
                yield target.id, node, value


def find_constants_of_room(room: str) -> Iterator[tuple[str, str]]:
    """Yield module and name of each constant of a subpackage and of its own subpackages."""
    place = PACKAGE.joinpath(*room.split("."))
    for path in sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]:
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for name, *_ in find_constants(ast.parse(path.read_text("utf-8"))):
            yield module, name


def scale(value: object, factor: float) -> object:
    """Return the value times a factor; positive integers remain integers of at least 1."""
    if isinstance(value, tuple):
        return tuple(scale(x, factor) for x in value)
    if isinstance(value, int):
        return max(1, int(value * factor)) if value > 0 else value * factor
    assert isinstance(value, float)
    return float(value) * factor


class ScalingLoader(SourceFileLoader, MetaPathFinder):
    """A loader of one module that scales one of its constants.

    Modules that import the constant get the scaled value, too, because the module is loaded only once.
    """

    def __init__(self, module: str, constant: str, factor: float) -> None:
        place = ROOT.joinpath(*module.split("."))
        path = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
        super().__init__(module, str(path))
        self.constant, self.factor = constant, factor

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        spec = PathFinder.find_spec(name, path) if name == self.name else None
        if spec is not None:
            spec.loader = self
        return spec

    def get_code(self, fullname: str) -> CodeType:
        tree = ast.parse(Path(self.path).read_text("utf-8"))
        for name, node, value in find_constants(tree):
            if name == self.constant:
                scaled = ast.parse(repr(scale(value, self.factor)), mode="eval").body
                node.value = ast.copy_location(scaled, node.value)
        return compile(ast.fix_missing_locations(tree), self.path, "exec")


def meshes() -> Iterator[tuple[str, object, object]]:
    """Yield the meshes that are flattened and unwrapped, with their names."""
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]
    from hard_surfaces import DEVELOPABLE, ROUNDED
    from meshes import load_shared_meshes
    from nasty_meshes import NASTY

    yield from (
        mesh
        for mesh in load_shared_meshes("disk", "stress", "holes", "closed", "multi", "handles")
        if len(mesh[2]) <= LARGEST
    )
    for name, make in {**DEVELOPABLE, **ROUNDED, **NASTY}.items():
        if name not in SLOW:
            yield name, *make()


def make_calls(room: str, V: object, F: object) -> dict[str, Callable[[], object]]:
    """Return the calls on one mesh whose results may depend on the constants of a subpackage."""
    import igl_linabf as il

    if room.startswith(("charts.cones", "charts.periodic")):
        return {
            "cones": lambda: il.unwrap(V, F, cones="auto", progress=False),
            "quarters": lambda: il.unwrap(V, F, cones=il.Cones("auto", angles="quarter"), progress=False),
        }
    cut = {
        "unwrap": lambda: il.unwrap(V, F, progress=False),
        "unwrap, linabf": lambda: il.unwrap(V, F, method="linabf", progress=False),
    }
    if room.startswith("charts"):
        return {
            **cut,
            "2 pages": lambda: il.unwrap(V, F, progress=False, packing=il.Packing(resolution=512, pages=2)),
            "hidden": lambda: il.unwrap(V, F, charts=il.ChartOptions(hide=(0, 0, 1)), progress=False),
            "little stretch": lambda: il.unwrap(
                V, F, charts=il.ChartOptions(max_stretch=1.1), progress=False
            ),
        }
    return {
        **cut,
        "linabf": lambda: il.flatten(V, F),
        "abf": lambda: il.flatten(V, F, method="abf"),
        "isometric": lambda: il.flatten(V, F, method="isometric"),
        "circle": lambda: il.flatten(V, F, boundary="circle"),
    }


def compute_results(room: str) -> dict[str, list[object]]:
    """Return, for each call, a digest and the figures of its result, or the text of its error."""
    import igl_linabf as il

    results: dict[str, list[object]] = {}
    warnings.simplefilter("ignore")
    for name, V, F in meshes():
        for verb, call in make_calls(room, V, F).items():
            try:
                result = call()
            except Exception as error:  # errors are compared in the same way as results
                results[f"{name}, {verb}"] = [f"{type(error).__name__}: {error}"]
                continue
            atlas = hasattr(result, "TC")
            q = result.quality if atlas else il.quality(V, F, result.uv)
            digest = hashlib.sha1((result.TC if atlas else result.uv).tobytes())
            if atlas:
                digest.update(result.FTC.tobytes())
            size = float(np.linalg.norm(np.ptp(np.nan_to_num(V), axis=0)))
            figures = [len(result.charts), result.seam_length / size] if atlas else [1, 0.0]
            figures += [q.stretch_l2, q.angle_distortion, result.fill if atlas else 1.0, q.flips]
            results[f"{name}, {verb}"] = [digest.hexdigest(), *figures]
    return results


def run_child(*arguments: object) -> dict[str, list[object]] | None:
    """Return the results of a child process with a scaled constant; None if it hangs or crashes."""
    command = [sys.executable, __file__, "--child", *map(str, arguments)]
    environment = {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]),
    }
    try:
        process = subprocess.run(
            command, capture_output=True, encoding="utf-8", timeout=TIMEOUT, env=environment, check=True
        )
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
        return None
    return dict(json.loads(process.stdout.splitlines()[-1]))


def describe_changes(before: dict[str, list[object]], after: dict[str, list[object]]) -> str:
    """Return the number of changed results, the changed medians, and the number of changed errors."""
    changed = [key for key, result in before.items() if after.get(key) != result]
    both = [key for key in changed if len(before[key]) > 1 and len(after[key]) > 1]
    parts = [f"{len(changed)} of {len(before)}"]
    for i, figure in enumerate(FIGURES, 1):
        old, new = (median(float(run[key][i]) for key in both) if both else 0.0 for run in (before, after))
        if f"{old:.4g}" != f"{new:.4g}":
            parts.append(f"{figure} {old:.4g} -> {new:.4g}")
    errors = len(changed) - len(both)
    return ", ".join([*parts, *([f"{errors} errors appear or disappear"] if errors else [])])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("room", help="such as charts.packing")
    parser.add_argument(
        "--only", default="", metavar="WORD", help="only constants whose names contain this word"
    )
    options = parser.parse_args()
    before = run_child(options.room)
    if before is None:
        raise SystemExit("constants: the unchanged room failed: run with --child ROOM to see the error")
    chosen = [(m, name) for m, name in find_constants_of_room(options.room) if options.only in name]
    runs = [(module, name, factor) for module, name in chosen for factor in FACTORS]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        print("| constant | times | results that change, and their medians |\n|---|---|---|")
        for (module, name, factor), after in zip(
            runs, pool.map(lambda run: run_child(options.room, *run), runs), strict=True
        ):
            cell = "hangs or crashes" if after is None else describe_changes(before, after)
            print(f"| {module.removeprefix('igl_linabf.')}.{name} | {factor:g} | {cell} |", flush=True)


if __name__ == "__main__":
    if "--child" in sys.argv:
        room, *change = sys.argv[sys.argv.index("--child") + 1 :]
        if change:
            sys.meta_path.insert(0, ScalingLoader(change[0], change[1], float(change[2])))
        print(json.dumps(compute_results(room)))
    else:
        main()
