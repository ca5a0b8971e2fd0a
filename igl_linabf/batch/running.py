"""Run a batch: plan the missing meshes, distribute them with Dask, and collect their rows in the table."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from errno import EEXIST
from functools import partial
from hashlib import sha256
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from time import perf_counter
from typing import Any, Literal, get_args

import numpy as np

from .._runtime import Progress, count_steps, undo_at_interrupt
from ..charts import ChartOptions, Cones, Packing, resolve_method_of_charts, resolve_options
from ..cortex import FLAT_PATCH_NAME, list_output_paths
from ..errors import escape_control_characters, first_few, format_count, is_number
from ..flattening import BoundaryName, Method, resolve_method
from ..io import SUFFIXES, list_companion_files
from . import places
from .baking import BakedPacking, BakeName, check_target, list_image_kinds
from .clusters import WorkerWatch, connect_client, start_local_client
from .constants import PATIENCE
from .one_mesh import UNWRAP_OPTIONS, How, Scale, SeamSource, Settings, Task, run_task
from .table import (
    CSV,
    DIED,
    MISSING,
    OUT_OF_MEMORY,
    PARQUET,
    RETRYABLE,
    Row,
    Table,
    append_to_journal,
    escape_path,
)

SUBMITTED_PER_THREAD = 8  # number of meshes submitted in advance per thread
MIN_SUBMITTED_TASKS = 64  # minimum number of meshes submitted in advance, for workers that join later
MAX_DEATHS_ALONE = (
    3  # a mesh is reported as "died" if its process died this many times without any other mesh
)

MEMORY_MESSAGE = "its process exceeded the memory limit even alone: raise the limit, or decimate the mesh"
Paths = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]


@dataclass(frozen=True)
class Batch:
    """The result of a batch; `print` shows the number of meshes by outcome.

    Attributes
    ----------
    rows : tuple of Row
        One row for each input.
    table : str
        Path of `results.csv`, which has the same rows.
    done : int
        Number of inputs that this run processed. Earlier runs processed all other inputs.
    seconds : float
        Duration of this run, without starting and stopping the workers.
    """

    rows: tuple[Row, ...]
    table: str
    done: int
    seconds: float

    @property
    def good(self) -> bool:
        """Whether every input has a map without problems, such as flipped or overlapping triangles."""
        return all(row.good for row in self.rows)

    def __str__(self) -> str:
        outcomes = Counter(row.outcome for row in self.rows).most_common()
        ends = ", ".join(f"{n:,} {outcome}" for outcome, n in outcomes)
        rate = f", {self.done / self.seconds:.3g} a second" if self.done else ""
        before = len(self.rows) - self.done
        return (
            f"{format_count(len(self.rows), 'mesh')}: {ends}\n"
            f"{self.done:,} done in {self.seconds:.3g} s{rate}; {before:,} were done before\n"
            f"a row for each in {escape_control_characters(self.table)}"
        )


def flatten_files(
    inputs: Paths,
    out: str | os.PathLike[str],
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    method: str | Method | None = None,
    how: How = "unwrap",
    format: str = "obj",
    memory: int | str | None = None,
    charts: ChartOptions | None = None,
    cones: Cones | int | Literal["auto"] | None = None,
    packing: Packing | None = None,
    weld: float | Literal[False] | None = None,
    strict: bool = False,
    seams: SeamSource = "auto",
    keep_materials: bool = False,
    bake: BakeName | None = None,
    texcoord: Literal[0, 1] = 0,
    boundary: BoundaryName = "free",
    units: Scale | None = None,
    retry: bool = False,
    force: bool = False,
    allow_outside: bool = False,
    dashboard: bool = False,
    progress: Progress = None,
) -> Batch:
    """Unwrap many mesh files on many processes or machines, with Dask.

    The maps are written to `out`, with a table `results.csv` that has a row for each input. If pyarrow is
    installed, the same table is written to `results.parquet`. A batch that was interrupted in any way can be
    started again, and then processes only the missing meshes. If a mesh cannot be unwrapped, or its process
    dies, its row states the reason.

    A local cluster starts processes that import the program's main module. Therefore call `flatten_files`
    under `if __name__ == "__main__":`.

    Parameters
    ----------
    inputs : path or URL, or several
        Files, folders and globs. A folder stands for all mesh files in it and its subfolders, except hidden
        files and files in `out`.
    out : path or URL of a folder
        Created if it does not exist. A map has the name of its input, relative to the given folder or to the
        first pattern of a glob. If two maps would have the same name, a hash of the path is appended.
    workers : int, optional
        Number of single-threaded processes on this machine; by default one for each core.
    scheduler : str, optional
        Address of a running Dask scheduler, "tcp://..." or "tls://...". Its workers must see the same files
        under the same names.
    method : str or method object, optional
        As in `flatten`; by default "isometric", but "linabf" with `cones` and for `how="flatten"`.
    how : {"unwrap", "flatten", "cortex"}
        "unwrap" cuts seams. "flatten" accepts only disks, with or without holes. For "cortex" the inputs are
        folders of FreeSurfer subjects, or `?h.sphere.reg` files in them. Each hemisphere is cut, flattened
        and written as by `write_hemisphere`, to a folder with the subject's name, and `format` is ignored.
    format : {"obj", "ply", "glb"}
        File format of the maps.
    memory : int or str, optional
        Memory limit for one mesh: a number of bytes, or a text such as "2 GiB". By default the processes
        share the available memory.
    charts : ChartOptions, optional
        As in `unwrap`, but without labels or weights of faces, which belong to one mesh.
    cones : Cones, int or "auto", optional
        As in `unwrap`, but as a number of cones for each component, not as vertices of one mesh.
    packing : Packing, optional
        As in `unwrap`.
    weld : float or False, optional
    strict : bool
        As in `unwrap`.
    seams : {"auto", "uv"}
        "uv" cuts along the seams of the texture coordinates in the files.
    keep_materials : bool
        Charts do not cross edges between two materials of a file.
    bake : {"colors", "colours", "texture", "normals", "position"}, optional
        Bake a texture of `packing.resolution` texels (by default 2048) into GLB, glTF and 3MF files, or
        beside OBJ files: the colours of vertices, faces and materials; the images of the old texture
        coordinates; normals in the object's space; or positions in the bounding cube.
    texcoord : {0, 1}
        With 1, write second texture coordinates, for example for lightmaps, and keep the first set and its
        images.
    boundary : {"free", "circle", "circles", "rectangle"}
        As in `flatten`, for `how="flatten"`.
    units : {"square", "mesh"}, optional
        Scale of the maps for `how="flatten"`: the unit square, or the mesh's units of length. The default is
        "square", or "mesh" for GIFTI and FreeSurfer files, which store the map as a surface.
    retry : bool
        Also retry meshes that died, ran out of memory or failed in an earlier run.
    force : bool
        Replace files in `out` that were not written by a batch.
    allow_outside : bool
        As in `read_file`.
    dashboard : bool
        Print the address of Dask's dashboard on stderr. The dashboard is a web page that shows the work of
        each worker. Workers on this machine have a dashboard only if `dashboard` is True.
    progress : callable or False, optional
        As in `flatten`.

    Returns
    -------
    Batch

    Raises
    ------
    MeshError
        A folder or glob holds no meshes.
    ValueError
        An argument has an invalid value.
    OSError
        An input does not exist, `out` cannot be written to, a file to be replaced was not written by a batch,
        the disk is full, another batch is writing to `out`, or no scheduler answers.
    ImportError
        Dask is not installed.

    Examples
    --------
    >>> import igl, igl_linabf, os, tempfile
    >>> folder = tempfile.mkdtemp()
    >>> igl.write_triangle_mesh(os.path.join(folder, "ball.off"), *igl.icosahedron())
    >>> done = igl_linabf.batch.flatten_files(folder, os.path.join(folder, "maps"), workers=1)
    >>> [(row.output, row.outcome, row.triangles) for row in done.rows]
    [('ball.obj', 'valid', 20)]
    """
    limit = _parse_memory(memory)
    if cones is not None and not isinstance(cones, Cones):
        cones = Cones(cones)
    if how == "unwrap":
        chosen = resolve_method_of_charts(method, cones)
    else:
        chosen = resolve_method(method or ("isometric" if how == "cortex" else "linabf"))
    unwrapping = weld, strict, seams, keep_materials, texcoord
    baked = BakedPacking.from_packing(packing, bake)
    settings = Settings(
        how, chosen, format, charts, cones, baked, *unwrapping, boundary, units, allow_outside, limit
    )
    _check_settings(settings)
    if workers is not None and scheduler is not None:
        raise ValueError("workers is for a local cluster, scheduler for a running one: give one of the two")
    if workers is not None and not is_number(workers, 1, whole=True):
        raise ValueError(f"workers is {workers!r}: use an integer of at least 1")
    folder = places.make_absolute(out)
    wanted = places.is_registered_sphere if how == "cortex" else None
    given = [inputs] if isinstance(inputs, str | os.PathLike) else list(inputs)
    if how == "cortex" and any(places.is_url(os.fspath(place)) for place in [*given, folder]):
        raise ValueError(
            "a subject consists of many files: copy it here, and give local folders for input and output"
        )
    found = places.find_inputs(given, folder, wanted)
    with Table(folder) as table:
        tasks = _plan_tasks(found, table, settings, retry, force)
        seconds = 0.0
        if tasks:
            with ExitStack() as stack:
                stack.enter_context(undo_at_interrupt(table.write))
                if scheduler is None:  # dead local workers may leave temporary files
                    remove = partial(places.remove_temporaries, {task.row.output for task in tasks}, folder)
                    stack.callback(remove)
                    stack.enter_context(undo_at_interrupt(remove))
                    client = stack.enter_context(start_local_client(workers, settings.memory, dashboard))
                else:
                    client = stack.enter_context(connect_client(scheduler))
                if dashboard and sys.stderr is not None:
                    print(f"igl-linabf: dashboard at {client.dashboard_link}", file=sys.stderr)
                tell = stack.enter_context(count_steps("batch", len(tasks), progress))
                start = perf_counter()
                for row in _run_tasks(client, tasks):
                    table.add_row(row)
                    tell()
                seconds = perf_counter() - start
        rows = [table.get_row(escape_path(file.place)) for file in found]
    return Batch(tuple(row for row in rows if row), places.join_path(folder, CSV), len(tasks), seconds)


def _parse_memory(memory: int | str | None) -> int | None:
    """Convert the memory limit of a mesh to bytes."""
    if find_spec("distributed") is None:
        raise ImportError("batch needs Dask: pip install 'igl-linabf[batch]'")
    from dask.utils import parse_bytes

    try:
        limit = None if memory is None else int(parse_bytes(memory))
    except ValueError:
        limit = 0
    if limit is not None and limit < 1:
        raise ValueError(f"memory is {memory!r}: use a number of bytes, or a text such as '2 GiB'")
    return limit


def _check_settings(asked: Settings) -> None:
    """Raise a `ValueError` if the settings are invalid for every mesh."""
    charts, cones, method = asked.charts, asked.cones, asked.method
    if asked.how not in get_args(How):
        raise ValueError(f"how is {asked.how!r}: use 'unwrap', 'flatten' or 'cortex'")
    if f".{asked.format}" not in SUFFIXES:
        raise ValueError(f"format is {asked.format!r}: use {', '.join(suffix[1:] for suffix in SUFFIXES)}")
    if asked.how != "unwrap" and any(
        getattr(asked, name) != getattr(Settings, name) for name in UNWRAP_OPTIONS
    ):
        raise ValueError(
            f"{', '.join(UNWRAP_OPTIONS)} are not options of {asked.how}: leave them out, or unwrap"
        )
    if asked.seams not in get_args(SeamSource):
        raise ValueError(f"seams is {asked.seams!r}: use 'auto' or 'uv'; edges belong to one mesh")
    if cones is not None and (asked.seams != "auto" or asked.keep_materials):
        raise ValueError("seams and keep_materials cannot be combined with cones: leave out one of them")
    if asked.texcoord not in (0, 1):
        raise ValueError(f"texcoord is {asked.texcoord!r}: use 0, or 1 for second texture coordinates")
    check_target(f"map.{asked.format}", asked.packing.bake, asked.texcoord)
    if asked.units not in (None, *get_args(Scale)):
        raise ValueError(f"units is {asked.units!r}: use 'square' or 'mesh'")
    if asked.how != "flatten" and asked.units is not None:
        raise ValueError(f"units is not an option of {asked.how}: leave it out, or flatten")
    if asked.how != "flatten" and asked.boundary != "free":
        raise ValueError("charts have a free boundary: leave boundary out, or flatten")
    if asked.boundary not in get_args(BoundaryName):
        names = ", ".join(map(repr, get_args(BoundaryName)))
        raise ValueError(f"boundary is {asked.boundary!r}: use one of {names}")
    if (asked.boundary != "free" or cones is not None) and not method.shapes:
        raise ValueError(
            f"the method {method.name!r} cannot prescribe boundaries or cones: use 'linabf' or 'abf'"
        )
    if cones is not None and np.ndim(cones.at):
        raise ValueError(f"cones is {cones.at!r}: give 'auto', or a number of them for each component")
    made, *_ = resolve_options([] if asked.seams == "uv" else None, charts, cones, asked.packing)
    if made.labels is not None or np.asarray(made.hide).shape not in ((), (3,)):
        raise ValueError(
            f"charts is {charts!r}: give ChartOptions without labels and without weights of faces, which "
            "differ from mesh to mesh"
        )


def _plan_tasks(
    found: list[places.InputFile], table: Table, settings: Settings, retry: bool, force: bool
) -> list[Task]:
    """Return the tasks that no earlier run has completed, and give every input a row in the table."""
    there = places.list_names(table.folder)
    places.remove_temporaries(there, table.folder)
    names = _name_outputs(found, table, settings)
    rows, tasks = [], []
    for file in found:
        row = Row(
            input=escape_path(file.place),
            output=names[file.place],
            key=settings.hash_with_file_version(file.version),
        )
        old = table.get_row(row.input)
        if (
            old is not None
            and (old.key, old.output) == (row.key, row.output)
            and old.outcome not in MISSING
            and not (retry and old.outcome in RETRYABLE)
            and (not old.written or old.output in there)
        ):
            rows.append(old)
            continue
        rows.append(row)
        tasks.append(Task(file.place, row, table.folder, settings))
    if not force:
        _check_outputs_may_be_written(tasks, table, there)
    table.plan_rows(rows)
    return tasks


def _check_outputs_may_be_written(tasks: list[Task], table: Table, there: set[str]) -> None:
    """Raise a `FileExistsError` if the batch would replace files that were not written by a batch."""
    own = table.inputs_by_output()
    wanted = [PARQUET] if not own else []
    for task in tasks:
        output = task.row.output
        if output not in own:
            wanted += _list_output_files(task)
    taken = [name for name in wanted if name in there]
    if taken:
        raise FileExistsError(
            EEXIST,
            f"{first_few(taken)} are there already, and no batch has written them: give another folder, or "
            "replace them with force=True",
            table.folder,
        )


def _list_output_files(task: Task) -> list[str]:
    """Return the names of all files written for an input, relative to the folder of the batch."""
    output = task.row.output
    if task.settings.how == "cortex":
        return [
            path.as_posix() for path in list_output_paths(Path(output).parent, places.get_hemisphere(output))
        ]
    packing, texcoord = task.settings.packing, task.settings.texcoord
    kinds = list_image_kinds(packing.bake)
    beside = list_companion_files(Path(output), None, kinds, packing.pages or 1, bool(texcoord))
    return [output, *(path.as_posix() for path in beside)]


def _name_outputs(found: list[places.InputFile], table: Table, settings: Settings) -> dict[str, str]:
    """Return a unique name for the map of each input; an input of an earlier run keeps its name."""
    if settings.how == "cortex":
        return _name_hemisphere_outputs(found)
    suffix = settings.format
    names = {file.place: f"{os.path.splitext(escape_path(file.name))[0]}.{suffix}" for file in found}
    taken = {output.casefold(): input for output, input in table.inputs_by_output().items()}
    wanted = Counter(name.casefold() for name in names.values())
    for file in found:
        name, input = names[file.place], escape_path(file.place)
        old = table.get_row(input)
        if old is not None and old.output.endswith(f".{suffix}"):
            names[file.place] = old.output
        elif wanted[name.casefold()] > 1 or taken.get(name.casefold(), input) != input:
            stem = name.removesuffix(f".{suffix}")
            names[file.place] = f"{stem}-{sha256(os.fsencode(file.place)).hexdigest()[:10]}.{suffix}"
    return names


def _name_hemisphere_outputs(found: list[places.InputFile]) -> dict[str, str]:
    """Return the name of each hemisphere's flat patch, in a folder with the name of the subject."""
    subjects = {file.place: Path(file.place).parents[1] for file in found}
    several = Counter(subject.name for subject in set(subjects.values()))
    names = {}
    for file in found:
        subject = subjects[file.place]
        folder = escape_path(subject.name)
        if several[subject.name] > 1:
            folder += f"-{sha256(os.fsencode(subject)).hexdigest()[:10]}"
        names[file.place] = f"{folder}/{Path(file.place).name[:2]}.{FLAT_PATCH_NAME}"
    return names


