"""Process one mesh in a worker: flatten the file, write the map, and return the row of the table."""

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
from ..charts import Atlas, ChartOptions, Cones, unwrap
from ..cortex import flatten_hemisphere, write_hemisphere
from ..errors import MemoryLimitError, MeshError, OutcomeWarning
from ..flattening import BoundaryName, Method, Outcome, flatten
from ..io import MeshFile, is_flat_format, read_file, unit_square, write_atomically
from ..measures import Quality, quality
from . import places
from .baking import BakedPacking, bake_images, check_contents
from .file_contents import find_texture_seams, get_material_labels, warn_of_missing_coordinates
from .table import (
    FAILED,
    FAULTY,
    OUT_OF_MEMORY,
    OVERLAPPING,
    REFUSED,
    UNREADABLE,
    VALID,
    Row,
    append_to_journal,
)

How = Literal["unwrap", "flatten", "cortex"]
SeamSource = Literal["auto", "uv"]  # values of the parameter `seams` of `flatten_files`
Scale = Literal["square", "mesh"]  # values of the parameter `units` of `flatten_files`
UNWRAP_OPTIONS = ("charts", "cones", "packing", "weld", "strict", "seams", "keep_materials", "texcoord")

DEFAULT_PACKING = BakedPacking()

_process_lock = threading.Lock()  # needed because the memory limit and the warning filters are global


@dataclass(frozen=True)
class Settings:
    """The arguments of `flatten_files` that are common to all meshes."""

    how: How
    method: Method
    format: str
    charts: ChartOptions | None = None
    cones: Cones | None = None
    packing: BakedPacking = DEFAULT_PACKING
    weld: float | Literal[False] | None = None
    strict: bool = False
    seams: SeamSource = "auto"
    keep_materials: bool = False
    texcoord: Literal[0, 1] = 0
    boundary: BoundaryName = "free"
    units: Scale | None = None
    allow_outside: bool = False
    memory: int | None = None

    def hash_with_file_version(self, version: str) -> str:
        """Return a hash of the file's version, the settings without `memory`, and the package version."""
        text = repr((version, replace(self, memory=None), metadata.version("igl-linabf")))
        return sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Task:
    """An input to process, and its row in the table before processing."""

    place: str
    row: Row
    folder: str
    settings: Settings


@dataclass(frozen=True)
class FlatMesh:
    """A map with the index of its row at each corner of the faces, the baked image, and the table's row."""

    TC: FloatArray
    FTC: Any
    row: Row
    image: Any = None


def run_task(task: Task) -> Row:
    """Flatten the mesh of a task and return its row, which also records errors of the mesh.

    Raises
    ------
    OSError
        The map cannot be written. In that case the whole run should end.
    """
    start = perf_counter()
    with _process_lock, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", OutcomeWarning)  # the row has the same message as the warning
        row = _process_task(task)
    texts = dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, UserWarning))
    message = " ".join("; ".join(filter(None, (row.message, *texts))).split())
    row = replace(row, message=message, seconds=perf_counter() - start)
    append_to_journal(row, task.folder)
    return row


def _process_task(task: Task) -> Row:
    """Flatten and write the mesh of a task, and return its row with the outcome."""
    row, writing = task.row, False
    try:
        with _limit_memory(task.settings.memory):
            try:
                if task.settings.how == "cortex":
                    return _flatten_hemisphere(task)
                mesh = _read_input(task.place, task.settings.allow_outside)
            except OSError as error:
                return replace(row, outcome=UNREADABLE, message=error.strerror or str(error))
            row = replace(row, triangles=len(mesh.triangles))
            flatten_file = _unwrap_file if task.settings.how == "unwrap" else _flatten_file
            flat = flatten_file(mesh, row, task.settings)
            writing = True
            with places.prepare_destination(places.join_path(task.folder, row.output)) as path:
                # force: existing files were checked when the batch was planned
                # folder: at a URL, references to other files must be relative to the local mesh
                folder = mesh.path.parent if mesh.path and places.is_url(task.folder) else None
                options: dict[str, Any] = {"folder": folder, "texcoord": task.settings.texcoord}
                with write_atomically(path, mesh, flat.TC, flat.FTC, flat.image, force=True, **options):
                    pass
            return flat.row
    except (MemoryError, MemoryLimitError) as error:
        return replace(row, outcome=OUT_OF_MEMORY, message=str(error) or "not enough memory")
    except MeshError as error:
        return replace(row, outcome=REFUSED, message=str(error))
    except Exception as error:
        if writing:  # an error while writing, such as a full disk, affects all meshes
            raise
        return replace(row, outcome=FAILED, message=f"{type(error).__name__}: {error}")


