"""Parse numbers, tables and triangle strips, and report damage with its line; shared by all readers."""

from __future__ import annotations

import codecs
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from stat import S_ISREG
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..errors import MeshError
from ..surface import Polygons, index_and_rank


def triangulate_strips(corners: IntArray, strip: IntArray) -> tuple[IntArray, IntArray]:
    """Convert triangle strips to triangles with consistent orientation.

    Each corner forms a triangle with the two corners before it, and the orientation alternates. Triangles may
    contain a vertex twice, because programs join strips by degenerate triangles.

    Parameters
    ----------
    corners : (#C,) int64
        The vertices of all strips.
    strip : (#C,) int64
        The strip of each corner, in ascending order.

    Returns
    -------
    F : (#F, 3) int64
    strip : (#F,) int64
        The strip of each triangle.
    """
    position = np.arange(len(corners))
    first = np.maximum.accumulate(np.where(np.diff(strip, prepend=-1) != 0, position, 0))
    F = np.column_stack((corners[:-2], corners[1:-1], corners[2:]))
    odd = (position - first)[:-2] % 2 == 1
    F[odd] = F[odd][:, [1, 0, 2]]
    whole = strip[:-2] == strip[2:]
    return F[whole], strip[:-2][whole]


SPACE = ord(" ")
MAX_INDEX_DIGITS = len(str(np.iinfo(np.int64).max)) - 1  # all numbers of this many digits fit into 64 bits


class Damaged(Exception):  # noqa: N818  # internal; callers that know the file name raise MeshError instead
    """Raised if a file violates its format; the message names the damaged line or element."""


FaceLabels = tuple[tuple[str, ...], IntArray]  # names, and for each face the index of its name, or -1


@dataclass(frozen=True, eq=False)
class Extras:
    """The contents of a file other than the mesh and its texture coordinates; absent contents are None.

    Attributes
    ----------
    colours, face_colours : (#V, 3 or 4) float64, (#F, 3 or 4) float64
        Colours of vertices and of faces, from 0 to 1.
    corner_colours : (#C, 3 or 4) float64
        Colours of corners, if corners of a vertex or of a face have different colours.
    normals, normal : (#N, 3) float64, (#C,) int64
        Normals, and their rows at the corners.
    parts, materials : names and (#F,) int64
        Names of objects or groups and of materials, and the index of the name for each face.
    looks : tuple of Material or None
        The appearance of each material.
    units : str or None
        The unit of length with its name in 3MF, such as "millimeter" or "inch".
    comments : tuple of str
        Comment lines.
    unshared : tuple of str
        Descriptions, for warnings, of contents that no other format can store, such as "the elements camera".
    source : object
        Data that the writer of the same format needs to reproduce the file.
    """

    colours: FloatArray | None = None
    face_colours: FloatArray | None = None
    corner_colours: FloatArray | None = None
    normals: FloatArray | None = None
    normal: IntArray | None = None
    parts: FaceLabels | None = None
    materials: FaceLabels | None = None
    looks: tuple[Any, ...] | None = None  # not Material, to avoid a circular import
    units: str | None = None
    comments: tuple[str, ...] = ()
    unshared: tuple[str, ...] = ()
    source: Any = None


NO_EXTRAS = Extras()


class Property(NamedTuple):
    """The declaration of a table column, which has a number or a list of numbers in each row.

    Attributes
    ----------
    name : str
    type : str
        NumPy's code for the type of the numbers.
    length : str
        NumPy's code for the type of the list length; empty for single numbers.
    """

    name: str
    type: str
    length: str = ""

    @property
    def is_index_list(self) -> bool:
        return bool(self.length) and self.type[0] != "f"


@dataclass(frozen=True, eq=False)
class Column:
    """The values of one property in all rows; lists are concatenated, and `sizes` holds their lengths."""

    values: NDArray[Any]
    sizes: IntArray | None = None

    def __len__(self) -> int:
        return len(self.values if self.sizes is None else self.sizes)

    def select_rows(self, rows: IntArray) -> Column:
        """Return a column with the given rows only."""
        if self.sizes is None:
            return Column(self.values[rows])
        sizes = self.sizes[rows]
        start = (np.cumsum(self.sizes) - self.sizes)[rows]
        _, rank = index_and_rank(sizes)
        return Column(self.values[np.repeat(start, sizes) + rank], sizes)


Table = dict[str, Column]


def convert_to_utf8(data: bytes) -> bytes:
    """Remove the byte order mark of UTF-8 text, or convert UTF-16 text with a byte order mark to UTF-8."""
    if not data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode("utf-16").encode()
    except UnicodeError:
        raise Damaged("it begins as UTF-16 text, but continues in a different encoding") from None


def decode_utf8(data: bytes) -> str:
    """Decode UTF-8; invalid bytes become surrogates, as in Python's file names."""
    return data.decode("utf-8", "surrogateescape")


def encode_utf8(text: str) -> bytes:
    """Encode text as UTF-8; surrogates from `decode_utf8` become the original invalid bytes."""
    return text.encode("utf-8", "surrogateescape")


def parse_name(line: bytes) -> bytes:
    """Return the rest of a line after its keyword, as a name that may include spaces and `#`."""
    return (line.split(None, 1)[1:] or [b""])[0].strip()


def raise_damaged_line(line: int, text: bytes, what: str) -> NoReturn:
    """Raise `Damaged` for a line, by its number and text; `what` describes the problem."""
    raise Damaged(f"line {line}, {quote_line(text)}, {what}")


