"""Check the sizes that a VTK file announces, because VTK allocates memory before it reads the data."""

import base64
import binascii
import re
from collections.abc import Iterator
from typing import Literal, NamedTuple
from xml.parsers.expat import ExpatError, ParserCreate

from ..limits import check_expansion, refuse_entities
from ..parsing import Damaged

VALUE_BYTES = 8  # VTK's largest number type has 8 bytes
COUNTS = [f"NumberOf{what}" for what in ("Points", "Verts", "Lines", "Strips", "Polys", "Tuples")]
ARRAYS = ("DataArray", "Array")
NUMBER_PATTERN = re.compile(r"\s*\+?(\d+)")  # VTK ignores what follows the digits
MAX_DIGITS = 18  # maximum number of decimal digits of a size that a file announces


class _Element(NamedTuple):
    """The start of an XML element; `content` is the position after its tag, where VTK looks for data."""

    name: str
    attributes: dict[str, str]
    content: int

    def number(self, attribute: str, default: int = 0) -> int:
        """Return the number at the beginning of an attribute, or the default if there is none."""
        found = NUMBER_PATTERN.match(self.attributes.get(attribute, ""))
        if found is not None and len(found[1]) > MAX_DIGITS:
            raise Damaged("it announces a number of more than 18 digits")
        return default if found is None else int(found[1])


def check_announced_sizes(data: bytes) -> None:
    """Raise `Damaged` if announced sizes are out of proportion to the file, or XML entities are declared."""
    refuse_entities(data)
    size, elements = len(data), _list_elements(data)
    width = max((element.number("NumberOfComponents", 1) for element in elements), default=1)
    values = sum(element.number(count) for element in elements for count in COUNTS) * max(width, 1)
    check_expansion(VALUE_BYTES * values, size, "its points and cells")
    root = elements[0].attributes
    word = 8 if root.get("header_type") == "UInt64" else 4
    order: Literal["big", "little"] = "big" if root.get("byte_order") == "BigEndian" else "little"
    is_compressed = bool(root.get("compressor"))
    for header in _iterate_headers(data, elements, 3 * word if is_compressed else word):
        numbers = [int.from_bytes(header[k : k + word], order) for k in range(0, len(header), word)]
        if not is_compressed and numbers[0] > size:
            raise Damaged(f"an array announces {numbers[0]:,} bytes, but the file has {size:,}")
        if is_compressed:
            blocks, block_bytes, _ = numbers
            if word * blocks > size:
                raise Damaged(f"an array announces {blocks:,} blocks, but the file has {size:,} bytes")
            check_expansion((blocks + 1) * block_bytes if blocks else 0, size, "an array")


def _list_elements(data: bytes) -> list[_Element]:
    """Return the elements of a file up to its appended data."""
    elements, parser = list[_Element](), ParserCreate()

    def start(name: str, attributes: dict[str, str]) -> None:
        content = data.find(b">", parser.CurrentByteIndex) + 1
        elements.append(_Element(name, attributes, content))
        if name == "AppendedData":
            raise StopIteration  # the binary data that follow are no XML

    parser.StartElementHandler = start
    try:
        parser.Parse(data, True)
    except StopIteration:
        pass
    except ExpatError as error:
        raise Damaged(f"its XML is damaged ({error})") from None
    return elements


def _iterate_headers(data: bytes, elements: list[_Element], length: int) -> Iterator[bytes]:
    """Yield the first `length` bytes of each binary array, which announce its size."""
    last = elements[-1]
    appended = last if last.name == "AppendedData" else None
    for element in elements:
        start, is_raw = element.content, False
        if element.name not in ARRAYS:
            continue
        if element.attributes.get("format") == "appended" and appended is not None:
            start = data.find(b"_", appended.content) + 1 + element.number("offset")
            is_raw = appended.attributes.get("encoding") == "raw"
        elif element.attributes.get("format") != "binary":
            continue
        header = data[start : start + length]
        if not is_raw:
            text = data[start : start + 1000].lstrip()[: 4 * -(-length // 3)]
            try:
                header = base64.b64decode(text)[:length]
            except binascii.Error:
                continue  # VTK reports invalid base64
        if len(header) == length:
            yield header
