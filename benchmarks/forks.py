"""Write into docs/performance.md what forks by size on the way of a map bring: a map with each switched off.

    python benchmarks/forks.py [--repeat 9] [--print]

A number is the time of `linabf` or `abf` with the fork switched, over that without, the least of several
runs that take turns; in brackets the inner steps. By the rule of the project a fork stays only where it makes
a whole verb 1.5 times as fast, or where maps would change without it.
"""

from __future__ import annotations

import warnings
from contextlib import ExitStack
from importlib import import_module
from time import perf_counter
from unittest.mock import patch

from meshes import brain, divided, shared
from pages import arguments, publish

from igl_linabf import flatten

NEVER = 10**9
FORKS = {
    "slivers of small meshes corrected": (("system.preconditioner", "LARGE_SYSTEM", 0),),
    "no slivers corrected": (("system.preconditioner", "LARGE_SYSTEM", NEVER),),
}
NAMES = ("igl_camel_b", "optcuts_foot_i_f10000", "optcuts_armadillo_i_f10000", "igl_lion", "igl_camelhead")
FINER = (("igl_camelhead", 2), ("igl_face", 2), ("igl_camelhead", 8))
FEW = 300_000  # triangles from which one run has to do


def seconds(V: object, F: object, method: str, fork: str) -> tuple[float, int]:
    """Of one map, and its inner steps."""
    with ExitStack() as switched:
        for module, name, value in FORKS.get(fork, ()):
            switched.enter_context(patch.object(import_module(f"igl_linabf.angles.{module}"), name, value))
        start = perf_counter()
        result = flatten(V, F, method)
        return perf_counter() - start, result.inner_steps


def row(name: str, V: object, F: object, method: str, repeat: int) -> str:
    least: dict[str, tuple[float, int]] = {}
    for _ in range(repeat if len(F) < FEW else 1):
        for fork in ("", *FORKS):
            made = seconds(V, F, method, fork)
            least[fork] = min(made, least.get(fork, made))
    base, steps = least[""]
    cells = [f"{taken / base:.2f} ({inner})" for taken, inner in (least[fork] for fork in FORKS)]
    return f"| {name} | {len(F):,} | {method} | {1000 * base:.3g} ({steps}) | {' | '.join(cells)} |"


def main() -> None:
    parser = arguments(__doc__, 9)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    known = {mesh[0]: mesh for mesh in shared("disk")}
    meshes = [known[name] for name in NAMES if name in known] + [brain()]
    meshes += [divided(known[name], times) for name, times in FINER if name in known]
    lines = [f"| mesh | triangles | | ms | {' | '.join(FORKS)} |", f"|---|---|---|---|{'---|' * len(FORKS)}"]
    for name, V, F in meshes:
        for method in ("linabf", "abf") if len(F) < FEW else ("linabf",):
            lines.append(row(name, V, F, method, options.repeat))
    page = "`python benchmarks/forks.py`\n\n" + "\n".join(lines)
    publish("forks", page, options.printed)


if __name__ == "__main__":
    main()
