"""The table of results: a row for every input, written as a whole; a journal of what is new since then."""

from __future__ import annotations

import csv
import json
import os
import platform
import sys
from collections.abc import Iterable
from contextlib import nullcontext, suppress
from dataclasses import asdict, dataclass, fields
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import Any, get_args, get_type_hints

from ..flattening import Outcome
from . import places

WAITING = "waiting"
VALID, OVERLAPPING = Outcome.VALID.value, "overlapping"
REFUSED, UNREADABLE, FAILED, OUT_OF_MEMORY, DIED = "refused", "unreadable", "failed", "out of memory", "died"
GOOD = frozenset(outcome.value for outcome in Outcome if outcome.good)
MISSING = frozenset({WAITING, UNREADABLE})  # done by every run
MAY_DIFFER = frozenset({FAILED, OUT_OF_MEMORY, DIED})  # another time

CSV, PARQUET, JOURNAL = "results.csv", "results.parquet", ".results.journal"
PAUSES = 50  # writing the table takes a fiftieth of the time at most


@dataclass(frozen=True)
class Row:
    """What is known of one input of a batch; a column of `results.csv` each.

    Attributes
    ----------
    input : str
        Absolute path, or URL.
    output : str
        The file with the map, from the output folder.
    outcome : str
        Of `unwrap`: "valid", "flipped" or "overlapping"; of `flatten`: the value of its `Outcome`. Without
        a map: "refused" for a `MeshError`, "unreadable", "out of memory", "died" where its process was
        lost twice while it had this mesh alone, "failed" for all other errors, "waiting" before it is done.
    message : str
        What is wrong, and warnings.
    triangles, charts : int or None
    angle_distortion : float or None
        F/3nt, which is the name of its column.
    stretch : float or None
        Its L2 norm.
    flips : int or None
    seconds : float or None
        To read, flatten, measure and write it.
    key : str
        Of the file's version and the settings: where it differs, the input is done again.
    """

    input: str
    output: str
    outcome: str = WAITING
    message: str = ""
    triangles: int | None = None
    charts: int | None = None
    angle_distortion: float | None = None
    stretch: float | None = None
    flips: int | None = None
    seconds: float | None = None
    key: str = ""

    @property
    def good(self) -> bool:
        """Whether there is a map without flipped or overlapping triangles."""
        return self.outcome in GOOD

    @property
    def written(self) -> bool:
        """Whether there is a map."""
        return self.charts is not None


NUMBERS = {name: get_args(kind)[0] for name, kind in get_type_hints(Row).items() if kind is not str}
NAMES = [field.name for field in fields(Row)]
HEADER = ["F/3nt" if name == "angle_distortion" else name for name in NAMES]


def shown(path: str) -> str:
    """The path as the table has it: valid UTF-8, in one line."""
    return path.encode("utf-8", "backslashreplace").decode().replace("\n", "\\n").replace("\r", "\\r")


def write_down(row: Row, folder: str) -> None:
    """Append a row to the journal of this worker."""
    if places.is_url(folder):
        return
    path = os.path.join(folder, f"{JOURNAL}-{platform.node()}-{os.getpid()}")
    journal = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    try:
        _append(row, journal, path)
    finally:
        os.close(journal)


def _append(row: Row, journal: int, path: str) -> None:
    line = json.dumps(asdict(row)).encode() + b"\n"
    if os.write(journal, line) < len(line):
        raise OSError(28, "No space left on device", path)


