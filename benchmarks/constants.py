"""What each constant of a room is for: it is halved and doubled, and the maps are compared.

    python benchmarks/constants.py charts.packing          # a room, with the rooms within it
    python benchmarks/constants.py charts --only STRETCH   # those whose names hold this word

A line is a constant at half or twice its value, in a process of its own. It says how many results changed,
of how many, and the medians before and after of those measures that moved: charts, length of seams over the
size of the mesh, L2 stretch, the paper's F/3nt, the share of pages that is filled, flips. With
IGL_LINABF_MESHES the shared meshes are among them.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
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

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "igl_linabf"
FACTORS = (0.5, 2.0)
LARGEST = 10_500  # triangles of a mesh: those of 10,000 have tips, limbs and overlaps, and take minutes
SLOW = ("a thousand loose triangles", "rounded plate, finer")  # a third of the time for few results
SECONDS = 300  # of one process, after which it is said to hang
MEASURES = ("charts", "seam", "L2 stretch", "F/3nt", "fill", "flips")


def is_number(node: ast.expr) -> bool:
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return is_number(node.left) and is_number(node.right)
    if isinstance(node, ast.Tuple):
        return bool(node.elts) and all(map(is_number, node.elts))
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def assigned(tree: ast.Module) -> Iterator[tuple[str, ast.Assign]]:
    """The numeric constants at the top of a module."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and is_number(node.value):
            yield node.targets[0].id, node


def constants(room: str) -> Iterator[tuple[str, str]]:
    """Module and name of each constant of a room and the rooms within it."""
    place = PACKAGE.joinpath(*room.split("."))
    for path in sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]:
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for name, _ in assigned(ast.parse(path.read_text("utf-8"))):
            yield module, name


def scaled(value: object, factor: float) -> object:
    """A whole number stays one, and at least 1."""
    if isinstance(value, tuple):
        return tuple(scaled(x, factor) for x in value)
    assert isinstance(value, (int, float))
    return max(1, int(value * factor)) if isinstance(value, int) and value > 0 else value * factor


class Scaled(SourceFileLoader, MetaPathFinder):
    """Loads one module with one of its constants scaled."""

    def __init__(self, module: str, name: str, factor: float) -> None:
        super().__init__(module, str(ROOT.joinpath(*module.split(".")).with_suffix(".py")))
        self.constant, self.factor = name, factor

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        spec = PathFinder.find_spec(name, path) if name == self.name else None
        if spec is not None:
            spec.loader = self
        return spec

    def get_code(self, fullname: str) -> CodeType:
        tree = ast.parse(Path(self.path).read_text("utf-8"))
        for name, node in assigned(tree):
            if name == self.constant:
                value = eval(compile(ast.Expression(node.value), self.path, "eval"))
                node.value = ast.copy_location(
                    ast.parse(repr(scaled(value, self.factor))).body[0].value, node.value
                )
        return compile(ast.fix_missing_locations(tree), self.path, "exec")


def meshes() -> Iterator[tuple[str, object, object]]:
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]
    from hard_surfaces import DEVELOPABLE, ROUNDED
    from meshes import shared
    from nasty_meshes import NASTY

    yield from (
        mesh
        for mesh in shared("disk", "stress", "holes", "closed", "multi", "handles")
        if len(mesh[2]) <= LARGEST
    )
    for name, make in {**DEVELOPABLE, **ROUNDED, **NASTY}.items():
        if name not in SLOW:
            yield name, *make()


def calls(room: str, V: object, F: object) -> dict[str, Callable[[], object]]:
    """What is made of a mesh: what a room has to do with."""
    import igl_linabf as il

    if room.startswith(("charts.cones", "charts.periodic")):
        return {
            "cones": lambda: il.unwrap(V, F, cones="auto", progress=False),
            "quarters": lambda: il.unwrap(V, F, cones=il.Cones("auto", angles="quarter"), progress=False),
        }
    cut = {
        "unwrap": lambda: il.unwrap(V, F, progress=False),
        "unwrap, isometric": lambda: il.unwrap(V, F, method="isometric", progress=False),
    }
    if room.startswith("charts"):
        return {
            **cut,
            "2 pages": lambda: il.unwrap(V, F, progress=False, packing=il.Packing(resolution=512, pages=2)),
            "hidden": lambda: il.unwrap(V, F, il.Seams(hide=(0, 0, 1)), progress=False),
            "little stretch": lambda: il.unwrap(V, F, il.Seams(max_stretch=1.1), progress=False),
        }
    return {
        **cut,
        "linabf": lambda: il.flatten(V, F),
        "abf": lambda: il.flatten(V, F, "abf"),
        "isometric": lambda: il.flatten(V, F, "isometric"),
        "circle": lambda: il.flatten(V, F, boundary="circle"),
    }


