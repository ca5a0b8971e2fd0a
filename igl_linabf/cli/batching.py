"""`igl-linabf batch`."""

import argparse
from typing import Any

from ..batch_runs import batch
from ..charts import Cones, Packing, Seams
from ..flattening import METHODS
from ..io import SUFFIXES
from .arguments import choice, shared, switch, value
from .commands import Command, ExitCode, auto_or_number, options_as


def _batch(options: argparse.Namespace) -> int:
    names = (
        *("workers", "scheduler", "how", "method", "format", "memory", "boundary", "units"),
        *("retry", "force"),
    )
    chosen = {name: getattr(options, name) for name in names}
    cones: Any = auto_or_number("cones", options.cones)
    if options.cone_angles is not None:
        if cones is None:
            raise ValueError("--cone-angles are those of cones: give --cones, too")
        cones = Cones(cones, angles=options.cone_angles)
    seams, packing = options_as(Seams, options), options_as(Packing, options)
    done = batch(options.inputs, options.output, seams=seams, cones=cones, packing=packing, **chosen)
    print(done, flush=True)
    options.settled()
    return ExitCode.GOOD if done.good else ExitCode.NOT_VALID


BATCH = Command(
    "batch",
    _batch,
    "unwrap many files on all cores or a cluster; started again, go on",
    {
        "inputs": value("IN", "mesh files, folders of them, globs in quotes, URLs", nargs="+"),
        "folder": value(
            "OUT", "folder of maps and of results.csv; a batch that was stopped goes on there", required=True
        ),
        "workers": value("N", "processes on this machine (default: one a core)", int),
        "scheduler": value("ADDRESS", "use the workers of this Dask scheduler instead"),
        "how": choice(
            ("unwrap", "flatten", "cortex"), "unwrap", "with seams; disks as they are; or FreeSurfer subjects"
        ),
        "method": choice(sorted(METHODS), help="(default: linabf; isometric for cortices)"),
        "format": choice((suffix[1:] for suffix in SUFFIXES), "obj", "of the maps"),
        "memory": value("SIZE", "what one mesh may take, like 2GiB"),
        **shared("trade", "holes", "bijective", "boundary", "units", "cones"),
        "cone-angles": choice(("quarter",), help="in quarter turns (default: of one scale)"),
        **shared("resolution", "padding", "unseen"),
        "retry": switch("do again what died, ran out of memory or failed before"),
        "force": switch("replace files in OUT that no batch has written"),
    },
    "Unwrap many files, with Dask. Exit code 1: done, but not every mesh has a map without flips and "
    "overlaps; results.csv says which and why.",
    (
        "scans/ -o maps/",
        "scans/ 'more/**/*.ply' -o maps/ --workers 4 --format glb --memory 4GiB",
        "heads/ -o maps/ --how flatten --method abf --boundary circle",
        "scans/ -o maps/ --how flatten --units mesh    # in the meshes' units of length",
        "bodies/ -o maps/ --cones auto --cone-angles quarter",
        "scans/ -o maps/ --resolution 1024 --padding 4    # charts at least 4 texels apart",
        "scans/ -o maps/ --trade 30 --holes --bijective",
        "scans/ -o maps/ --resolution 1024 --unseen 0.25    # fewer texels for cavities",
        "$SUBJECTS_DIR -o flat/ --how cortex --workers 8    # a folder for each subject",
        "scans/ -o maps/ --retry    # what died before",
        "scans/ -o maps/ --force    # replaces maps that something else has written",
        "scans/ -o maps/ --scheduler tcp://10.0.0.1:8786",
    ),
)
