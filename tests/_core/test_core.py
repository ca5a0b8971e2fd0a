"""The compiled core as a whole: its two builds, threads, and bindings."""

from __future__ import annotations

import ast
import os
import pickle
import subprocess
import sys
from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import DISKS, HOLES, STRESS, best_fit_distance, bumps, load

import igl_linabf as il
from igl_linabf import _core
from igl_linabf.surface import planar_mesh

NAMES = ["bumps", "cortex", "ball", "pial_with_holes", *HOLES, *DISKS, *STRESS]
METHODS = ("linabf", "abf")
LONG = ("stress__flipfree_deer.obj", "stress__optcuts_golf.obj", "ball")

BASELINE = """
import pickle, sys, warnings
warnings.simplefilter("ignore")
import igl_linabf as il
from igl_linabf import _core
assert _core.BUILD == "baseline"
meshes = pickle.load(open(sys.argv[1], "rb"))
made = {}
for name, mesh in meshes.items():
    for method in ("linabf", "abf"):
        made[name, method] = il.flatten(*mesh, method=method)
pickle.dump(made, open(sys.argv[2], "wb"))
"""


def in_a_process(code: str, *arguments: object, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def found(name: str) -> tuple[np.ndarray, np.ndarray] | None:
    try:
        return load(name)
    except pytest.skip.Exception:
        return None


@pytest.fixture(scope="module")
def baseline_maps(
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[tuple[str, str], il.flattening.Flattening]:
    """Flatten all available meshes with the baseline build."""
    folder: Path = tmp_path_factory.mktemp("baseline")
    meshes = {name: mesh for name in NAMES if (mesh := found(name)) is not None}
    (folder / "in").write_bytes(pickle.dumps(meshes))
    in_a_process(BASELINE, folder / "in", folder / "out", IGL_LINABF_CORE="baseline")
    made: dict[tuple[str, str], il.flattening.Flattening] = pickle.loads((folder / "out").read_bytes())
    return made


@pytest.mark.skipif(_core.BUILD == "baseline", reason="this processor runs the build for every processor")
@pytest.mark.filterwarnings("ignore::igl_linabf.FallbackWarning", "ignore::igl_linabf.MeshWarning")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", METHODS)
def test_both_builds_give_the_same_maps(
    name: str, method: str, baseline_maps: dict[tuple[str, str], il.flattening.Flattening]
) -> None:
    fast, plain = il.flatten(*load(name), method=method), baseline_maps[name, method]
    if method == "abf" and name in LONG:
        return  # the rounding errors of the two builds diverge over hundreds of steps
    assert np.abs(fast.angles - plain.angles).max() < 1e-9
    # compare up to a similarity, because rounding affects the principal axes of a symmetric map
    assert best_fit_distance(fast.uv, plain.uv) < 1e-9
    assert fast.outcome == plain.outcome
    assert [step.inner_steps for step in fast.report.steps] == [
        step.inner_steps for step in plain.report.steps
    ]


def test_a_map_has_the_same_bits_for_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    V, F = bumps(1_000)
    for _ in range(4):
        V, F = igl.upsample(V, F)
    assert F.shape[0] > 250_000  # several threads share loops of this length
    maps = []
    for threads in "1", "2", "3":
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        maps.append(il.linabf(V, F))
    np.testing.assert_array_equal(maps[0], maps[1])
    np.testing.assert_array_equal(maps[0], maps[2])


def stub() -> ast.Module:
    return ast.parse((Path(_core.__file__).parent / "__init__.pyi").read_text("utf-8"))


def test_the_stub_declares_the_signature_of_each_bound_function() -> None:
    bound = {name: value for name, value in vars(_core._built).items() if not name.startswith("_")}
    listed = {node.name: node for node in stub().body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    functions = {name for name, value in bound.items() if callable(value)}
    assert set(listed) == functions - {"has_v3"}
    for name in sorted(set(listed)):
        node, text = listed[name], bound[name].__doc__ or ""
        if not isinstance(node, ast.FunctionDef):
            continue
        line = text.partition("\n")[0]
        told = [word.partition(":")[0].strip() for word in split_arguments(line[line.index("(") + 1 :])]
        assert told == [argument.arg for argument in node.args.args], name
        assert len(text.splitlines()) > 1, f"{name} has no docstring"


def split_arguments(arguments: str) -> list[str]:
    """Split the arguments of a signature up to its closing parenthesis."""
    parts, depth = [""], 0
    for letter in arguments:
        if letter == ")" and not depth:
            break
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and not depth:
            parts.append("")
        else:
            parts[-1] += letter
    return [part for part in parts if part.strip()]


def test_output_arguments_are_never_copied() -> None:
    start, a = np.array([0, 2, 4]), np.arange(4.0)
    with pytest.raises(TypeError):
        _core.update_cg_direction(start, np.ones(2), a, np.zeros(4, dtype=np.float32))


def test_importing_the_package_loads_no_core_and_flattening_loads_one() -> None:
    code = "import sys, igl_linabf; a = 'igl_linabf._core' in sys.modules; igl_linabf.linabf; "
    code += "print(a, 'igl_linabf._core' in sys.modules, 'numba' in sys.modules)"
    assert in_a_process(code).split() == ["False", "True", "False"]


def test_faces_of_any_integer_type_reach_the_core() -> None:
    V, F = bumps(80)
    expected = il.linabf(V, F)
    for kind in (np.int32, np.uint32, np.uint64):
        np.testing.assert_array_equal(il.linabf(np.asfortranarray(V), F.astype(kind)), expected)
    assert planar_mesh(V, F.astype(np.int32)).topology.corner.dtype == np.int64


def test_integer_results_have_dtype_int64() -> None:
    order, _, _ = _core.group_sides(np.array([0, 1]), np.array([1, 0]), 2)
    # NumPy has two 64-bit integer types, and prints the dtype of only one of them
    assert order.dtype.char == np.arange(1).dtype.char
    assert repr(order) == "array([0, 1])"