def results(room: str) -> dict[str, list[object]]:
    """A digest and the measures of every result; of an error its words."""
    import numpy as np

    import igl_linabf as il

    made: dict[str, list[object]] = {}
    warnings.simplefilter("ignore")
    for name, V, F in meshes():
        for verb, call in calls(room, V, F).items():
            try:
                result = call()
            except Exception as error:  # whatever ends it is what is compared
                made[f"{name}, {verb}"] = [f"{type(error).__name__}: {error}"]
                continue
            atlas = hasattr(result, "TC")
            q = result.quality if atlas else il.quality(V, F, result.uv)
            digest = hashlib.sha1((result.TC if atlas else result.uv).tobytes())
            if atlas:
                digest.update(result.FTC.tobytes())
            size = float(np.linalg.norm(np.ptp(np.nan_to_num(V), axis=0)))
            figures = [len(result.charts), result.seam_length / size] if atlas else [1, 0.0]
            figures += [q.stretch_l2, q.angle_distortion, result.fill if atlas else 1.0, q.flips]
            made[f"{name}, {verb}"] = [digest.hexdigest(), *figures]
    return made


def in_a_process(*words: object) -> dict[str, list[object]] | None:
    """What a process prints that has one constant scaled; None if it hangs or dies."""
    command = [sys.executable, __file__, "--child", *map(str, words)]
    environment = {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]),
    }
    try:
        process = subprocess.run(
            command, capture_output=True, encoding="utf-8", timeout=SECONDS, env=environment, check=True
        )
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
        return None
    return dict(json.loads(process.stdout.splitlines()[-1]))


def moved(before: dict[str, list[object]], after: dict[str, list[object]]) -> str:
    """How many results changed, and the medians that did; what became an error, or was one."""
    changed = [key for key, made in before.items() if after.get(key) != made]
    both = [key for key in changed if len(before[key]) > 1 and len(after[key]) > 1]
    words = [f"{len(changed)} of {len(before)}"]
    for i, measure in enumerate(MEASURES, 1):
        old, new = (median(float(made[key][i]) for key in both) if both else 0.0 for made in (before, after))
        if f"{old:.4g}" != f"{new:.4g}":
            words.append(f"{measure} {old:.4g} -> {new:.4g}")
    errors = len(changed) - len(both)
    return ", ".join([*words, *([f"{errors} began or ceased to be errors"] if errors else [])])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("room", help="such as charts.packing")
    parser.add_argument("--only", default="", metavar="WORD", help="constants whose names hold this word")
    arguments = parser.parse_args()
    before = in_a_process(arguments.room)
    if before is None:
        raise SystemExit("constants: the maps of the meshes cannot be made: run with --child ROOM to see why")
    asked = [(m, name) for m, name in constants(arguments.room) if arguments.only in name]
    runs = [(module, name, factor) for module, name in asked for factor in FACTORS]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        print("| constant | times | results that change, and medians of these |\n|---|---|---|")
        for (module, name, factor), after in zip(
            runs, pool.map(lambda run: in_a_process(arguments.room, *run), runs), strict=True
        ):
            said = "hangs or dies" if after is None else moved(before, after)
            print(f"| {module.removeprefix('igl_linabf.')}.{name} | {factor:g} | {said} |", flush=True)


if __name__ == "__main__":
    if "--child" in sys.argv:
        at = sys.argv.index("--child")
        asked, *change = sys.argv[at + 1 :]
        if change:
            sys.meta_path.insert(0, Scaled(change[0], change[1], float(change[2])))
        print(json.dumps(results(asked)))
    else:
        main()
