"""The table of results: a row for every input, written as a whole; journals of what is new since then."""

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
from .constants import WRITING_PAUSE

WAITING = "waiting"
VALID, OVERLAPPING, FAULTY = Outcome.VALID.value, "overlapping", "faulty"
REFUSED, UNREADABLE, FAILED, OUT_OF_MEMORY, DIED = "refused", "unreadable", "failed", "out of memory", "died"
GOOD = frozenset(outcome.value for outcome in Outcome if outcome.good)
MISSING = frozenset({WAITING, UNREADABLE})  # done by every run
MAY_DIFFER = frozenset({FAILED, OUT_OF_MEMORY, DIED})  # another time

CSV, PARQUET = "results.csv", "results.parquet"
JOURNAL, LOCK = ".results.journal", ".results.lock"


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
        Of `unwrap`: "valid", "flipped", "overlapping", or "faulty" for other troubles, as too much stretch;
        of `flatten`: the value of its `Outcome`. Without a map: "refused" for a `MeshError`, "unreadable",
        "out of memory", "died" where its process was lost three times while it had this mesh alone,
        "failed" for all other errors, "waiting" before it is done.
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
        """Whether there is a map without faults."""
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
    """Append a row to the journal of this process."""
    if places.is_url(folder):
        return
    path = os.path.join(folder, f"{JOURNAL}-{platform.node()}-{os.getpid()}")
    journal = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    line = json.dumps(asdict(row)).encode() + b"\n"
    try:
        if os.write(journal, line) < len(line):
            raise OSError(28, "No space left on device", path)
    finally:
        os.close(journal)


class Table:
    """The rows of an output folder, on disk and here; only one process at a time has it open.

    Every process appends its results to a journal of its own at once, by `write_down`. The table itself is
    written anew now and then, and where it is closed; opened again, it has what the journals know. So a
    process that is killed loses nothing, also of what the workers have done and it has not heard of. Where a
    URL has the folder there are no journals: the table on disk may lack the last results.
    """

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self._rows: dict[str, Row] = {}
        self._lock: int | None = None
        self._written_at = self._cost = 0.0

    def __enter__(self) -> Table:
        if not places.is_url(self.folder):
            os.makedirs(self.folder, exist_ok=True)
            self._lock = os.open(os.path.join(self.folder, LOCK), os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if self._lock is not None:
                _held(self._lock, self.folder)
            self._rows = {row.input: row for row in self._of_csv()}
            for path in self._journals():  # rows of an input are as new as the table's, or newer
                self._rows |= {row.input: row for row in _of_journal(path)}
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, _: object, __: TracebackType | None) -> None:
        try:
            with nullcontext() if kind is None else suppress(OSError):  # what ended the run is told
                if self._rows:  # none if what is there was not to be replaced
                    self.write()
                if kind is None:
                    self._remove_journals()
        finally:
            self._close()

    def _close(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

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
        self._remove_journals()
        self._cost = 0.0  # pyarrow's imports are no part of the next

    def add(self, row: Row) -> None:
        """A result, which is in a journal."""
        self._rows[row.input] = row
        if perf_counter() - self._written_at > WRITING_PAUSE * self._cost:
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

    def _journals(self) -> list[Path]:
        return [] if places.is_url(self.folder) else sorted(Path(self.folder).glob(f"{JOURNAL}-*"))

    def _remove_journals(self) -> None:
        """Their rows are in the table that is written."""
        for path in self._journals():
            path.unlink(missing_ok=True)


def _of_journal(path: Path) -> list[Row]:
    whole, _, _ = path.read_bytes().rpartition(b"\n")  # a process may have been killed in the midst of a line
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


def _held(lock: int, folder: str) -> None:
    """Lock the folder for other batches until the process ends, however it does."""
    if sys.platform == "win32":
        return
    import fcntl

    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OSError(None, "another batch is writing there: wait for its end", folder) from None