def _run_tasks(client: Any, tasks: list[Task]) -> Iterator[Row]:
    """Run the tasks and yield their rows as they arrive.

    When a process dies, any mesh assigned to it may be the cause, or none. These meshes are therefore run
    again one at a time. A mesh is reported as the cause if its process dies in each of `MAX_DEATHS_ALONE`
    such runs.
    """
    threads = sum(client.nthreads().values())
    suspects: list[Task] = []
    for task, result in _submit_tasks(
        client, iter(tasks), max(MIN_SUBMITTED_TASKS, SUBMITTED_PER_THREAD * threads)
    ):
        if isinstance(result, Row):
            yield result
        else:
            suspects.append(task)
    for _ in range(MAX_DEATHS_ALONE):
        tried, suspects = suspects, []
        for task, result in _submit_tasks(client, iter(tried), 1):
            if isinstance(result, Row):
                yield result
            elif _has_exceeded_memory(client, result):
                yield _record_failure(task, OUT_OF_MEMORY, MEMORY_MESSAGE)
            else:
                suspects.append(task)
    for task in suspects:
        limit = ", perhaps for lack of memory" if task.settings.memory else ""
        message = f"its process died {MAX_DEATHS_ALONE} times while it processed this mesh alone{limit}"
        yield _record_failure(task, DIED, message)


