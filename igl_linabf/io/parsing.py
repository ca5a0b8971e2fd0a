"""Shared by the readers: numbers, tables and triangle strips parsed; damage reported with its line."""

from __future__ import annotations

import codecs
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from ..surface import Polygons, index_and_rank


def triangulate_strips(corners: IntArray, strip: IntArray) -> tuple[IntArray, IntArray]:
    """Each corner makes a triangle with the two before it; every second one is turned.

    Some have a vertex twice: programs write them to join strips into one.

    Parameters
    ----------
    corners : (#C,) int64
        The vertices of all strips.
    strip : (#C,) int64
        The strip of each, which does not decrease.

    Returns
    -------
    F : (#F, 3) int64
    strip : (#F,) int64
        The strip of each.
    """
    position = np.arange(len(corners))
    first = np.maximum.accumulate(np.where(np.diff(strip, prepend=-1) != 0, position, 0))
    F = np.column_stack((corners[:-2], corners[1:-1], corners[2:]))
    odd = (position - first)[:-2] % 2 == 1
    F[odd] = F[odd][:, [1, 0, 2]]
    whole = strip[:-2] == strip[2:]
    return F[whole], strip[:-2][whole]


SPACE = ord(" ")
MAX_INDEX_DIGITS = len(str(np.iinfo(np.int64).max)) - 1  # any number of so many digits fits 64 bits


class Damaged(Exception):  # noqa: N818  # it is caught where the file's name is known
    """The file does not follow its format; the text says where."""


FaceLabels = tuple[tuple[str, ...], IntArray]  # names, and for each face the number of its name, or -1


@dataclass(frozen=True, eq=False)
class Extras:
    """What a file has beside the mesh and its texture coordinates; None for what it has not.

    Attributes
    ----------
    colours, face_colours : (#V, 3 or 4) float64, (#F, 3 or 4) float64
        Of vertices and of faces, from 0 to 1.
    corner_colours : (#C, 3 or 4) float64
        Of corners, where those of a vertex or of a face differ.
    normals, normal : (#N, 3) float64, (#C,) int64
        Normals, and their rows at the corners.
    parts, materials : names and (#F,) int64
        Objects or groups; materials.
    looks : tuple of Material or None
        What the materials look like.
    units : str or None
        Of length, as 3MF names them: "millimeter", "inch", ...
    comments : tuple of str
        Lines for people.
    unshared : tuple of str
        What else there is that no other format takes, as a warning names it: "the elements camera".
    source : object
        What only the format's own writer understands.
    """

    colours: FloatArray | None = None
    face_colours: FloatArray | None = None
    corner_colours: FloatArray | None = None
    normals: FloatArray | None = None
    normal: IntArray | None = None
    parts: FaceLabels | None = None
    materials: FaceLabels | None = None
    looks: tuple[Any, ...] | None = None  # of `materials`, which imports this
    units: str | None = None
    comments: tuple[str, ...] = ()
    unshared: tuple[str, ...] = ()
    source: Any = None


NO_EXTRAS = Extras()


class Property(NamedTuple):
    """A number, or a list of numbers, in each row; types are NumPy's.

    Attributes
    ----------
    name : str
    type : str
    length : str
        Type of the list's length; empty for a single number.
    """

    name: str
    type: str
    length: str = ""

    @property
    def is_of_indices(self) -> bool:
        return bool(self.length) and self.type[0] != "f"


@dataclass(frozen=True, eq=False)
class Column:
    """The values of one property in all rows; lists are concatenated, with their sizes."""

    values: NDArray[Any]
    sizes: IntArray | None = None

    def __len__(self) -> int:
        return len(self.values if self.sizes is None else self.sizes)

    def take(self, rows: IntArray) -> Column:
        """The values of these rows."""
        if self.sizes is None:
            return Column(self.values[rows])
        sizes = self.sizes[rows]
        start = (np.cumsum(self.sizes) - self.sizes)[rows]
        _, rank = index_and_rank(sizes)
        return Column(self.values[np.repeat(start, sizes) + rank], sizes)


Table = dict[str, Column]


def convert_to_utf8(data: bytes) -> bytes:
    """Text as UTF-8 without a byte order mark: editors put one before it, some shells write UTF-16."""
    if not data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode("utf-16").encode()
    except UnicodeError:
        raise Damaged("it begins as text in UTF-16, and goes on as something else") from None