def _read_input(place: str, allow_outside: bool) -> MeshFile:
    """Read an input mesh; raise a `MeshError` also for a file of an unknown format."""
    with places.fetch_file(place) as local:
        try:
            return read_file(local, partial=True, allow_outside=allow_outside)
        except (MeshError, MemoryLimitError):
            raise
        except ValueError as error:
            raise MeshError(str(error)) from None


def _unwrap_file(mesh: MeshFile, row: Row, settings: Settings) -> FlatMesh:
    charts, packing, seams = settings.charts, settings.packing, None
    check_contents(mesh, packing, settings.texcoord)
    warn_of_missing_coordinates(mesh, packing.bake, settings.texcoord, settings.seams)
    if settings.seams == "uv":
        seams = find_texture_seams(mesh, charts, settings.method)
    if settings.keep_materials and mesh.extras.materials is not None:
        charts = replace(charts or ChartOptions(), labels=get_material_labels(mesh))
    atlas = unwrap(
        mesh.V,
        mesh.F,
        seams,
        charts=charts,
        method=settings.method,
        cones=settings.cones,
        packing=packing,
        weld=settings.weld,
        strict=settings.strict,
        progress=False,
    )
    outcome, message = _classify_atlas(atlas), "; ".join(atlas.troubles)
    row = replace(row, outcome=outcome, message=message, charts=len(atlas.charts))
    TC = atlas.flat / atlas.report.scale if is_flat_format(row.output) else atlas.TC
    image = bake_images(packing, mesh, atlas, Path(row.output))
    return FlatMesh(TC, atlas.FTC, _add_quality(row, atlas.quality), image)


def _classify_atlas(atlas: Atlas) -> str:
    """Return the outcome of an atlas, as a value of the column "outcome" of the table."""
    if atlas.good:
        return VALID
    outcomes = {chart.result.outcome for chart in atlas.charts}
    if atlas.quality.flips or outcomes & {Outcome.FLIPPED, Outcome.ANGLES_INVALID}:
        return Outcome.FLIPPED.value
    return OVERLAPPING if any(chart.overlapping for chart in atlas.charts) else FAULTY


def _flatten_file(mesh: MeshFile, row: Row, settings: Settings) -> FlatMesh:
    V, F = mesh.V, mesh.triangles
    result = flatten(V, F, method=settings.method, boundary=settings.boundary, progress=False)
    units = settings.units or ("mesh" if is_flat_format(row.output) else "square")
    uv = unit_square(result.uv) if units == "square" else result.uv
    measured = quality(V, F, uv)
    outcome, message = result.outcome, "" if result.outcome.good else result.message
    if outcome.good and measured.flips:
        outcome, message = Outcome.FLIPPED, "the map's scale varies too much for the unit square: unwrap it"
    row = replace(row, outcome=outcome.value, message=message, charts=1)
    return FlatMesh(uv, None, _add_quality(row, measured))


def _flatten_hemisphere(task: Task) -> Row:
    """Flatten and write a hemisphere; `task.place` is the path of its registered sphere."""
    sphere = Path(task.place)
    name = places.get_hemisphere(task.place)
    flat = flatten_hemisphere(sphere.parents[1], name, method=task.settings.method, progress=False)
    folder = places.join_path(task.folder, task.row.output.rpartition("/")[0])
    write_hemisphere(folder, flat)
    outcome = OVERLAPPING if flat.quality.overlaps else flat.result.outcome.value
    message = "" if flat.good else flat.result.message
    row = replace(task.row, outcome=outcome, message=message, triangles=len(flat.F), charts=1)
    return _add_quality(row, flat.quality)


def _add_quality(row: Row, of: Quality) -> Row:
    return replace(row, angle_distortion=of.angle_distortion, stretch=of.stretch_l2, flips=of.flips)


@contextmanager
def _limit_memory(memory: int | None) -> Iterator[None]:
    """Limit the process to `memory` more bytes than it uses now, except on Windows."""
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


def dask_setup(worker: Any) -> None:
    """Prepare a worker; Dask calls this function when the worker starts.

    The worker ignores Ctrl-C, because its parent process handles Ctrl-C. Its HTTP server is not needed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    worker.http_server.stop()