class Table:
    """The rows of an output folder, on disk and here; only one process at a time has it open.

    Every result is appended to the journal at once. The table itself is written anew now and then, and where
    the table is closed; opened again, it has what the journal knows, and those of the workers, which may have
    done more than this process has heard of when it is killed. Where a URL has the folder there are no
    journals: the table on disk may lack the last results.
    """

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self._rows: dict[str, Row] = {}
        self._journal: int | None = None
        self._written_at = self._cost = 0.0

    def __enter__(self) -> Table:
        if not places.is_url(self.folder):
            os.makedirs(self.folder, exist_ok=True)
            path = os.path.join(self.folder, JOURNAL)
            self._journal = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            if self._journal is not None:
                _lock(self._journal, self.folder)
            known = *self._of_csv(), *self._of_journal(JOURNAL)
            self._rows = {row.input: row for row in known}
            for name in self._workers_journals():  # rows of an input are as new as the table's, or newer
                self._rows |= {row.input: row for row in self._of_journal(name)}
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, _: object, __: TracebackType | None) -> None:
        try:
            with nullcontext() if kind is None else suppress(OSError):  # what ended the run is told
                self.write()
                if kind is None:
                    self._forget_workers()
        finally:
            self._close()

    def _close(self) -> None:
        if self._journal is not None:
            os.close(self._journal)
            self._journal = None

    def row(self, input: str) -> Row | None:
        return self._rows.get(input)

    def taken(self) -> dict[str, str]:
        """The inputs by their outputs."""
        return {row.output: row.input for row in self._rows.values()}

    def plan(self, rows: Iterable[Row]) -> None:
        """These rows are the next, in this order, behind those of earlier runs over other inputs."""
        planned = {row.input: row for row in rows}
        kept = {row.input: row for row in self._rows.values() if row.outcome != WAITING}
        self._rows = {**{k: row for k, row in kept.items() if k not in planned}, **planned}
        self.write()
        self._forget_workers()
        self._cost = 0.0  # pyarrow's imports are no part of the next

    def add(self, row: Row) -> None:
        """A result."""
        if self._journal is not None:
            _append(row, self._journal, os.path.join(self.folder, JOURNAL))
        self._rows[row.input] = row
        if perf_counter() - self._written_at > PAUSES * self._cost:
            self.write()

    def write(self) -> None:
        """Put the table on disk as it is."""
        start = perf_counter()
        rows = list(self._rows.values())
        with (
            places.written(places.joined(self.folder, CSV)) as path,
            open(path, "w", newline="", encoding="utf-8") as file,
        ):
            writer = csv.writer(file)
            writer.writerow(HEADER)
            writer.writerows([getattr(row, name) for name in NAMES] for row in rows)
        if find_spec("pyarrow"):
            with places.written(places.joined(self.folder, PARQUET)) as path:
                _save_parquet(path, rows)
        if self._journal is not None:
            os.ftruncate(self._journal, 0)
        self._written_at = perf_counter()
        self._cost = self._written_at - start

    def _of_csv(self) -> list[Row]:
        try:
            with (
                places.fetched(places.joined(self.folder, CSV)) as path,
                open(path, newline="", encoding="utf-8") as file,
            ):
                header, *lines = csv.reader(file)
            if header == HEADER:
                return [_row(dict(zip(NAMES, line, strict=True))) for line in lines]
        except FileNotFoundError:
            return []
        except ValueError:  # something else has written it
            pass
        raise OSError(None, "is no table of a batch: move it away", places.joined(self.folder, CSV))

    def _workers_journals(self) -> list[str]:
        if self._journal is None:
            return []
        return sorted(name for name in os.listdir(self.folder) if name.startswith(f"{JOURNAL}-"))

    def _forget_workers(self) -> None:
        """Remove the journals of workers, whose rows are in the table that is written."""
        for name in self._workers_journals():
            Path(self.folder, name).unlink(missing_ok=True)

    def _of_journal(self, name: str) -> list[Row]:
        if self._journal is None:
            return []
        data = Path(self.folder, name).read_bytes()
        whole, _, _ = data.rpartition(b"\n")  # a process may have been killed in the midst of a line
        return [Row(**json.loads(line)) for line in whole.splitlines()]


def _row(cells: dict[str, str]) -> Row:
    values: dict[str, Any] = {
        name: text if name not in NUMBERS else NUMBERS[name](text) if text else None
        for name, text in cells.items()
    }
    return Row(**values)


def _save_parquet(path: str, rows: list[Row]) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    types = {int: pa.int64(), float: pa.float64(), str: pa.string()}
    columns = {
        title: pa.array([getattr(row, name) for row in rows], types[NUMBERS.get(name, str)])
        for title, name in zip(HEADER, NAMES, strict=True)
    }
    parquet.write_table(pa.table(columns), path)


def _lock(journal: int, folder: str) -> None:
    """Until the process ends, however it does."""
    if sys.platform == "win32":
        return
    import fcntl

    try:
        fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OSError(None, "another batch is writing there: wait for its end", folder) from None
