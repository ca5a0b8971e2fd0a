"""`igl-linabf batch`."""

from __future__ import annotations

import argparse

from ..batch_runs import batch
from ..io import SUFFIXES
from .commands import GOOD, METHOD, NOT_VALID, Command
from .unwrapping import BIJECTIVE, HOLES, TRADED


def _batch(options: argparse.Namespace) -> int:
    chosen = {name: getattr(options, name) for name in BATCH.arguments if name not in ("inputs", "folder")}
    done = batch(options.inputs, options.output, **chosen)
    print(done, flush=True)
    options.settled()
    return GOOD if done.good else NOT_VALID


BATCH = Command(
    "batch",
    _batch,
    "unwrap many files on all cores or a cluster; started again, go on",
    {
        "inputs": {
            "metavar": "IN",
            "nargs": "+",
            "help": "mesh files, folders of them, globs in quotes, URLs",
        },
        "folder": {
            "metavar": "OUT",
            "required": True,
            "help": "folder of the maps and of results.csv; a batch that was stopped goes on there",
        },
        "workers": {"metavar": "N", "type": int, "help": "processes on this machine (default: one a core)"},
        "scheduler": {"metavar": "ADDRESS", "help": "use the workers of this Dask scheduler instead"},
        "how": {
            "choices": ("unwrap", "flatten"),
            "default": "unwrap",
            "help": "with seams, or disks as they are (default: %(default)s)",
        },
        "method": METHOD,
        "format": {"choices": [suffix[1:] for suffix in SUFFIXES], "default": "obj", "help": "of the maps"},
        "memory": {"metavar": "SIZE", "help": "what one mesh may take, like 2GiB"},
        "trade": TRADED,
        "holes": HOLES,
        "bijective": BIJECTIVE,
        "retry": {"action": "store_true", "help": "do again what died, ran out of memory or failed before"},
    },
    "Unwrap many files, with Dask. Exit code 1: done, but not every mesh has a map without flips and "
    "overlaps; results.csv says which and why.",
    (
        "scans/ -o maps/",
        "scans/ 'more/**/*.ply' -o maps/ --workers 4 --format glb --memory 4GiB",
        "heads/ -o maps/ --how flatten --method abf",
        "scans/ -o maps/ --trade 30 --holes --bijective",
        "scans/ -o maps/ --retry    # what died before",
        "scans/ -o maps/ --scheduler tcp://10.0.0.1:8786",
    ),
)