def _submit_tasks(client: Any, tasks: Iterator[Task], ahead: int) -> Iterator[tuple[Task, Row | Any]]:
    """Yield each task with its row, or with Dask's KilledWorker; submit at most `ahead` tasks at a time."""
    under_way: dict[Any, Task] = {}
    finished: SimpleQueue[Any] = SimpleQueue()
    lookout = WorkerWatch(client)
    while True:
        more = list(islice(tasks, ahead - len(under_way)))
        if more:
            futures = client.map(run_task, more, key="igl_linabf", pure=False)
            under_way.update(zip(futures, more, strict=True))
            for future in futures:
                future.add_done_callback(finished.put)
        if not under_way:
            return
        try:
            futures = [finished.get(timeout=PATIENCE)]
        except Empty:
            lookout.check_workers()
            continue
        while not finished.empty():
            futures.append(finished.get())
        yield from zip([under_way.pop(f) for f in futures], _gather_rows(client, futures), strict=True)


def _gather_rows(client: Any, futures: list[Any]) -> list[Row | Any]:
    """Return the row of each finished task, or Dask's KilledWorker if its process died."""
    from distributed import KilledWorker

    if all(future.status == "finished" for future in futures):
        with suppress(
            KilledWorker, CancelledError
        ):  # raised if Dask fails to recompute a result whose worker died
            return list(client.gather(futures))
    rows = []
    for future in futures:
        try:
            rows.append(future.result())
        except KilledWorker as killed:
            rows.append(killed)
        except CancelledError:
            place = client.scheduler.address
            raise OSError(
                None, "the connection to the scheduler was lost: start the batch again", place
            ) from None
    return rows


def _has_exceeded_memory(client: Any, killed: Any) -> bool:
    """Return True if Dask terminated the process because of its memory."""
    exceeded = client.get_events("worker-restart-memory") or ()
    return any(event["worker"] == killed.last_worker.address for _, event in exceeded)


def _record_failure(task: Task, outcome: str, message: str) -> Row:
    """Return the row of a mesh whose process died, and append it to the journal in place of that process."""
    row = replace(task.row, outcome=outcome, message=message)
    append_to_journal(row, task.folder)
    return row
