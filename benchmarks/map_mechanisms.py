"""Compare maps with and without each mechanism of the flattening.

    python benchmarks/map_mechanisms.py [MECHANISM ...]

Disks are the meshes of the kinds disk and stress in IGL_LINABF_MESHES, and random meshes. They are mapped by
linear ABF, by converged ABF, onto a circle, onto a rectangle, and with the guarantee. Meshes with holes are
mapped by linear ABF, onto a circle and onto circles, closed meshes with 16 cones, and closed meshes with and
without handles with cones of quarter turns. F/3nt, L2 stretch and flips are measured on the map. The time is
the CPU time of one thread. Prints Markdown.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple
from unittest.mock import patch

import igl
import numpy as np
from mechanisms import squared_stretch
from meshes import Mesh, load_shared_meshes

import igl_linabf
from igl_linabf import Cones, LinABF, flatten, unwrap
from igl_linabf.angles.steps import conformal_corrections, newton, prescribed
from igl_linabf.angles.system import preconditioner
from igl_linabf.charts import find_cones
from igl_linabf.charts.cones import quantisation
from igl_linabf.flattening import methods
from igl_linabf.flattening.fallbacks import attempts, injective

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from hostile_meshes import Disk

RANDOM = 40  # number of random disks; about one in ten needs a fallback
CONES = 16
NEVER = 10**9
Patch = tuple[Any, str, Any]  # (module, name in the module, replacement)
MECHANISMS: dict[str, tuple[Patch, ...]] = {
    "slivers corrected": (
        (preconditioner, "MIN_SLIVER_RATIO", np.inf),
        (preconditioner, "MIN_SLIVER_RATIO_OF_SMALL_SYSTEM", np.inf),
    ),
    "another ratio of slivers for small systems": (
        (preconditioner, "MIN_SLIVER_RATIO_OF_SMALL_SYSTEM", preconditioner.MIN_SLIVER_RATIO),
    ),
    "conformal corrections": (
        (conformal_corrections, "correct_conformally", lambda state, *_: state),
        (prescribed, "correct_conformally", lambda state, *_: state),
        (newton, "correct_conformally", lambda state, *_: state),
    ),
    "slow steps solved further": ((newton, "LEAST_ANCHORED_RTOL", newton.ANCHORED_RTOL),),
    "ears": ((attempts.Ears, "remove_from", lambda *_: None),),
    "converged ABF after linear ABF": (
        (
            methods,
            "_list_default_stages",
            lambda rtol, tol, made=methods._list_default_stages: made(rtol, tol)[:2],
        ),
    ),
    "feasible form": ((methods, "run_feasible_abf", lambda *_, **__: None),),
    "linear ABF after converged ABF": ((methods, "fall_back_to_linear", lambda *_, **__: None),),
    "exchanges of quarter turns for stretch": ((quantisation, "MAX_EXCHANGES", 0),),
    "exchanges of quarter turns for closed paths": ((quantisation, "PAIRED_EXCHANGES", 0),),
    "the attempt of the fewest flips": (
        (
            module,
            "select_best",
            lambda made: next((m, m.layout) for m in reversed(made) if m.layout is not None),
        )
        for module in (attempts, injective)
    ),
}
MECHANISMS = {name: tuple(patches) for name, patches in MECHANISMS.items()}


# documented behaviour that a mechanism preserves, even if the maps of the benchmark do not change
PROMISED = {
    "another ratio of slivers for small systems": "a circle of converged ABF, a Flattener's analysis",
    "slow steps solved further": "angles held at their bounds",
    "converged ABF after linear ABF": "random disks with angles near pi flip",
    "linear ABF after converged ABF": "a circle of converged ABF",
    "exchanges of quarter turns for closed paths": "F/3nt of a nut and of a double torus, x 6 and x 30",
}


class Figures(NamedTuple):
    """The figures of one map; F/3nt is NaN if no map was made."""

    distortion: float
    stretch: float
    flips: int
    rank: int  # 0 converged, 1 valid, 2 not converged, 3 flipped, 4 no map
    seconds: float


RANKS = ("converged", "valid", "not converged", "overlapping", "flipped")


def measure_map(V: np.ndarray, F: np.ndarray, uv: np.ndarray) -> tuple[float, float, int]:
    """Return F/3nt, L2 stretch and flips of a map, computed independently of the package."""
    angles, flat = igl.internal_angles(V, F), igl.internal_angles(np.column_stack((uv, np.zeros(len(uv)))), F)
    a, b, c = (uv[F[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    stretch = squared_stretch(V[F], uv[F]) * area.sum() / igl.doublearea(V, F).sum()
    l2 = float(np.sqrt(np.average(stretch, weights=igl.doublearea(V, F)))) if (area > 0).all() else np.inf
    return float(np.square(angles - flat).mean()), l2, int((area <= 0).sum())


def flat(V: np.ndarray, F: np.ndarray, method: str | LinABF, boundary: str) -> Figures:
    start = process_time()
    try:
        made = flatten(V, F, method=method, boundary=boundary, progress=False)
    except (igl_linabf.MeshError, ArithmeticError):
        return Figures(np.nan, np.nan, 0, len(RANKS), process_time() - start)
    seconds = process_time() - start
    return Figures(*measure_map(V, F, made.uv), RANKS.index(made.outcome.value), seconds)


def flatten_with_cones(
    V: np.ndarray, F: np.ndarray, cones: np.ndarray | int | str, angles: str | None = None
) -> Figures:
    start = process_time()
    try:
        atlas = unwrap(V, F, cones=Cones(cones, angles=angles), progress=False)
    except (igl_linabf.MeshError, ArithmeticError):
        return Figures(np.nan, np.nan, 0, len(RANKS), process_time() - start)
    seconds = process_time() - start
    origin = np.empty(len(atlas.TC), dtype=np.int64)
    origin[atlas.FTC] = F
    rank = max(RANKS.index(chart.result.outcome.value) for chart in atlas.charts)
    return Figures(*measure_map(V[origin], atlas.FTC, atlas.TC), rank, seconds)


def cases() -> Iterator[tuple[str, Callable[[], Figures]]]:
    """Yield the kind of each map, and a function that computes the map and returns its figures."""
    disks: list[Mesh] = list(load_shared_meshes("disk", "stress"))
    for seed in range(RANDOM):
        disks.append((f"random {seed}", *Disk.random(np.random.default_rng(seed), 400).build()))
    for _, V, F in disks:
        V, F, *_ = igl.remove_unreferenced(V, F)
        yield "linabf", partial(flat, V, F, "linabf", "free")
        yield "abf", partial(flat, V, F, "abf", "free")
        yield "guarantee", partial(flat, V, F, LinABF(guarantee="injective"), "free")
        for boundary in ("circle", "rectangle"):
            yield boundary, partial(flat, V, F, "linabf", boundary)
    for _, V, F in load_shared_meshes("holes"):
        for boundary in ("free", "circle", "circles"):
            yield f"holes, {boundary}", partial(flat, V, F, "linabf", boundary)
    for _, V, F in load_shared_meshes("closed"):
        yield "cones", partial(flatten_with_cones, V, F, find_cones(V, F, CONES))
    for kind in ("closed", "handles"):
        for _, V, F in load_shared_meshes(kind):
            for found in ("auto", 20, 30):
                yield f"quarter cones, {kind}", partial(flatten_with_cones, V, F, found, "quarter")


def run(made: list[tuple[str, Callable[[], Figures]]], patches: tuple[Patch, ...] = ()) -> list[Figures]:
    with ExitStack() as switched:
        for owner, name, instead in patches:
            switched.enter_context(patch.object(owner, name, instead))
        return [case() for _, case in made]


def find_largest_median(by_verb: dict[str, list[float]]) -> tuple[float, str]:
    """Return the largest of the medians, and its kind of map."""
    return max((float(np.median(values)), verb) for verb, values in by_verb.items())


def row(name: str, verbs: list[str], base: list[Figures], off: list[Figures]) -> str:
    """Return the table row of a mechanism: changed maps, ratios of figures and times, and a verdict."""
    ratios: dict[str, list[float]] = {}
    stretches: dict[str, list[float]] = {}
    times: dict[str, list[float]] = {}
    changed = better_outcomes = worse_outcomes = 0
    for verb, a, b in zip(verbs, base, off, strict=True):
        times.setdefault(verb, []).append(b.seconds / a.seconds)
        alike = np.isclose(a.distortion, b.distortion, rtol=1e-3, equal_nan=True)
        changed += not alike or (a.rank, a.flips) != (b.rank, b.flips)
        better_outcomes += b.rank < a.rank and a.rank > 1
        worse_outcomes += b.rank > a.rank and b.rank > 1
        if a.distortion > 1e-20 and np.isfinite(b.distortion):
            ratios.setdefault(verb, []).append(b.distortion / a.distortion)
        if np.isfinite(a.stretch + b.stretch):
            stretches.setdefault(verb, []).append(b.stretch / a.stretch)
    (ratio, of), (longer, there), (slower, slowest) = (
        find_largest_median(ratios),
        find_largest_median(stretches),
        find_largest_median(times),
    )
    verdict = "no difference"
    if max(ratio, longer) > 1.03 or worse_outcomes > better_outcomes or slower > 1.5:
        verdict = "stays"
    elif name in PROMISED:
        verdict = f"stays: {PROMISED[name]}"
    total = sum(b.seconds for b in off) / sum(a.seconds for a in base)
    medians = f"{ratio:.3f} ({of})", f"{longer:.3f} ({there})"
    cells = [name, f"{changed} of {len(base)}", *medians, f"{worse_outcomes}, {better_outcomes}"]
    return f"| {' | '.join([*cells, f'{total:.2f}', f'{slower:.2f} ({slowest})', verdict])} |"


def main() -> None:
    warnings.simplefilter("ignore")
    made = list(cases())
    verbs = [verb for verb, _ in made]
    run(made)  # warm-up: not timed
    base = run(made)
    print(
        "A mechanism is switched off in each row. The second column counts the maps that change without\n"
        "the mechanism: F/3nt by more than a thousandth, or flips or outcome. F/3nt and L2 are the\n"
        "medians of the value without the mechanism over the value with it, for the kind of map\n"
        "where they are largest. The next column counts outcomes that get worse, and outcomes that get\n"
        "better. Time is the CPU time of all maps without the mechanism divided by the time with it. The\n"
        "slowest verb is the kind of map with the largest median of this ratio. The verdict is whether\n"
        "these figures justify the mechanism, or what else breaks without it.\n"
    )
    print("| switched off | maps that change | F/3nt | L2 | worse, better | time | slowest verb | verdict |")
    print("|---" * 8 + "|")
    for name in sys.argv[1:] or MECHANISMS:
        print(row(name, verbs, base, run(made, MECHANISMS[name])), flush=True)


if __name__ == "__main__":
    main()