def quote_line(text: bytes, limit: int = 40) -> str:
    """Return the beginning of a damaged line in printable form."""
    whole = text.strip().decode("utf-8", "backslashreplace")
    return repr(whole if len(whole) <= limit else f"{whole[:limit]}...")


def parse_numbers(words: Sequence[bytes], count: int) -> list[float]:
    """Convert words to `count` numbers; return an empty list if this is impossible."""
    try:
        values = list(map(float, words))
    except ValueError:
        return []
    # Python accepts 1_000 as a number, but no mesh format does
    return values if len(values) == count and b"_" not in b"".join(words) else []


def parse_indices(words: Sequence[bytes], count: int) -> list[int]:
    """Convert words to `count` non-negative integers; return an empty list if this is impossible."""
    text = b"".join(words)
    if len(words) != count or not text.isdigit() or max(map(len, words)) > MAX_INDEX_DIGITS:
        return []
    return list(map(int, words))


def parse_integers(words: Sequence[bytes], count: int) -> list[int]:
    """Convert words to `count` integers; return an empty list if this is impossible."""
    unsigned = [word.removeprefix(b"-") for word in words]
    return list(map(int, words)) if all(unsigned) and parse_indices(unsigned, count) else []


def split_rows(data: bytes, comment: bytes = b"") -> tuple[list[bytes], list[int]]:
    """Split text into non-empty lines without comments; return them and their line numbers from 1."""
    lines = data.splitlines()
    if comment and comment in data:
        lines = [text.partition(comment)[0] for text in lines]
    lines = list(map(bytes.strip, lines))
    return [text for text in lines if text], [i for i, text in enumerate(lines, 1) if text]


def parse_table(
    rows: list[bytes], line_numbers: list[int], properties: Sequence[Property], what: str
) -> Table:
    """Return the columns of a text table; `what` describes the problem of a damaged line."""
    if not any(prop.length for prop in properties):
        values = _parse_number_table(rows, len(properties))
        if values is not None:
            return {prop.name: Column(values[:, k]) for k, prop in enumerate(properties)}
    elif len(properties) == 1 and properties[0].is_index_list:
        polygons = _parse_equal_lists(rows)
        if polygons is not None:
            return {properties[0].name: polygons}
    return _parse_rows(rows, line_numbers, properties, what)


def _parse_number_table(rows: list[bytes], columns: int) -> FloatArray | None:
    """Return the first `columns` words of each row as numbers; None if a word is not a number."""
    if not rows:
        return np.empty((0, columns))
    try:
        return np.loadtxt(rows, usecols=range(columns), ndmin=2, comments=None)
    except ValueError:
        return None


def _parse_equal_lists(rows: list[bytes]) -> Column | None:
    """Return the integers of rows `k v1 ... vk`; None unless all rows have the same k."""
    words = rows[0].split() if rows else []
    (k,) = parse_indices(words[:1], 1) or (0,)
    table = _parse_number_table(rows, k + 1) if 0 < k < len(words) else None
    if table is None or not (np.abs(table) < 2.0**53).all():
        return None
    if (table != np.round(table)).any() or (table[:, 0] != k).any():
        return None
    return Column(table[:, 1:].astype(np.int64).ravel(), np.full(len(table), k))


def _parse_rows(
    rows: list[bytes], line_numbers: list[int], properties: Sequence[Property], what: str
) -> Table:
    """Parse a table row by row, to support lists of different lengths and to report the damaged line."""
    values: list[list[float]] = [[] for _ in properties]
    sizes: list[list[int]] = [[] for _ in properties]
    for text, line in zip(rows, line_numbers, strict=True):
        words, k = text.split(), 0
        for prop, column, size in zip(properties, values, sizes, strict=True):
            n = 1
            if prop.length:
                (n,) = parse_indices(words[k : k + 1], 1) or [-1]
                size.append(n)
                k += 1
            read = (
                parse_numbers
                if not prop.is_index_list
                else parse_indices
                if prop.type[0] == "u"
                else parse_integers
            )
            entry: Sequence[float] = read(words[k : k + n], n) if n >= 0 else []
            if len(entry) != n:
                raise_damaged_line(line, text, what)
            column.extend(entry)
            k += n
    return {
        prop.name: Column(
            np.array(column, dtype=np.int64 if prop.is_index_list else np.float64),
            np.array(size, dtype=np.int64) if prop.length else None,
        )
        for prop, column, size in zip(properties, values, sizes, strict=True)
    }


def make_polygons(column: Column) -> Polygons:
    """Return the faces that a column of vertex lists defines."""
    return Polygons(column.values.astype(np.int64), np.asarray(column.sizes, dtype=np.int64))


def import_optional(
    module: str, hint: str = "pip install 'igl-linabf[formats]' reads and writes this format"
) -> Any:
    """Import a module of an optional package; if it is missing, the error message states the pip command."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(f"{error}: {hint}") from None


def check_regular_file(path: Path) -> None:
    """Raise a MeshError for a folder, a pipe or a device; reading a pipe may block for ever.

    Links are followed. Raise an OSError if the file does not exist.
    """
    if not S_ISREG(path.stat().st_mode):
        raise MeshError(f"{path} is a folder, a pipe or a device: copy its data to a regular file")


def call_reader(read: Callable[[Any], Any], given: Any) -> Any:
    """Call a third-party reader, suppress its warnings, and convert its exceptions to `Damaged`."""
    if isinstance(given, Path):
        check_regular_file(given)
        given.open("rb").close()  # raise OSError for a file that cannot be opened
        given = str(given)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read(given)
    except (MemoryError, Damaged):
        raise
    except Exception as error:  # third-party packages define their own exceptions
        raise Damaged(f"{type(error).__name__}: {error}") from None
