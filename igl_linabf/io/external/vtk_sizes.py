"""Check the sizes that a VTK file announces, because VTK allocates memory before it reads the data."""

import base64
import binascii
import re
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple
from xml.parsers.expat import ParserCreate

from ..limits import MAX_DIGITS, check_expansion, parse_size, parse_xml, reject_entities
from ..parsing import Damaged, import_optional

VALUE_BYTES = 8  # VTK's largest number type has 8 bytes
COUNTS = [f"NumberOf{what}" for what in ("Points", "Verts", "Lines", "Strips", "Polys", "Tuples")]
ARRAYS = ("DataArray", "Array")
COMPRESSORS = [f"vtk{method}DataCompressor" for method in ("ZLib", "LZ4", "LZMA")]
OFFSET_PATTERN = re.compile(r"\d+")
NO_SPACE_PATTERN = re.compile(rb"\S")
MAX_DEPTH = 100  # maximum number of nested elements; VTK visits them recursively


class _Element(NamedTuple):
    """The start of an XML element; `content` is the position after its tag, where VTK looks for data."""

    name: str
    attributes: dict[str, str]
    content: int


def _skip_space(data: bytes, start: int) -> int:
    """Return the position of the first byte from `start` that is not white space."""
    found = NO_SPACE_PATTERN.search(data, start)
    return found.start() if found else len(data)


@dataclass(frozen=True)
class _Stream:
    """The beginning of a binary array, which announces the array's size in words of 4 or 8 bytes."""

    data: bytes
    start: int
    is_raw: bool
    word: int
    order: Literal["big", "little"]

    def read_words(self, number: int) -> list[int]:
        """Return the first words; an array that is too short is read as zeros, and VTK reports it."""
        length = number * self.word
        found = self._read(0, length).ljust(length, b"\0")
        return [int.from_bytes(found[k : k + self.word], self.order) for k in range(0, length, self.word)]

    def read_last_number(self, width: int, compressor: str) -> int:
        """Return the last number, of `width` bytes, of an array; 0 for damaged data, which VTK reports."""
        first, block, last = self.read_words(3)
        if not compressor:
            begin = self.word + first - width
            return 0 if first < width else int.from_bytes(self._read(begin, width), self.order)
        packed = self.read_words(3 + first)[3:] or [0]
        header = self.word * (3 + first)
        begin = header if self.is_raw else 4 * -(-header // 3)  # a header in base64 is encoded separately
        blocks = replace(self, start=self._find_start() + begin)
        data = blocks._read(sum(packed[:-1]), packed[-1])
        return int.from_bytes(_uncompress(compressor, data, last or block)[-width:], self.order)

    def _find_start(self) -> int:
        """Return the position of the first byte or, in base64, of the first character after white space."""
        return self.start if self.is_raw else _skip_space(self.data, self.start)

    def _read(self, begin: int, length: int) -> bytes:
        start, end = self._find_start(), begin + length
        if self.is_raw:
            return self.data[start + begin : start + end]
        with suppress(binascii.Error):  # VTK reports invalid base64
            return base64.b64decode(self.data[start : start + 4 * -(-end // 3)])[begin:end]
        return b""


def _uncompress(compressor: str, data: bytes, size: int) -> bytes:
    """Return `size` bytes that one of VTK's compressors has compressed, or none if the data are damaged."""
    module = import_optional("vtkmodules.vtkIOCore")
    if compressor not in COMPRESSORS:
        raise Damaged(f"its compressor is {compressor[:40]!r}, not one of {', '.join(COMPRESSORS)}")
    found = bytearray(size)
    n = getattr(module, compressor)().Uncompress(data, len(data), found, size)
    return bytes(found[:n])


def check_announced_sizes(data: bytes) -> None:
    """Raise `Damaged` if announced sizes are out of proportion to the file, or XML entities are declared."""
    reject_entities(data)
    size, elements = len(data), _list_elements(data)
    width = max(parse_size(element.attributes, "NumberOfComponents", 1) for element in elements)
    values = sum(parse_size(element.attributes, count, 0) for element in elements for count in COUNTS)
    values *= max(width, 1)
    check_expansion(VALUE_BYTES * values, size, "its points and cells")
    compressor = elements[0].attributes.get("compressor", "")
    for element, stream in _list_streams(data, elements):
        (first,) = stream.read_words(1)
        if not compressor and first > size:
            raise Damaged(f"an array announces {first:,} bytes, but the file has {size:,}")
        if compressor and stream.word * first > size:
            raise Damaged(f"an array announces {first:,} blocks, but the file has {size:,} bytes")
        if compressor:
            _, block, last, *packed = stream.read_words(3 + first)
            check_expansion(first * block + last, size, "an array")
            if sum(packed) > size:
                raise Damaged(f"an array announces {sum(packed):,} compressed bytes of {size:,} in the file")
        if element.attributes.get("Name") == "offsets":
            width = 4 if "32" in element.attributes.get("type", "") else 8
            corners = stream.read_last_number(width, compressor)
            check_expansion(VALUE_BYTES * corners, size, "the corners of its cells")


def _list_elements(data: bytes) -> list[_Element]:
    """Return the elements of a file up to its appended data, and check the offsets of its cells."""
    elements, offsets, parser, depth = list[_Element](), list[str](), ParserCreate(), 0
    parser.buffer_text = True

    def start_element(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            raise Damaged(f"its XML has more than {MAX_DEPTH} nested elements")
        elements.append(_Element(name, attributes, data.find(b">", parser.CurrentByteIndex) + 1))
        if name == "AppendedData":
            raise StopIteration  # binary data follow, which expat cannot parse
        is_text = attributes.get("format") not in ("binary", "appended")
        has_offsets = is_text and attributes.get("Name") == "offsets"
        parser.CharacterDataHandler = offsets.append if has_offsets else None

    def end_element(_: str) -> None:
        nonlocal depth
        depth -= 1
        numbers = OFFSET_PATTERN.findall("".join(offsets))
        largest = max((int(number[: MAX_DIGITS + 1]) for number in numbers), default=0)
        check_expansion(VALUE_BYTES * largest, len(data), "the corners of its cells")
        offsets.clear()

    parser.StartElementHandler, parser.EndElementHandler = start_element, end_element
    with suppress(StopIteration):
        parse_xml(parser, data)
    return elements


def _list_streams(data: bytes, elements: list[_Element]) -> list[tuple[_Element, _Stream]]:
    """Return the binary arrays: their elements, and the beginnings of their data."""
    root, last = elements[0].attributes, elements[-1]
    word = 8 if root.get("header_type") == "UInt64" else 4
    order: Literal["big", "little"] = "big" if root.get("byte_order") == "BigEndian" else "little"
    appended, is_raw = last.content, last.attributes.get("encoding") == "raw"
    if last.name == "AppendedData":
        appended = _skip_space(data, appended)
        if data[appended : appended + 1] != b"_":
            raise Damaged("its appended data do not begin with an underscore")
    streams = []
    for element in elements:
        form = element.attributes.get("format")
        if element.name in ARRAYS and form == "binary":
            streams.append((element, _Stream(data, element.content, False, word, order)))
        elif element.name in ARRAYS and form == "appended":
            start = appended + 1 + parse_size(element.attributes, "offset", 0)
            streams.append((element, _Stream(data, start, is_raw, word, order)))
    return streams
