"""Run about twelve thousand hostile cases and print their outcomes as a Markdown table (docs/promises.md).

    .venv/bin/python benchmarks/fuzz.py [--cases 11834] [--first 0] [--only unwrap]

The exit code is 1 if a promise is broken. The failing cases are listed on stderr.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from fuzzing import KINDS, run


def summarize(count: Counter[str]) -> str:
    """Return the counts of the outcomes as text, without the messages of refusals."""
    short: Counter[str] = Counter()
    for end, number in count.items():
        short[end.split(":")[0]] += number
    return ", ".join(f"{number:,} {end}" for end, number in short.most_common())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=11_834)
    parser.add_argument("--first", type=int, default=0, help="seed of the first case of each kind")
    parser.add_argument("--only", default="", help="run only the kinds whose names start with this")
    options = parser.parse_args()
    kinds = {name: kind for name, kind in KINDS.items() if name.strip("`").startswith(options.only)}
    total = sum(share for _, share in kinds.values())
    seeds = {
        kind: range(options.first, options.first + max(1, share * options.cases // total))
        for kind, (_, share) in kinds.items()
    }
    with ThreadPoolExecutor(2) as pool:
        results = dict(zip(seeds, pool.map(run, seeds, seeds.values()), strict=True))
    print("| kind of case | number | how they end | crashes, NaN, other broken promises |")
    print("|---|---|---|---|")
    for kind, (count, broken) in results.items():
        print(f"| {kind} | {len(seeds[kind]):,} | {summarize(count)} | {len(broken)} |")
    failures = [line for _, broken in results.values() for line in broken]
    print(f"| all | {sum(map(len, seeds.values())):,} | | {len(failures)} |")
    print(*failures, sep="\n", file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
