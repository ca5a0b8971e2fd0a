"""PLY from bytes, in text or binary."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import some
from ..surface import FloatArray, IntArray
from .parsing import Damaged, fan, indices, numbers, rows_of, shown, table, table_of_polygons

TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
COUNT = 2**40  # rows at most


@dataclass(frozen=True, eq=False)
class Column:
    """The values of one property in all rows; of lists, one after the other, with their sizes."""

    values: NDArray[Any]
    sizes: IntArray | None


Columns = dict[str, Column]


@dataclass(frozen=True)
class Property:
    """One of an element's; `count` is the type of its list's length, empty for a scalar."""

    name: str
    type: str
    count: str

    @property
    def whole(self) -> bool:
        return self.type[0] != "f"


@dataclass(frozen=True)
class Element:
    """A table of the file."""

    name: str
    rows: int
    properties: list[Property]


def parse_ply(data: bytes) -> tuple[FloatArray, IntArray]:
    """Vertices (#V, 3) and triangles (#F, 3) of a PLY file, polygons split into fans.

    Raises
    ------
    Damaged
        With the line of a text, or the element of a binary file.
    """
    order, elements, start, line = _header(data)
    columns = _text(data[start:], elements, line) if not order else _binary(data[start:], elements, order)
    if "vertex" not in columns or "face" not in columns:
        raise Damaged("its head has no element vertex, or no element face")
    vertex, face = columns["vertex"], columns["face"]
    if not all(axis in vertex and vertex[axis].sizes is None for axis in "xyz"):
        raise Damaged("its element vertex has not the properties x, y and z")
    V = np.column_stack([vertex[axis].values.astype(np.float64) for axis in "xyz"])
    polygons = face.get("vertex_indices", face.get("vertex_index"))
    if polygons is None or polygons.sizes is None or polygons.values.dtype.kind == "f":
        raise Damaged("its element face has no list of integers vertex_indices")
    small = np.flatnonzero(polygons.sizes < 3)
    if len(small):
        raise Damaged(f"faces {some(small)} have less than three vertices")
    F, of = fan(polygons.values.astype(np.int64), polygons.sizes)
    outside = np.unique(of[((F < 0) | (len(V) <= F)).any(axis=1)])
    if len(outside):
        raise Damaged(f"faces {some(outside)} name vertices outside 0..{len(V) - 1}")
    return V, F


def _header(data: bytes) -> tuple[str, list[Element], int, int]:
    """Byte order ("" for text), the elements, and the byte and the line at which these begin."""
    order, elements, start = None, list[Element](), 0
    for line in itertools.count(1):
        end = data.find(b"\n", start)
        text = data[start : end if end >= 0 else start + 200]
        words = text.decode("latin-1").split()
        start = end + 1
        if line == 1:
            if words != ["ply"]:
                raise Damaged("it does not begin with the line ply")
        elif end < 0:
            raise Damaged("its head has no end_header")
        elif words[:1] == ["format"] and len(words) == 3 and words[1] in ORDERS:
            order = ORDERS[words[1]]
        elif words[:1] == ["element"] and len(words) == 3 and words[2].isdecimal() and int(words[2]) < COUNT:
            elements.append(Element(words[1], int(words[2]), []))
        elif words[:1] == ["property"] and elements and (of := _property(words[1:])):
            elements[-1].properties.append(of)
        elif words == ["end_header"]:
            break
        elif words and words[0] not in ("comment", "obj_info"):
            raise Damaged(f"line {line}, {shown(text)}, is not understood")
    if order is None:
        raise Damaged("its head has no line format")
    for element in elements:
        names = [of.name for of in element.properties]
        if not names or len(set(names)) < len(names):
            raise Damaged(f"its element {element.name} has no properties, or two of one name")
    if len({element.name for element in elements}) < len(elements):
        raise Damaged("it has two elements of one name")
    return order, elements, start, line


def _property(words: list[str]) -> Property | None:
    if len(words) == 2 and words[0] in TYPES:
        return Property(words[1], TYPES[words[0]], "")
    if len(words) == 4 and words[0] == "list" and TYPES.get(words[1], "f")[0] != "f" and words[2] in TYPES:
        return Property(words[3], TYPES[words[2]], TYPES[words[1]])
    return None


def _text(data: bytes, elements: list[Element], before: int) -> dict[str, Columns]:
    """Every row of every element, one a line."""
    rows, at = rows_of(data)
    wanted = sum(element.rows for element in elements)
    if len(rows) != wanted:
        raise Damaged(f"its head promises {wanted} rows in all, and {len(rows)} lines follow")
    columns, start = {}, 0
    for element in elements:
        end = start + element.rows
        columns[element.name] = _at_once(rows[start:end], element) or _one_by_one(
            rows[start:end], [before + i for i in at[start:end]], element
        )
        start = end
    return columns


def _at_once(rows: list[bytes], element: Element) -> Columns | None:
    """The columns of a table of scalars, or of one list, as it mostly is: fast."""
    properties = element.properties
    if not any(of.count for of in properties):
        values = table(rows, len(properties))
        if values is not None:
            return {of.name: Column(values[:, k], None) for k, of in enumerate(properties)}
    elif len(properties) == 1 and properties[0].whole:
        made = table_of_polygons(rows, exact=True)
        if made is not None:
            return {properties[0].name: Column(*made)}
    return None


def _one_by_one(rows: list[bytes], at: list[int], element: Element) -> Columns:
    values: list[list[float]] = [[] for _ in element.properties]
    sizes: list[list[int]] = [[] for _ in element.properties]
    for text, line in zip(rows, at, strict=True):
        words, k = text.split(), 0
        for of, column, size in zip(element.properties, values, sizes, strict=True):
            n = 1
            if of.count:
                (n,) = indices(words[k : k + 1], 1) or [-1]
                size.append(n)
                k += 1
            read = indices if of.count and of.whole else numbers
            entry: Sequence[float] = read(words[k : k + n], n) if n >= 0 else []
            if len(entry) != n:
                raise Damaged(f"line {line}, {shown(text)}, is no row of the element {element.name}")
            column.extend(entry)
            k += n
    return {
        of.name: Column(
            np.array(column, dtype=np.int64 if of.count and of.whole else np.float64),
            np.array(size, dtype=np.int64) if of.count else None,
        )
        for of, column, size in zip(element.properties, values, sizes, strict=True)
    }


def _binary(data: bytes, elements: list[Element], order: str) -> dict[str, Columns]:
    columns, start = {}, 0
    for element in elements:
        columns[element.name], start = _table(data, start, element, order)
    if start != len(data):
        raise Damaged(f"{len(data) - start} bytes follow after the rows that its head promises")
    return columns


def _table(data: bytes, start: int, element: Element, order: str) -> tuple[Columns, int]:
    """The rows of an element, all lists being as long as in its first row; or else one by one."""
    if not element.rows:
        none = np.empty(0, dtype=np.int64)
        return {of.name: Column(none, none if of.count else None) for of in element.properties}, start
    first, _ = _row(data, start, element, order)
    sizes = [len(entry) for entry in first]
    dtype = np.dtype(
        [
            field
            for k, (of, size) in enumerate(zip(element.properties, sizes, strict=True))
            for field in ((f"{k} size", order + (of.count or "V0")), (str(k), order + of.type, (size,)))
        ]
    )
    if len(data) - start >= element.rows * dtype.itemsize:
        table = np.frombuffer(data, dtype, element.rows, start)
        lists = [k for k, of in enumerate(element.properties) if of.count]
        if all((table[f"{k} size"] == sizes[k]).all() for k in lists):
            return {
                of.name: Column(table[str(k)].ravel(), np.full(len(table), sizes[k]) if of.count else None)
                for k, of in enumerate(element.properties)
            }, start + element.rows * dtype.itemsize
    rows = []
    for i in range(element.rows):
        row, start = _row(data, start, element, order, i)
        rows.append(row)
    return {
        of.name: Column(
            np.array([value for row in rows for value in row[k]], dtype=of.type),
            np.array([len(row[k]) for row in rows]) if of.count else None,
        )
        for k, of in enumerate(element.properties)
    }, start


def _row(data: bytes, start: int, element: Element, order: str, i: int = 0) -> tuple[list[Any], int]:
    """The values of each property in one row, and where the next row begins."""
    row: list[Any] = []
    try:
        for of in element.properties:
            size = 1
            if of.count:
                (size,) = struct.unpack_from(order + CODES[of.count], data, start)
                start += int(of.count[1])
            if not 0 <= size <= len(data) - start:
                raise Damaged(f"row {i} of the element {element.name} has a list of {size} values")
            row.append(struct.unpack_from(f"{order}{size}{CODES[of.type]}", data, start))
            start += size * int(of.type[1])
    except struct.error:
        raise Damaged(f"it ends in row {i} of the {element.rows} of the element {element.name}") from None
    return row, start
