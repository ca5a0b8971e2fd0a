"""A batch: which meshes are missing, handed to Dask, and their rows put into the table."""

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

from .._runtime import Progress, counting, undo_at_interrupt
from ..charts import Cones, Packing, Seams, asked_for
from ..cortex import FLAT_PATCH, files_of
from ..errors import is_number, some
from ..flattening import BoundaryName, Method, method_of
from ..io import SUFFIXES
from . import places
from .clusters import Lookout, client_of, local_client
from .constants import AHEAD, AHEAD_AT_LEAST, DEATHS_ALONE, PATIENCE
from .one_mesh import OF_UNWRAP, How, Scale, Settings, Task, run
from .table import CSV, DIED, MAY_DIFFER, MISSING, OUT_OF_MEMORY, PARQUET, Row, Table, shown, write_down

NO_ROOM = "its process took more memory than it may, also alone: allow it more, or decimate the mesh"
Paths = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]


@dataclass(frozen=True)
class Batch:
    """What came of a batch; `print` shows how many meshes ended how.

    Attributes
    ----------
    rows : tuple of Row
        One for each input.
    table : str
        Where they are: the path of results.csv.
    done : int
        How many of the inputs this run did; the others were done before.
    seconds : float
        What that took, without the start and the end of the workers.
    """

    rows: tuple[Row, ...]
    table: str
    done: int
    seconds: float

    @property
    def good(self) -> bool:
        """Whether every input has a map without flipped or overlapping triangles."""
        return all(row.good for row in self.rows)

    def __str__(self) -> str:
        outcomes = Counter(row.outcome for row in self.rows).most_common()
        ends = ", ".join(f"{n:,} {outcome}" for outcome, n in outcomes)
        rate = f", {self.done / self.seconds:.3g} a second" if self.done else ""
        before = len(self.rows) - self.done
        return (
            f"{len(self.rows):,} meshes: {ends}\n"
            f"{self.done:,} done in {self.seconds:.3g} s{rate}; {before:,} were done before\n"
            f"a row for each in {self.table}"
        )


