"""What a worker does: one mesh from its file to its map's file, and the row that tells of it."""

import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import sha256
from importlib import metadata
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import psutil

from .._types import FloatArray
from ..charts import Atlas, Cones, Packing, Seams, unwrap
from ..cortex import flatten_hemisphere, write_hemisphere
from ..errors import MemoryLimitError, MeshError, OutcomeWarning
from ..flattening import BoundaryName, Method, Outcome, flatten
from ..io import MeshFile, lies_flat, read_file, unit_square, write_atomically
from ..measures import Quality, quality
from . import places
from .table import FAILED, FAULTY, OUT_OF_MEMORY, OVERLAPPING, REFUSED, UNREADABLE, VALID, Row, write_down

How = Literal["unwrap", "flatten", "cortex"]
Scale = Literal["square", "mesh"]  # what `batch` calls units
OF_UNWRAP = ("seams", "cones", "packing")

_one_at_a_time = threading.Lock()  # the limit of memory and the warnings are the process's


@dataclass(frozen=True)
class Settings:
    """What is done to every mesh: the arguments of `batch`."""

    how: How
    method: Method
    format: str
    seams: Seams | None = None
    cones: Cones | None = None
    packing: Packing | None = None
    boundary: BoundaryName = "free"
    units: Scale | None = None
    memory: int | None = None

    def key(self, version: str) -> str:
        """Of a version of a file. The memory makes no difference to a map."""
        told = repr((version, replace(self, memory=None), metadata.version("igl-linabf")))
        return sha256(told.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Task:
    """An input, and the row that it has before it is done."""

    place: str
    row: Row
    folder: str
    settings: Settings


Made = tuple[FloatArray, Any, Row]
"""A map to write, its rows at the corners in the shape of the faces or None, and what the row says of it."""


def run(task: Task) -> Row:
    """Flatten the mesh of a task; what is wrong with it is in the row.

    Raises
    ------
    OSError
        The map cannot be written: the run had better end.
    """
    start = perf_counter()
    with _one_at_a_time, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", OutcomeWarning)  # what they say is the message
        row = _row_of(task)
    told = dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, UserWarning))
    message = " ".join("; ".join(filter(None, (row.message, *told))).split())
    row = replace(row, message=message, seconds=perf_counter() - start)
    write_down(row, task.folder)
    return row


def _row_of(task: Task) -> Row:
    row, writing = task.row, False
    try:
        with _limited(task.settings.memory):
            try:
                if task.settings.how == "cortex":
                    return _flat_hemisphere(task)
                with places.fetched(task.place) as local:
                    mesh = read_file(local)
            except OSError as error:
                return replace(row, outcome=UNREADABLE, message=error.strerror or str(error))
            row = replace(row, triangles=len(mesh.triangles))
            made = _unwrap_file if task.settings.how == "unwrap" else _flatten_file
            TC, FTC, done = made(mesh, row, task.settings)
            writing = True
            with places.destination(places.joined(task.folder, row.output)) as path:
                # the plan has seen what is there; names of other files lead nowhere from a URL
                folder = mesh.path.parent if mesh.path and places.is_url(task.folder) else None
                with write_atomically(path, mesh, TC, FTC, force=True, folder=folder):
                    pass
            return done
    except (MemoryError, MemoryLimitError) as error:
        return replace(row, outcome=OUT_OF_MEMORY, message=str(error) or "not enough memory")
    except MeshError as error:
        return replace(row, outcome=REFUSED, message=str(error))
    except Exception as error:
        if writing:  # the disk is full, or the folder has gone: so it will be for all others
            raise
        return replace(row, outcome=FAILED, message=f"{type(error).__name__}: {error}")


def _unwrap_file(mesh: MeshFile, row: Row, settings: Settings) -> Made:
    chosen = {name: getattr(settings, name) for name in OF_UNWRAP}
    atlas = unwrap(mesh.V, mesh.F, method=settings.method, progress=False, **chosen)
    outcome, message = _outcome_of(atlas), "; ".join(atlas.troubles)
    told = replace(row, outcome=outcome, message=message, charts=len(atlas.charts))
    TC = atlas.flat / atlas.scale if lies_flat(row.output) else atlas.TC
    return TC, atlas.FTC, _with_quality(told, atlas.quality)


def _outcome_of(atlas: Atlas) -> str:
    if atlas.good:
        return VALID
    if atlas.quality.flips or any(not chart.result.outcome.good for chart in atlas.charts):
        return Outcome.FLIPPED.value
    return OVERLAPPING if any(chart.overlapping for chart in atlas.charts) else FAULTY


def _flatten_file(mesh: MeshFile, row: Row, settings: Settings) -> Made:
    V, F = mesh.V, mesh.triangles
    result = flatten(V, F, settings.method, boundary=settings.boundary, progress=False)
    units = settings.units or ("mesh" if lies_flat(row.output) else "square")
    uv = unit_square(result.uv) if units == "square" else result.uv
    measured = quality(V, F, uv)
    outcome, message = result.outcome, "" if result.outcome.good else result.message
    if outcome.good and measured.flips:
        outcome, message = Outcome.FLIPPED, "the map's scale varies too much for the unit square: unwrap it"
    told = replace(row, outcome=outcome.value, message=message, charts=1)
    return uv, None, _with_quality(told, measured)


def _flat_hemisphere(task: Task) -> Row:
    """Flatten the hemisphere of a subject whose registered sphere is the task's place, and write it."""
    sphere = Path(task.place)
    name = places.hemisphere_of(task.place)
    flat = flatten_hemisphere(sphere.parents[1], name, task.settings.method, progress=False)
    folder = places.joined(task.folder, task.row.output.rpartition("/")[0])
    write_hemisphere(folder, flat)
    outcome = OVERLAPPING if flat.quality.overlaps else flat.result.outcome.value
    message = "" if flat.good else flat.result.message
    row = replace(task.row, outcome=outcome, message=message, triangles=len(flat.F), charts=1)
    return _with_quality(row, flat.quality)


def _with_quality(row: Row, of: Quality) -> Row:
    return replace(row, angle_distortion=of.angle_distortion, stretch=of.stretch_l2, flips=of.flips)


@contextmanager
def _limited(memory: int | None) -> Iterator[None]:
    """Let the process have so many bytes more than it has now, where the system can hold it to that."""
    if memory is None or sys.platform == "win32":
        yield
        return
    import resource

    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = psutil.Process().memory_info().vms + memory
    resource.setrlimit(
        resource.RLIMIT_AS, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard)
    )
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))


def dask_setup(worker: object) -> None:
    """Dask calls it where a worker of a local cluster starts: Ctrl-C is for the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
