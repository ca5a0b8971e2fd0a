"""Check the sizes that a VTK file announces, because VTK allocates memory before it reads the data."""

import base64
import binascii
import re
from collections.abc import Iterator
from typing import Literal

from ..limits import check_expansion, refuse_entities
from ..parsing import Damaged

VALUE_BYTES = 8  # VTK's largest number type has 8 bytes
COUNT_PATTERN = re.compile(rb"""NumberOf(?:Points|Verts|Lines|Strips|Polys|Tuples)\s*=\s*["'](\d+)["']""")
WIDTH_PATTERN = re.compile(rb"""NumberOfComponents\s*=\s*["'](\d+)["']""")
ARRAY_PATTERN = re.compile(rb"<(?:Data)?Array\b([^>]*)>")
ATTRIBUTE_PATTERN = re.compile(rb"""(\w+)\s*=\s*["']([^"']*)["']""")
APPENDED_PATTERN = re.compile(rb"<AppendedData([^>]*)>\s*_")
MAX_DIGITS = 18  # maximum number of decimal digits of a size that a file announces


def check_announced_sizes(data: bytes) -> None:
    """Raise `Damaged` if announced sizes are out of proportion to the file, or XML entities are declared."""
    refuse_entities(data)
    size = len(data)
    width = max(_parse_numbers(WIDTH_PATTERN.findall(data)), default=1)
    values = sum(_parse_numbers(COUNT_PATTERN.findall(data))) * max(width, 1)
    check_expansion(VALUE_BYTES * values, size, "its points and cells")
    (head,) = re.findall(rb"<VTKFile\b([^>]*)>", data[:10_000])[:1] or [b""]
    attributes = dict(ATTRIBUTE_PATTERN.findall(head))
    word = 8 if attributes.get(b"header_type") == b"UInt64" else 4
    order: Literal["big", "little"] = "big" if attributes.get(b"byte_order") == b"BigEndian" else "little"
    is_compressed = bool(attributes.get(b"compressor"))
    for header in _iterate_headers(data, 3 * word if is_compressed else word):
        numbers = [int.from_bytes(header[k : k + word], order) for k in range(0, len(header), word)]
        if not is_compressed and numbers[0] > size:
            raise Damaged(f"an array announces {numbers[0]:,} bytes, but the file has {size:,}")
        if is_compressed:
            blocks, block_bytes, _ = numbers
            if word * blocks > size:
                raise Damaged(f"an array announces {blocks:,} blocks, but the file has {size:,} bytes")
            check_expansion((blocks + 1) * block_bytes if blocks else 0, size, "an array")


def _parse_numbers(texts: list[bytes]) -> list[int]:
    if any(len(text) > MAX_DIGITS for text in texts):
        raise Damaged("it announces a number of more than 18 digits")
    return [int(text) for text in texts]


def _iterate_headers(data: bytes, length: int) -> Iterator[bytes]:
    """Yield the first `length` bytes of each binary array, which announce its size."""
    appended = APPENDED_PATTERN.search(data)
    for found in ARRAY_PATTERN.finditer(data, 0, len(data) if appended is None else appended.start()):
        attributes = dict(ATTRIBUTE_PATTERN.findall(found[1]))
        start, is_raw = found.end(), False
        if attributes.get(b"format") == b"appended" and appended is not None:
            start = appended.end() + sum(_parse_numbers([attributes.get(b"offset", b"0") or b"0"]))
            is_raw = b"base64" not in appended[1]
        elif attributes.get(b"format") != b"binary":
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