def batch(
    inputs: Paths,
    out: str | os.PathLike[str],
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    method: str | Method | None = None,
    how: How = "unwrap",
    format: str = "obj",
    memory: int | str | None = None,
    seams: Seams | None = None,
    cones: Cones | int | Literal["auto"] | None = None,
    packing: Packing | None = None,
    boundary: BoundaryName = "free",
    units: Scale | None = None,
    retry: bool = False,
    force: bool = False,
    progress: Progress = None,
) -> Batch:
    """Unwrap many mesh files on many processes or machines, with Dask.

    The maps and `results.csv`, which has a row for each input, are in `out`; with pyarrow, the same table
    is in `results.parquet`. A batch that was stopped, however that was, and is started again does what is
    missing. A mesh that cannot be unwrapped, or on which a process dies, is a row.

    A local cluster starts processes that import the program's main module: call `batch` under
    `if __name__ == "__main__":`.

    Parameters
    ----------
    inputs : path or URL, or several
        Files, folders and globs. Of a folder, all mesh files in it and in the folders in it are taken;
        hidden ones and those in `out` are not.
    out : path or URL of a folder
        It is made. A map is named as its input is, from the folder or the first part with a pattern on;
        where two would have one name, a part of their paths' hash is added.
    workers : int, optional
        Processes on this machine, one thread each; by default one for each core.
    scheduler : str, optional
        Address of a running Dask scheduler, "tcp://..." or "tls://...", whose workers see the same
        files under the same names.
    method : str or method object, optional
        As in `flatten`; by default "linabf", and "isometric" for cortices.
    how : {"unwrap", "flatten", "cortex"}
        With or without seams; `flatten` takes disks only, maybe with holes. "cortex": the inputs are folders
        of FreeSurfer subjects, or `?h.sphere.reg` in them, and each hemisphere is cut, flattened and written
        as `write_hemisphere` does, in a folder of the subject's name; `format` means nothing then.
    format : {"obj", "ply", "glb"}
        Of the maps.
    memory : int or str, optional
        What one mesh may take: bytes, or a text like "2 GiB". By default the processes share what there is.
    seams : Seams, optional
        As in `unwrap`, without the edges of one mesh, or labels or weights of its faces.
    cones : Cones, int or "auto", optional
        As in `unwrap`: how many on each component, not the vertices of one mesh.
    packing : Packing, optional
        As in `unwrap`.
    boundary : {"free", "circle", "circles", "rectangle"}
        As in `flatten`, for `how="flatten"`.
    units : {"square", "mesh"}, optional
        Scale of the maps of `how="flatten"`: the unit square, or the mesh's units of length. By default
        "square"; "mesh" in GIFTI and FreeSurfer, where the map is a surface.
    retry : bool
        Do again, too, what died, ran out of memory or failed in an earlier run.
    force : bool
        Replace files in `out` that no batch has written.
    progress : callable or False, optional
        As in `flatten`; the default also prints the address of Dask's dashboard, on stderr.

    Returns
    -------
    Batch

    Raises
    ------
    MeshError
        A folder or glob holds no meshes.
    ValueError
        An argument is none of those above.
    OSError
        There is no such input, `out` cannot be written to, a file is there that no batch has written, the
        disk is full, another batch is writing there, or no scheduler answers.
    ImportError
        Dask is not installed.

    Examples
    --------
    >>> import igl, igl_linabf, os, tempfile
    >>> folder = tempfile.mkdtemp()
    >>> igl.write_triangle_mesh(os.path.join(folder, "ball.off"), *igl.icosahedron())
    >>> done = igl_linabf.batch(folder, os.path.join(folder, "maps"), workers=1)
    >>> [(row.output, row.outcome, row.triangles) for row in done.rows]
    [('ball.obj', 'valid', 20)]
    """
    limit = _in_bytes(memory)
    if cones is not None and not isinstance(cones, Cones):
        cones = Cones(cones)
    chosen = method_of(method or ("isometric" if how == "cortex" else "linabf"))
    settings = Settings(how, chosen, format, seams, cones, packing, boundary, units, limit)
    _check_settings(settings)
    if workers is not None and scheduler is not None:
        raise ValueError("workers are those of the scheduler: give one of the two")
    if workers is not None and not is_number(workers, 1, whole=True):
        raise ValueError(f"workers is {workers!r}: use an integer from 1 on")
    folder = places.absolute(out)
    wanted = places.is_hemisphere if how == "cortex" else None
    given = [inputs] if isinstance(inputs, str | os.PathLike) else list(inputs)
    if how == "cortex" and any(places.is_url(os.fspath(place)) for place in [*given, folder]):
        raise ValueError("a subject is many files: copy it here, and give a folder of this machine for both")
    found = places.found(given, folder, wanted)
    with Table(folder) as table:
        tasks = _planned(found, table, settings, retry, force)
        seconds = 0.0
        if tasks:
            with ExitStack() as stack:
                stack.enter_context(undo_at_interrupt(table.write))
                if scheduler is None:  # the workers are gone then, and may have died in the midst of a file
                    remove = partial(places.remove_temporaries, {task.row.output for task in tasks}, folder)
                    stack.callback(remove)
                    stack.enter_context(undo_at_interrupt(remove))
                    client = stack.enter_context(local_client(workers, settings.memory))
                else:
                    client = stack.enter_context(client_of(scheduler))
                if progress is None and sys.stderr is not None:
                    print(f"igl-linabf: dashboard at {client.dashboard_link}", file=sys.stderr)
                tell = stack.enter_context(counting("batch", len(tasks), progress))
                start = perf_counter()
                for row in _results(client, tasks):
                    table.add(row)
                    tell()
                seconds = perf_counter() - start
        rows = [table.row(shown(file.place)) for file in found]
    return Batch(tuple(row for row in rows if row), places.joined(folder, CSV), len(tasks), seconds)


def _in_bytes(memory: int | str | None) -> int | None:
    if find_spec("distributed") is None:
        raise ImportError("batch needs Dask: pip install 'igl-linabf[batch]'")
    from dask.utils import parse_bytes

    try:
        limit = None if memory is None else int(parse_bytes(memory))
    except ValueError:
        limit = 0
    if limit is not None and limit < 1:
        raise ValueError(f"memory is {memory!r}: use a number of bytes, or a text like '2 GiB'")
    return limit


