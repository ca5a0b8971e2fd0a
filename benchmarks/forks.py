"""Measure the gain from each fork, a branch of the code for meshes of some sizes, for docs/performance.md.

    python benchmarks/forks.py [--repeat 9] [--print]

Each number is the time of `linabf` or `abf` without the fork divided by the time with the fork, the minimum
of several alternating runs. The numbers of inner steps are in parentheses. A fork is justified only if it
makes a whole call 1.5 times as fast, or if the maps change without it.
"""

from __future__ import annotations

import warnings
from contextlib import ExitStack
from importlib import import_module
from time import perf_counter
from unittest.mock import patch

from meshes import brain, load_shared_meshes, split_triangles
from pages import arguments, publish

from igl_linabf import flatten

NEVER = 10**9
FORKS = {
    "slivers of small meshes corrected": (("system.preconditioner", "LARGE_SYSTEM", 0),),
    "no slivers corrected": (("system.preconditioner", "LARGE_SYSTEM", NEVER),),
}
NAMES = ("igl_camel_b", "optcuts_foot_i_f10000", "optcuts_armadillo_i_f10000", "igl_lion", "igl_camelhead")
FINER = (("igl_camelhead", 2), ("igl_face", 2), ("igl_camelhead", 8))
SINGLE_RUN = 300_000  # meshes of at least as many triangles run only once


def time_map(V: object, F: object, method: str, fork: str) -> tuple[float, int]:
    """Return the seconds of one map, and the number of its inner steps."""
    with ExitStack() as patches:
        for module, name, value in FORKS.get(fork, ()):
            patches.enter_context(patch.object(import_module(f"igl_linabf.angles.{module}"), name, value))
        start = perf_counter()
        result = flatten(V, F, method=method)
        return perf_counter() - start, result.report.inner_steps


def make_row(name: str, V: object, F: object, method: str, repeat: int) -> str:
    best: dict[str, tuple[float, int]] = {}
    for _ in range(repeat if len(F) < SINGLE_RUN else 1):
        for fork in ("", *FORKS):
            result = time_map(V, F, method, fork)
            best[fork] = min(result, best.get(fork, result))
    base, steps = best[""]
    cells = [f"{seconds / base:.2f} ({inner})" for seconds, inner in (best[fork] for fork in FORKS)]
    return f"| {name} | {len(F):,} | {method} | {1000 * base:.3g} ({steps}) | {' | '.join(cells)} |"


def main() -> None:
    parser = arguments(__doc__, 9)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    known = {mesh[0]: mesh for mesh in load_shared_meshes("disk")}
    meshes = [known[name] for name in NAMES if name in known] + [brain()]
    meshes += [split_triangles(known[name], times) for name, times in FINER if name in known]
    lines = [f"| mesh | triangles | | ms | {' | '.join(FORKS)} |", f"|---|---|---|---|{'---|' * len(FORKS)}"]
    for name, V, F in meshes:
        for method in ("linabf", "abf") if len(F) < SINGLE_RUN else ("linabf",):
            lines.append(make_row(name, V, F, method, options.repeat))
    page = "`python benchmarks/forks.py`\n\n" + "\n".join(lines)
    publish("forks", page, options.printed)


if __name__ == "__main__":
    main()
