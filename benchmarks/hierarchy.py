"""Bound the gain of a coarse-to-fine hierarchy: restart ABF from its own solution, and time decimation.

    python benchmarks/hierarchy.py [--repeat 5] [--large] [--print]

HABF++ (Sheffer et al. 2005) solves a decimated mesh first, and starts the fine mesh from its angles. No start
is better than the solution itself. Therefore the time of a restart from the solution, which only has to
detect convergence, is a lower bound for every hierarchy. Decimation takes additional time. Times are CPU
times, medians of alternating runs, relative to the whole call. The table goes to docs/performance.md, or is
printed.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from time import process_time

import igl
import numpy as np
from meshes import Mesh, brain, load_shared_meshes, subdivide
from pages import DOCS, replace_between_marks

from igl_linabf import ABF, LinABF, flatten
from igl_linabf.flattening import Flattening, methods
from igl_linabf.flattening.fallbacks import Problem, set_up_problem
from igl_linabf.surface import planar_mesh

HARD = ("optcuts_golf", "flipfree_deer", "optcuts_male_body_i_f10000")


@dataclass(frozen=True, eq=False)
class ProblemAtAngles(Problem):
    """A problem whose steps start at given angles; its objective keeps the usual initial estimate."""

    angles_given: np.ndarray | None = None

    @property
    def start(self):
        state = super().start
        return replace(state, at=self.angles.evaluate(self.angles_given))


def restart(V: np.ndarray, F: np.ndarray, method: ABF | LinABF, solution: Flattening) -> Flattening:
    """Run a method again, starting from the angles of its solution."""
    given = np.ascontiguousarray(solution.angles.T)

    def make_problem(*args, **options) -> Problem:
        problem = set_up_problem(*args, **options)
        return ProblemAtAngles(
            **{name: getattr(problem, name) for name in Problem.__annotations__}, angles_given=given
        )

    methods.set_up_problem = make_problem
    try:
        return method.run(planar_mesh(V, F), None)
    finally:
        methods.set_up_problem = set_up_problem


def time_call(call: Callable[[], object]) -> float:
    start = process_time()
    call()
    return process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--large", action="store_true", help="include 827 k triangles")
    parser.add_argument("--print", action="store_true", dest="printed")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    chosen: list[Mesh] = [brain()]
    for mesh in load_shared_meshes("disk"):
        if mesh[0] in ("igl_lion", "igl_camelhead", "igl_face"):
            chosen.append(mesh)
        if mesh[0] == "igl_face":
            chosen.append(subdivide(mesh, 1))
            if options.large:
                chosen.append(subdivide(mesh, 2))
    chosen += [mesh for mesh in load_shared_meshes("stress") if mesh[0] in HARD]
    rows = [
        "| mesh | triangles | method | steps | steps from the solution | time from there "
        "| igl.qslim to a quarter | gain at most | with decimation |",
        "|---" * 9 + "|",
    ]
    for name, V, F in chosen:
        decimation = np.median(
            [time_call(partial(igl.qslim, V, F, len(F) // 4)) for _ in range(min(options.repeat, 3))]
        )
        for label, method in (("abf", ABF()), ("linabf", LinABF())):
            if label == "linabf" and name not in HARD:
                continue
            solution = flatten(V, F, method=method)
            restarted = restart(V, F, method, solution)
            calls = partial(flatten, V, F, method=method), partial(restart, V, F, method, solution)
            runs = np.array([[time_call(call) for call in calls] for _ in range(options.repeat)])
            all_, remaining = np.median(runs, axis=0)
            steps = [
                sum(step.inner_steps for step in result.report.steps) for result in (solution, restarted)
            ]
            rows.append(
                f"| {name} | {len(F):,} | {label} | {len(solution.report.steps)}, {steps[0]} inner | "
                f"{len(restarted.report.steps)}, {steps[1]} inner | "
                f"{remaining / all_:.2f} | {decimation / all_:.2f} | "
                f"{all_ / remaining:.1f} | {all_ / (remaining + decimation):.1f} |"
            )
            print(rows[-1], file=sys.stderr, flush=True)
    if options.printed:
        print("\n".join(rows))
    else:
        replace_between_marks(DOCS / "performance.md", "hierarchy", "\n".join(rows))


if __name__ == "__main__":
    main()