def _check_settings(asked: Settings) -> None:
    """Refuse here what would be wrong with every mesh."""
    seams, cones, method = asked.seams, asked.cones, asked.method
    if asked.how not in get_args(How):
        raise ValueError(f"how is {asked.how!r}: use 'unwrap', 'flatten' or 'cortex'")
    if f".{asked.format}" not in SUFFIXES:
        raise ValueError(f"format is {asked.format!r}: use {', '.join(suffix[1:] for suffix in SUFFIXES)}")
    if asked.how != "unwrap" and any(getattr(asked, name) != getattr(Settings, name) for name in OF_UNWRAP):
        raise ValueError(f"{', '.join(OF_UNWRAP)} mean nothing to {asked.how}: leave them out, or unwrap")
    if asked.units not in (None, *get_args(Scale)):
        raise ValueError(f"units is {asked.units!r}: use 'square' or 'mesh'")
    if asked.how != "flatten" and asked.units is not None:
        raise ValueError(f"units mean nothing to {asked.how}: leave them out, or flatten")
    if asked.how != "flatten" and asked.boundary != "free":
        raise ValueError("charts have a free boundary: leave boundary out, or flatten")
    if asked.boundary not in get_args(BoundaryName):
        names = ", ".join(map(repr, get_args(BoundaryName)))
        raise ValueError(f"boundary is {asked.boundary!r}: use one of {names}")
    if (asked.boundary != "free" or cones is not None) and not method.shapes:
        raise ValueError(
            f"the method {method.name!r} makes no boundaries or cones to order: use 'linabf' or 'abf'"
        )
    if cones is not None and np.ndim(cones.at):
        raise ValueError(f"cones is {cones.at!r}: give 'auto', or a number of them for each component")
    for_all = seams is None or (
        isinstance(seams, Seams)
        and seams.at is None
        and seams.labels is None
        and np.asarray(seams.hide).shape in ((), (3,))
    )
    if not for_all:
        raise ValueError(
            f"seams is {seams!r}: give Seams without edges, without labels and without weights of faces, "
            "which each mesh has of its own"
        )
    asked_for(seams, cones, asked.packing)


def _planned(
    found: list[places.Found], table: Table, settings: Settings, retry: bool, force: bool
) -> list[Task]:
    """The tasks that are missing; the table has a row for every input then."""
    there = places.names_in(table.folder)
    places.remove_temporaries(there, table.folder)
    names = _outputs(found, table, settings)
    rows, tasks = [], []
    for file in found:
        row = Row(input=shown(file.place), output=names[file.place], key=settings.key(file.version))
        old = table.row(row.input)
        if (
            old is not None
            and (old.key, old.output) == (row.key, row.output)
            and old.outcome not in MISSING
            and not (retry and old.outcome in MAY_DIFFER)
            and (not old.written or old.output in there)
        ):
            rows.append(old)
            continue
        rows.append(row)
        tasks.append(Task(file.place, row, table.folder, settings))
    if not force:
        _check_free(tasks, table, there)
    table.plan(rows)
    return tasks


def _check_free(tasks: list[Task], table: Table, there: set[str]) -> None:
    """Raise where a file would be replaced that no batch has written."""
    own = table.taken()
    wanted = [PARQUET] if not own else []
    for task in tasks:
        output = task.row.output
        if output not in own:
            wanted += _files_of(task)
    taken = [name for name in wanted if name in there]
    if taken:
        raise FileExistsError(
            EEXIST,
            f"{some(taken)} are there already, and no batch has written them: give another folder, or "
            "replace them with --force (in Python, force=True)",
            table.folder,
        )


def _files_of(task: Task) -> list[str]:
    """All that is written for an input, named from the folder of the batch."""
    output = task.row.output
    if task.settings.how == "cortex":
        return [path.as_posix() for path in files_of(Path(output).parent, places.hemisphere_of(output))]
    stem, suffix = os.path.splitext(output)
    return [output, *([f"{stem}.mtl"] if suffix == ".obj" else ())]


