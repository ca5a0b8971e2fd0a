"""What coarse to fine could save: ABF and the fallbacks from their own solution, and what decimation costs.

    python benchmarks/hierarchy.py [--repeat 5] [--large] [--print]

HABF++ (Sheffer et al. 2005) carries the angles of a decimated mesh up as the start of the finer one. No such
start is better than the solution itself. So the time from there, which still has to find that it is one, is
the least that any hierarchy leaves. Decimation comes on top. Times are of the processor, medians of
alternating runs, relative to the whole call. The table goes to docs/performance.md, or is printed.
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
from meshes import Mesh, brain, shared, subdivided
from pages import DOCS, put

from igl_linabf import ABF, Flattening, LinABF, flatten
from igl_linabf.flattening import methods
from igl_linabf.flattening.fallbacks import Problem, initial_problem
from igl_linabf.surface import planar_mesh

HARD = ("optcuts_golf", "flipfree_deer", "optcuts_male_body_i_f10000")


@dataclass(frozen=True, eq=False)
class Started(Problem):
    """A problem that starts at given angles, with the initial estimate as it is."""

    angles_given: np.ndarray | None = None

    @property
    def start(self):
        state = super().start
        return replace(state, at=self.angles.at(self.angles_given))


def from_solution(V: np.ndarray, F: np.ndarray, method: ABF | LinABF, solution: Flattening) -> Flattening:
    """The method again, from the angles that it ends with."""
    given = np.ascontiguousarray(solution.angles.T)

    def started(*args, **options) -> Problem:
        problem = initial_problem(*args, **options)
        return Started(
            **{name: getattr(problem, name) for name in Problem.__annotations__}, angles_given=given
        )

    methods.initial_problem = started
    try:
        return method.run(planar_mesh(V, F), None)
    finally:
        methods.initial_problem = initial_problem


def seconds(call: Callable[[], object]) -> float:
    start = process_time()
    call()
    return process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--large", action="store_true", help="827 k triangles as well")
    parser.add_argument("--print", action="store_true", dest="printed")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    chosen: list[Mesh] = [brain()]
    for mesh in shared("disk"):
        if mesh[0] in ("igl_lion", "igl_camelhead", "igl_face"):
            chosen.append(mesh)
        if mesh[0] == "igl_face":
            chosen.append(subdivided(mesh, 1))
            if options.large:
                chosen.append(subdivided(mesh, 2))
    chosen += [mesh for mesh in shared("stress") if mesh[0] in HARD]
    rows = [
        "| mesh | triangles | method | steps | steps from the solution | time from there "
        "| igl.qslim to a quarter | gain at most | with decimation |",
        "|---" * 9 + "|",
    ]
    for name, V, F in chosen:
        decimation = np.median(
            [seconds(partial(igl.qslim, V, F, len(F) // 4)) for _ in range(min(options.repeat, 3))]
        )
        for label, method in (("abf", ABF()), ("linabf", LinABF())):
            if label == "linabf" and name not in HARD:
                continue
            whole = flatten(V, F, method)
            again = from_solution(V, F, method, whole)
            calls = partial(flatten, V, F, method), partial(from_solution, V, F, method, whole)
            runs = np.array([[seconds(call) for call in calls] for _ in range(options.repeat)])
            all_, left = np.median(runs, axis=0)
            steps = [sum(step.inner_steps for step in made.steps) for made in (whole, again)]
            rows.append(
                f"| {name} | {len(F):,} | {label} | {len(whole.steps)}, {steps[0]} inner | "
                f"{len(again.steps)}, {steps[1]} inner | {left / all_:.2f} | {decimation / all_:.2f} | "
                f"{all_ / left:.1f} | {all_ / (left + decimation):.1f} |"
            )
            print(rows[-1], file=sys.stderr, flush=True)
    if options.printed:
        print("\n".join(rows))
    else:
        put(DOCS / "performance.md", "hierarchy", "\n".join(rows))


if __name__ == "__main__":
    main()
