"""Store the results of a batch: a table with a row for each input, and journals of newer results."""

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

WRITING_PAUSE = 50  # shortest pause between writes of the table, in units of the duration of a write

WAITING = "waiting"
VALID, OVERLAPPING, FAULTY = Outcome.VALID.value, Outcome.OVERLAPPING.value, "faulty"
REFUSED, UNREADABLE, FAILED, OUT_OF_MEMORY, DIED = "refused", "unreadable", "failed", "out of memory", "died"
GOOD = frozenset(outcome.value for outcome in Outcome if outcome.good)
MISSING = frozenset({WAITING, UNREADABLE})  # outcomes after which every run retries the mesh
RETRYABLE = frozenset({FAILED, OUT_OF_MEMORY, DIED})  # outcomes after which `retry=True` retries the mesh

CSV, PARQUET = "results.csv", "results.parquet"
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "'")  # texts that start with these get a leading quote
JOURNAL, LOCK = ".results.journal", ".results.lock"


@dataclass(frozen=True)
class Row:
    """The row of one input of a batch; each attribute is a column of `results.csv`.

    Attributes
    ----------
    input : str
        Absolute path or URL.
    output : str
        File with the map, relative to the output folder.
    outcome : str
        For `unwrap`: "valid", "flipped", "overlapping", or "faulty" for other problems such as too much
        stretch. For `flatten`: the value of its `Outcome`. Without a map: "refused" after a `MeshError`,
        "unreadable", "out of memory", "died" if its process died three times without any other mesh,
        "failed" after any other error, or "waiting" if it has not been processed.
    message : str
        Problems of the map, and warnings.
    triangles, charts : int or None
    angle_distortion : float or None
        F/3nt, which is also the name of the column.
    stretch : float or None
        L2 stretch.
    flips : int or None
    seconds : float or None
        Time to read, flatten, measure and write the mesh.
    key : str
        Hash of the file's version and the settings. If it differs, the input is processed again.
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
        """Whether the input has a map without problems."""
        return self.outcome in GOOD

    @property
    def written(self) -> bool:
        """Whether the input has a map."""
        return self.charts is not None


NUMBER_TYPES = {name: get_args(kind)[0] for name, kind in get_type_hints(Row).items() if kind is not str}
COLUMNS = [field.name for field in fields(Row)]
HEADER = ["F/3nt" if name == "angle_distortion" else name for name in COLUMNS]


def escape_path(path: str) -> str:
    """Escape line breaks and bytes that are not UTF-8 in a path, for the table."""
    return path.encode("utf-8", "backslashreplace").decode().replace("\n", "\\n").replace("\r", "\\r")


def append_to_journal(row: Row, folder: str) -> None:
    """Append a row to the journal of this process in the output folder."""
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
    """The rows of an output folder, in memory and on disk. Only one process at a time can open it.

    Each process appends its results to its own journal with `append_to_journal`. The table file is written
    from time to time and when the table is closed. The journals are read when the table is opened. Therefore
    no result is lost if a process is killed, not even the results that workers have not reported. An output
    folder at a URL has no journals, so the table file may lack the last results.
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
                _lock_folder(self._lock, self.folder)
            self._rows = {row.input: row for row in self._read_csv()}
            for path in self._list_journals():  # journals are at least as recent as the table file
                self._rows |= {row.input: row for row in _read_journal(path)}
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, _: object, __: TracebackType | None) -> None:
        try:
            with nullcontext() if kind is None else suppress(OSError):  # do not replace the first error
                if self._rows:  # do not replace an existing table by an empty table
                    self.write()
                if kind is None:
                    self._remove_journals()
        finally:
            self._close()

    def _close(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def get_row(self, input: str) -> Row | None:
        """Return the row of an input, or None if the table has no such row."""
        return self._rows.get(input)

    def inputs_by_output(self) -> dict[str, str]:
        """Return a dict from the output to the input of each row."""
        return {row.output: row.input for row in self._rows.values()}

    def plan_rows(self, rows: Iterable[Row]) -> None:
        """Append the rows of the planned inputs, in order, to the rows of other inputs from earlier runs."""
        planned = {row.input: row for row in rows}
        kept = {row.input: row for row in self._rows.values() if row.outcome != WAITING}
        self._rows = {**{k: row for k, row in kept.items() if k not in planned}, **planned}
        self.write()
        self._remove_journals()
        self._cost = 0.0  # ignore the first write, which includes the import of pyarrow

    def add_row(self, row: Row) -> None:
        """Add a result to the table in memory, and write the table from time to time."""
        self._rows[row.input] = row
        if perf_counter() - self._written_at > WRITING_PAUSE * self._cost:
            self.write()

    def write(self) -> None:
        """Write the table to disk."""
        start = perf_counter()
        rows = list(self._rows.values())
        with (
            places.replace_atomically(places.join_path(self.folder, CSV)) as path,
            open(path, "w", newline="", encoding="utf-8") as file,
        ):
            writer = csv.writer(file)
            writer.writerow(HEADER)
            writer.writerows([_make_cell(getattr(row, name)) for name in COLUMNS] for row in rows)
        if find_spec("pyarrow"):
            with places.replace_atomically(places.join_path(self.folder, PARQUET)) as path:
                _save_parquet(path, rows)
        self._written_at = perf_counter()
        self._cost = self._written_at - start

    def _read_csv(self) -> list[Row]:
        try:
            with (
                places.fetch_file(places.join_path(self.folder, CSV)) as path,
                open(path, newline="", encoding="utf-8") as file,
            ):
                header, *lines = csv.reader(file)
            if header == HEADER:
                return [_parse_row(dict(zip(COLUMNS, line, strict=True))) for line in lines]
        except FileNotFoundError:
            return []
        except ValueError:  # the file is not from a batch
            pass
        raise OSError(
            None, "is not the table of a batch: move it elsewhere", places.join_path(self.folder, CSV)
        )

    def _list_journals(self) -> list[Path]:
        return [] if places.is_url(self.folder) else sorted(Path(self.folder).glob(f"{JOURNAL}-*"))

    def _remove_journals(self) -> None:
        """Remove the journals after their rows have been written to the table."""
        for path in self._list_journals():
            path.unlink(missing_ok=True)


def _read_journal(path: Path) -> list[Row]:
    whole, _, _ = path.read_bytes().rpartition(b"\n")  # a killed process may leave an incomplete line
    return [Row(**json.loads(line)) for line in whole.splitlines()]


def _make_cell(value: Any) -> Any:
    """Return the value of a cell; texts that spreadsheets would evaluate as formulas get a leading quote."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA_STARTS) else value


def _parse_row(cells: dict[str, str]) -> Row:
    values: dict[str, Any] = {name: text.removeprefix("'") for name, text in cells.items()}
    for name, kind in NUMBER_TYPES.items():
        values[name] = kind(cells[name]) if cells[name] else None
    return Row(**values)


def _save_parquet(path: str, rows: list[Row]) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    types = {int: pa.int64(), float: pa.float64(), str: pa.string()}
    columns = {
        title: pa.array([getattr(row, name) for row in rows], types[NUMBER_TYPES.get(name, str)])
        for title, name in zip(HEADER, COLUMNS, strict=True)
    }
    parquet.write_table(pa.table(columns), path)


def _lock_folder(lock: int, folder: str) -> None:
    """Lock the output folder against other batches; raise an `OSError` if it is locked."""
    if sys.platform == "win32":
        return
    import fcntl

    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OSError(None, "another batch is writing there: wait until it ends", folder) from None
