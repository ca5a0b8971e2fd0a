"""Bad input is refused before it reaches igl or CHOLMOD, with the place of the fault."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache, partial
from itertools import product
from pathlib import Path

import igl
import numpy as np
import pytest
from bad_input import REFUSED, WARNED, F, V
from conftest import load

from igl_linabf import (
    ChartOptions,
    Cones,
    Isometric,
    MeshError,
    MeshWarning,
    Packing,
    abf,
    clean,
    compare,
    find_seams,
    flatten,
    linabf,
    quality,
    unwrap,
)
from igl_linabf.charts import find_cones
from igl_linabf.flattening import METHODS
from igl_linabf.remesh import quad_grid
from igl_linabf.textures import bake

SCRIPT = Path(__file__).with_name("bad_input.py")


@cache
def run_cases() -> dict[str, list[str]]:
    """Return how each method ends in each case; after a crash, another process continues."""
    names, ends = [*REFUSED, *WARNED], {}
    while names:
        process = subprocess.run(
            [sys.executable, SCRIPT, *names], capture_output=True, encoding="utf-8", timeout=500
        )
        done = dict(map(json.loads, process.stdout.splitlines()))
        ends.update(done)
        names = names[len(done) :]
        if names:
            ends[names.pop(0)] = [f"exit code {process.returncode}: {process.stderr}"]
    return ends


@pytest.mark.parametrize("name", REFUSED)
def test_bad_input_is_refused_with_the_fault_and_its_place(name: str) -> None:
    says = REFUSED[name][-1]
    lines = run_cases()[name]
    assert [line.split(":")[1] for line in lines] == [" MeshError"] * len(METHODS)
    for line in lines:
        assert re.search(says, line), line
        assert ": " in line.split("MeshError: ")[1]  # advice follows the colon


@pytest.mark.parametrize("name", WARNED)
def test_unreferenced_vertices_are_left_out_with_one_warning(name: str) -> None:
    positions, faces, _, says = WARNED[name]
    alone = 0 if "start" in name else 12
    assert run_cases()[name] == [f"{method}: a map of 13, not a number at [{alone}]" for method in METHODS]
    with pytest.warns(MeshWarning, match=says) as caught:
        uv = linabf(positions, faces)
    (warning,) = (w for w in caught if w.category is MeshWarning)
    assert warning.filename == __file__
    kept = np.delete(np.arange(13), alone)
    assert (uv[kept] == linabf(V, F)).all()
    assert quality(positions, faces, uv).flips == 0


def test_the_mesh_behind_the_bad_input_is_good() -> None:
    assert quality(V, F, linabf(V, F)).flips == 0


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("handles__optcuts_torus_with_hole.obj", "1 handle "),
        ("handles__bff_punctured-torus.obj", "1 handle "),
        ("multi__bff_teapot.obj", "5 components"),
        ("multi__optcuts_double_triangles.obj", "2 components"),
        ("closed__igl_cow.off", "closed.*genus 0"),
        ("closed__igl_3holes.off", "closed.*genus 3"),
        ("invalid__bff_triple_vierbein.obj", "20 in all.*more than two faces"),
        ("invalid__optcuts_zero_area_48.obj", "faces 3922, 3925 have zero area"),
    ],
)
def test_real_meshes_that_are_not_disks_are_refused(name: str, says: str) -> None:
    with pytest.raises(MeshError, match=says):
        linabf(*load(name))


def test_a_clockwise_triangle_is_a_disk_like_any_other() -> None:
    uv = linabf(*load("invalid__optcuts_triangle_clockwise.obj"))
    assert np.isfinite(uv).all()


NOT_NUMBERS = ("2", "", [2.5, 3.5], [], {}, (), np.ones(3), 1j, object(), float("nan"), -1.0, True)
BALL = igl.icosahedron()
NUMBERS: dict[str, tuple[Callable[..., object], tuple[str, ...]]] = {
    "unwrap": (partial(unwrap, *BALL), ("weld", "packing")),
    "ChartOptions": (ChartOptions, ("trade", "max_stretch", "max_dirichlet", "max_charts")),
    "Packing": (Packing, ("margin", "resolution")),
    "Packing for a texture": (partial(Packing, resolution=64), ("padding", "texel_density", "pages")),
    "Cones": (partial(Cones, 6, angles="quarter"), ("period",)),
    "find_seams": (partial(find_seams, *BALL), ("trade",)),
    "find_cones": (partial(find_cones, *BALL), ("n", "cones_per_stretch")),
    "clean": (partial(clean, *BALL), ("weld",)),
    "linabf": (partial(linabf, V, F), ("tol", "rtol", "threshold", "iterations")),
    "abf": (partial(abf, V, F), ("tol", "threshold")),
    "Isometric": (Isometric, ("weight",)),
    "compare": (partial(compare, V, F, ["lscm"]), ("repeat",)),
    "bake": (
        lambda **wrong: bake(*BALL, unwrap(*BALL), BALL[0], **{"resolution": 64, **wrong}),
        ("resolution", "padding"),
    ),
    "quad_grid": (partial(quad_grid, V, F, V[:, :2]), ("spacing",)),
}


@pytest.mark.parametrize("name", NUMBERS)
def test_an_option_that_is_not_a_number_is_named(name: str) -> None:
    call, options = NUMBERS[name]
    for option, wrong in product(options, NOT_NUMBERS):
        with pytest.raises(ValueError, match=f"^{option} is .*: (give|use) "):
            call(**{option: wrong})


def test_an_invalid_method_or_progress_is_named() -> None:
    for wrong in (3, [], ["linabf"], np.ones(2), {}, "x"):
        with pytest.raises(ValueError, match=r"^method is .*: use one of 'linabf'"):
            flatten(V, F, method=wrong)
        with pytest.raises(ValueError, match=r"^progress is .*: give a function"):
            flatten(V, F, progress=wrong)
    for wrong in (3, [], "linabf", None):
        with pytest.raises(ValueError, match=r"^methods is .*: give a list"):
            compare(V, F, wrong)
    with pytest.raises(ValueError, match=r"^padding is 8, and texels need a resolution: give"):
        Packing(padding=8)
    with pytest.raises(ValueError, match=r"^margin is 0\.01, and with a resolution .*: give padding"):
        Packing(resolution=64, margin=0.01)
    with pytest.raises(ValueError, match=r"^extend=True adds to given seams: give"):
        unwrap(*BALL, charts=ChartOptions(extend=True))
    with pytest.raises(ValueError, match=r"^charts is \[\[0, 1\]\]: give ChartOptions"):
        unwrap(*BALL, charts=[[0, 1]])
