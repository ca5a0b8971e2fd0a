"""`igl-linabf batch`."""

from __future__ import annotations

import argparse

from ..batch_runs import batch
from ..io import SUFFIXES
from .commands import BOUNDARY, CONES, GOOD, METHOD, NOT_VALID, Command, count_of_cones
from .packing import PACKING
from .unwrapping import BIJECTIVE, HOLES, TRADED


def _batch(options: argparse.Namespace) -> int:
    names = [name.replace("-", "_") for name in BATCH.arguments if name not in ("inputs", "folder", "cones")]
    chosen = {name: getattr(options, name) for name in names} | {"cones": count_of_cones(options.cones)}
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
        "boundary": BOUNDARY,
        "cones": CONES,
        "cone-angles": {"choices": ("quarter",), "help": "in quarter turns (default: of one scale)"},
        "resolution": PACKING["resolution"],
        "padding": PACKING["padding"],
        "retry": {"action": "store_true", "help": "do again what died, ran out of memory or failed before"},
    },
    "Unwrap many files, with Dask. Exit code 1: done, but not every mesh has a map without flips and "
    "overlaps; results.csv says which and why.",
    (
        "scans/ -o maps/",
        "scans/ 'more/**/*.ply' -o maps/ --workers 4 --format glb --memory 4GiB",
        "heads/ -o maps/ --how flatten --method abf --boundary circle",
        "bodies/ -o maps/ --cones auto --cone-angles quarter",
        "scans/ -o maps/ --resolution 1024 --padding 4    # charts at least 4 texels apart",
        "scans/ -o maps/ --trade 30 --holes --bijective",
        "scans/ -o maps/ --retry    # what died before",
        "scans/ -o maps/ --scheduler tcp://10.0.0.1:8786",
    ),
)