def decode_utf8(data: bytes) -> str:
    """UTF-8 as text; bytes that are none stay what they are, as in Python's names of files."""
    return data.decode("utf-8", "surrogateescape")


def encode_utf8(text: str) -> bytes:
    """The bytes that `as_text` has read."""
    return text.encode("utf-8", "surrogateescape")


def parse_name(line: bytes) -> bytes:
    """What follows a keyword: blanks and # in it belong to a name."""
    return (line.split(None, 1)[1:] or [b""])[0].strip()


def raise_damaged(line: int, text: bytes, what: str) -> NoReturn:
    """Raise `Damaged` for a line; `what` says what is wrong with it."""
    raise Damaged(f"line {line}, {quote_line(text)}, {what}")


def quote_line(text: bytes, limit: int = 40) -> str:
    """The beginning of a damaged line, printable."""
    whole = text.strip().decode("utf-8", "backslashreplace")
    return repr(whole if len(whole) <= limit else f"{whole[:limit]}...")


def parse_numbers(words: Sequence[bytes], count: int) -> list[float]:
    """The words as `count` numbers; empty if they are not."""
    try:
        values = list(map(float, words))
    except ValueError:
        return []
    # Python, but no format, reads 1_000
    return values if len(values) == count and b"_" not in b"".join(words) else []


def parse_indices(words: Sequence[bytes], count: int) -> list[int]:
    """The words as `count` integers, 0 or larger; empty if they are not."""
    text = b"".join(words)
    if len(words) != count or not text.isdigit() or max(map(len, words)) > MAX_INDEX_DIGITS:
        return []
    return list(map(int, words))


def parse_integers(words: Sequence[bytes], count: int) -> list[int]:
    """The words as `count` integers; empty if they are not."""
    unsigned = [word.removeprefix(b"-") for word in words]
    return list(map(int, words)) if all(unsigned) and parse_indices(unsigned, count) else []


def split_rows(data: bytes, comment: bytes = b"") -> tuple[list[bytes], list[int]]:
    """The lines that are not empty, without comments, and their numbers, from 1."""
    lines = data.splitlines()
    if comment and comment in data:
        lines = [text.partition(comment)[0] for text in lines]
    lines = list(map(bytes.strip, lines))
    return [text for text in lines if text], [i for i, text in enumerate(lines, 1) if text]


def parse_table(
    rows: list[bytes], line_numbers: list[int], properties: Sequence[Property], what: str
) -> Table:
    """The columns of a text table; `at` has its line numbers, `what` describes a damaged line."""
    if not any(prop.length for prop in properties):
        values = _parse_number_table(rows, len(properties))
        if values is not None:
            return {prop.name: Column(values[:, k]) for k, prop in enumerate(properties)}
    elif len(properties) == 1 and properties[0].is_of_indices:
        polygons = _parse_equal_lists(rows)
        if polygons is not None:
            return {properties[0].name: polygons}
    return _parse_rows(rows, line_numbers, properties, what)


def _parse_number_table(rows: list[bytes], columns: int) -> FloatArray | None:
    """The first `columns` words of each row as numbers, if all of them are numbers: fast."""
    if not rows:
        return np.empty((0, columns))
    try:
        return np.loadtxt(rows, usecols=range(columns), ndmin=2, comments=None)
    except ValueError:
        return None


def _parse_equal_lists(rows: list[bytes]) -> Column | None:
    """Integers in rows `k v1 ... vk`, if k is the same in all rows: fast."""
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
                if not prop.is_of_indices
                else parse_indices
                if prop.type[0] == "u"
                else parse_integers
            )
            entry: Sequence[float] = read(words[k : k + n], n) if n >= 0 else []
            if len(entry) != n:
                raise_damaged(line, text, what)
            column.extend(entry)
            k += n
    return {
        prop.name: Column(
            np.array(column, dtype=np.int64 if prop.is_of_indices else np.float64),
            np.array(size, dtype=np.int64) if prop.length else None,
        )
        for prop, column, size in zip(properties, values, sizes, strict=True)
    }


def make_polygons(column: Column) -> Polygons:
    """Faces, which have at least three corners."""
    return Polygons(column.values.astype(np.int64), np.asarray(column.sizes, dtype=np.int64))