def _outputs(found: list[places.Found], table: Table, settings: Settings) -> dict[str, str]:
    """A name for the map of each input that no other has; an input of an earlier run keeps its own."""
    if settings.how == "cortex":
        return _outputs_of_hemispheres(found)
    suffix = settings.format
    names = {file.place: f"{os.path.splitext(shown(file.name))[0]}.{suffix}" for file in found}
    taken = {output.casefold(): input for output, input in table.taken().items()}
    wanted = Counter(name.casefold() for name in names.values())
    for file in found:
        name, input = names[file.place], shown(file.place)
        old = table.row(input)
        if old is not None and old.output.endswith(f".{suffix}"):
            names[file.place] = old.output
        elif wanted[name.casefold()] > 1 or taken.get(name.casefold(), input) != input:
            stem = name.removesuffix(f".{suffix}")
            names[file.place] = f"{stem}-{sha256(os.fsencode(file.place)).hexdigest()[:10]}.{suffix}"
    return names


def _outputs_of_hemispheres(found: list[places.Found]) -> dict[str, str]:
    """The flat patch of each hemisphere, in a folder of its subject's name."""
    subjects = {file.place: Path(file.place).parents[1] for file in found}
    several = Counter(subject.name for subject in set(subjects.values()))
    names = {}
    for file in found:
        subject = subjects[file.place]
        folder = shown(subject.name)
        if several[subject.name] > 1:
            folder += f"-{sha256(os.fsencode(subject)).hexdigest()[:10]}"
        names[file.place] = f"{folder}/{Path(file.place).name[:2]}.{FLAT_PATCH}"
    return names


def _results(client: Any, tasks: list[Task]) -> Iterator[Row]:
    """The rows of the tasks, as they come; those whose process died come last, each alone.

    A process that dies takes the meshes that wait for it with it, and something else may have killed it, as
    one that is ended while another takes its place: only a mesh that was alone several times is to blame.
    """
    threads = sum(client.nthreads().values())
    suspects: list[Task] = []
    for task, result in _run(client, iter(tasks), max(AHEAD_AT_LEAST, AHEAD * threads)):
        if isinstance(result, Row):
            yield result
        else:
            suspects.append(task)
    for _ in range(DEATHS_ALONE):
        tried, suspects = suspects, []
        for task, result in _run(client, iter(tried), 1):
            if isinstance(result, Row):
                yield result
            elif _took_too_much(client, result):
                yield _blamed(task, OUT_OF_MEMORY, NO_ROOM)
            else:
                suspects.append(task)
    for task in suspects:
        limit = ", maybe for want of memory" if task.settings.memory else ""
        said = f"its process died {DEATHS_ALONE} times when it had this mesh alone{limit}"
        yield _blamed(task, DIED, said)


def _run(client: Any, tasks: Iterator[Task], ahead: int) -> Iterator[tuple[Task, Row | Any]]:
    """The tasks with their rows, or with Dask's KilledWorker; so many at most are handed out at a time."""
    under_way: dict[Any, Task] = {}
    finished: SimpleQueue[Any] = SimpleQueue()
    lookout = Lookout(client)
    while True:
        more = list(islice(tasks, ahead - len(under_way)))
        if more:
            futures = client.map(run, more, key="igl_linabf", pure=False)
            under_way.update(zip(futures, more, strict=True))
            for future in futures:
                future.add_done_callback(finished.put)
        if not under_way:
            return
        try:
            futures = [finished.get(timeout=PATIENCE)]
        except Empty:
            lookout.look()
            continue
        while not finished.empty():
            futures.append(finished.get())
        yield from zip([under_way.pop(f) for f in futures], _gathered(client, futures), strict=True)


def _gathered(client: Any, futures: list[Any]) -> list[Row | Any]:
    """The rows of finished tasks, or Dask's KilledWorker for some."""
    from distributed import KilledWorker

    if all(future.status == "finished" for future in futures):
        with suppress(KilledWorker, CancelledError):  # the worker has died that had a row: it is made again
            return list(client.gather(futures))
    rows = []
    for future in futures:
        try:
            rows.append(future.result())
        except KilledWorker as killed:
            rows.append(killed)
        except CancelledError:
            place = client.scheduler.address
            raise OSError(None, "the scheduler was lost: start the batch again", place) from None
    return rows


def _took_too_much(client: Any, killed: Any) -> bool:
    """Whether Dask ended the process because of its memory."""
    exceeded = client.get_events("worker-restart-memory") or ()
    return any(event["worker"] == killed.last_worker.address for _, event in exceeded)


def _blamed(task: Task, outcome: str, said: str) -> Row:
    """The row of a mesh on which processes died; the worker could not write it down."""
    row = replace(task.row, outcome=outcome, message=said)
    write_down(row, task.folder)
    return row
