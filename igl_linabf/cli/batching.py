"""The command `igl-linabf batch`."""

import argparse
from typing import Any

from ..batch import flatten_files
from ..charts import ChartOptions, Cones, Packing
from ..flattening import METHODS
from ..io import SUFFIXES
from .arguments import choice, shared_arguments, switch, value
from .commands import Command, ExitCode, build_from_options, parse_auto_or_number


def _batch(options: argparse.Namespace) -> int:
    names = (
        *("workers", "scheduler", "how", "method", "format", "memory", "boundary", "units"),
        *("retry", "force"),
    )
    chosen = {name: getattr(options, name) for name in names}
    cones: Any = parse_auto_or_number("cones", options.cones)
    if options.cone_angles is not None:
        if cones is None:
            raise ValueError("--cone-angles needs cones: give --cones, too")
        cones = Cones(cones, angles=options.cone_angles)
    charts, packing = build_from_options(ChartOptions, options), build_from_options(Packing, options)
    done = flatten_files(
        options.inputs, options.output, charts=charts, cones=cones, packing=packing, **chosen
    )
    print(done, flush=True)
    options.on_commit()
    return ExitCode.GOOD if done.good else ExitCode.NOT_VALID


BATCH = Command(
    "batch",
    _batch,
    "unwrap many files on all cores or a cluster; a second run resumes an interrupted one",
    {
        "inputs": value("IN", "mesh files, folders of them, globs in quotes, URLs", nargs="+"),
        "folder": value(
            "OUT", "folder for the maps and results.csv; an interrupted batch resumes there", required=True
        ),
        "workers": value("N", "processes on this machine (default: one per core)", int),
        "scheduler": value("ADDRESS", "use the workers of this Dask scheduler instead"),
        "how": choice(
            ("unwrap", "flatten", "cortex"),
            "unwrap",
            "unwrap: with seams; flatten: disks only; cortex: FreeSurfer subjects",
        ),
        "method": choice(sorted(METHODS), help="method (default: linabf; isometric for cortices)"),
        "format": choice((suffix[1:] for suffix in SUFFIXES), "obj", "file format of the maps"),
        "memory": value("SIZE", "memory limit of one mesh, such as 2GiB"),
        **shared_arguments("trade", "keep-holes", "repair-overlaps", "boundary", "units", "cones"),
        "cone-angles": choice(
            ("quarter",),
            help="cone angles in quarter turns (default: those with the same scale at all cones)",
        ),
        **shared_arguments("resolution", "padding", "unseen"),
        "retry": switch("retry meshes that died, ran out of memory or failed before"),
        "force": switch("replace files in OUT that were not written by a batch"),
    },
    "Unwrap many files, with Dask. Exit code 1: finished, but some maps are missing or have flips or "
    "overlaps; results.csv lists the reasons.",
    (
        "scans/ -o maps/",
        "scans/ 'more/**/*.ply' -o maps/ --workers 4 --format glb --memory 4GiB",
        "heads/ -o maps/ --how flatten --method abf --boundary circle",
        "scans/ -o maps/ --how flatten --units mesh    # in the meshes' units of length",
        "bodies/ -o maps/ --cones auto --cone-angles quarter",
        "scans/ -o maps/ --resolution 1024 --padding 4    # charts at least 4 texels apart",
        "scans/ -o maps/ --trade 30 --keep-holes --repair-overlaps",
        "scans/ -o maps/ --resolution 1024 --unseen 0.25    # fewer texels for cavities",
        "$SUBJECTS_DIR -o flat/ --how cortex --workers 8    # a folder for each subject",
        "scans/ -o maps/ --retry    # meshes that died before",
        "scans/ -o maps/ --force    # replaces maps from other programs",
        "scans/ -o maps/ --scheduler tcp://10.0.0.1:8786",
    ),
)
