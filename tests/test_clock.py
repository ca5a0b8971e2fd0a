"""Results do not depend on the clock or the load: busy processes change no bit of any option's result."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from inspect import signature
from typing import Any

import igl
import numpy as np
import pytest
from conftest import bumps
from hostile_meshes import close_with_copy

from igl_linabf import ABF, ChartOptions, Cones, Isometric, LinABF, Packing, find_seams, flatten, unwrap
from igl_linabf.flattening import METHODS

BUSY = 3 * (os.cpu_count() or 1)  # number of processes that keep all cores busy
DISK = bumps(300)
BODY = close_with_copy(*bumps(250))
SPIRAL_T = np.repeat(np.linspace(0, 15, 400), 2)
SPIRAL_SIDE = np.tile([0, 0.2], 400)
SPIRAL = (
    np.column_stack(
        ((1 - SPIRAL_SIDE) * np.cos(SPIRAL_T), (1 - SPIRAL_SIDE) * np.sin(SPIRAL_T), 1e-3 * SPIRAL_T)
    ),
    np.array([f for i in range(0, 798, 2) for f in ([i, i + 1, i + 2], [i + 1, i + 3, i + 2])]),
)
LOOP = igl.boundary_loop(DISK[1])

SEAMS = find_seams(*BODY)

CHARTS: dict[str, Any] = {
    "trade": 30.0,
    "hide": [0, -1, 0],
    "keep_holes": True,
    "extend": True,
    "max_stretch": 1.05,
    "max_dirichlet": 4.1,
    "max_charts": 2,
    "repair_overlaps": True,
    "labels": np.arange(len(BODY[1])) // 100,
}
PACKING: dict[str, Any] = {
    "resolution": 256,
    "padding": 3.0,
    "texel_density": 20.0,
    "pages": 2,
    "margin": 0.01,
    "unseen": 0.5,
    "cut_below": 0.4,
}
CONES: dict[str, Any] = {"at": 6, "angles": "quarter", "period": 0.125}
UNWRAP: dict[str, Any] = {"seams": SEAMS, "method": "isometric", "weld": 1e-6, "strict": True}
FLATTEN: dict[str, Any] = {
    "b": LOOP[:2],
    "outer": int(LOOP[0]),
    "boundary": "circle",
    "corners": LOOP[:: len(LOOP) // 4][:4],
    "up": [0, 0, 1],
    "fit": "lengths",
    "clean": True,
}
METHOD_OPTIONS = (
    LinABF(iterations=3),
    LinABF(solver="direct"),
    LinABF(guarantee="injective"),
    LinABF(layout="greedy"),
    ABF(guarantee="injective"),
    Isometric(weight=4.0),
)


def unwrap_options() -> Iterator[tuple[str, dict[str, Any]]]:
    yield "default", {}
    for name, value in CHARTS.items():
        edges = {"seams": SEAMS[:3]} if name == "extend" else {}
        yield f"charts.{name}", {"charts": ChartOptions(**{name: value}), **edges}
    for name, value in PACKING.items():
        needed = {} if name in ("margin", "resolution") else {"resolution": 256}
        yield f"packing.{name}", {"packing": Packing(**{name: value} | needed)}
    for name, value in CONES.items():
        needed = {"angles": "quarter"} if name == "period" else {}
        yield f"cones.{name}", {"cones": Cones(**{"at": 6, name: value} | needed)}
    for name, value in UNWRAP.items():
        yield name, {name: value}


def compute_all() -> dict[str, bytes]:
    """Return the results of each option as bytes."""
    results: dict[str, bytes] = {}

    def keep(name: str, *arrays: np.ndarray) -> None:
        results[name] = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name, options in unwrap_options():
            atlas = unwrap(*BODY, progress=False, **options)
            keep(f"unwrap {name}", atlas.TC, atlas.FTC)
        atlas = unwrap(*SPIRAL, charts=ChartOptions(repair_overlaps=True), progress=False)
        keep("unwrap of a spiral", atlas.TC, atlas.FTC)
        for name, value in FLATTEN.items():
            options = {name: value}
            options |= {"bc": np.array([[0.0, 0.0], [1.0, 0.0]])} if name == "b" else {}
            options |= {"boundary": "rectangle"} if name == "corners" else {}
            keep(f"flatten {name}", flatten(*DISK, progress=False, **options).uv)
        for method in (*METHODS, *METHOD_OPTIONS):
            keep(f"flatten {method}", flatten(*DISK, method=method, progress=False).uv)
    return results


@contextmanager
def busy_processes() -> Iterator[None]:
    processes = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(BUSY)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_the_test_of_the_clock_covers_all_options() -> None:
    assert set(CHARTS) == {field.name for field in fields(ChartOptions) if field.name != "_"}
    assert set(PACKING) == {field.name for field in fields(Packing) if field.name != "_"}
    assert set(CONES) == {field.name for field in fields(Cones) if field.name != "_"}
    common = {"V", "F", "method", "progress", "options"}  # options of methods are in METHOD_OPTIONS
    assert {*UNWRAP, "charts", "cones", "packing"} | common == {*signature(unwrap).parameters}
    assert {*FLATTEN, "bc"} | common == {*signature(flatten).parameters}


@pytest.mark.slow
def test_no_result_depends_on_the_load() -> None:
    alone = compute_all()
    with busy_processes():
        beside = compute_all()
    assert {name for name in alone if alone[name] != beside[name]} == set()
    assert alone.keys() == beside.keys()
