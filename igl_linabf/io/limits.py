"""Limit memory in proportion to the size of a file, so that a small file cannot exhaust the memory."""

import re
import zlib
from collections.abc import Mapping
from xml.parsers.expat import ExpatError, XMLParserType

from .parsing import Damaged

MAX_EXPANSION = 200  # allowed bytes of memory per byte of a file; XML of meshes is compressed at most 50-fold
MIN_EXPANSION_LIMIT = 2**26  # bytes of memory that are allowed for any file
ZLIB_OR_GZIP = zlib.MAX_WBITS | 32  # makes zlib detect the format
MAX_DIGITS = 18  # maximum number of decimal digits of a size that a file announces
CHUNK = 2**16  # number of bytes to decompress at a time
ENTITY_PATTERN = re.compile(rb"<!ENTITY")


def get_max_expanded_bytes(size: int) -> int:
    """Return the number of bytes of memory that the contents of a file of `size` bytes may occupy."""
    return max(MIN_EXPANSION_LIMIT, MAX_EXPANSION * size)


def check_expansion(wanted: int, size: int, what: str) -> None:
    """Raise `Damaged` if `what` needs `wanted` bytes, out of proportion to a file of `size` bytes."""
    if wanted > get_max_expanded_bytes(size):
        raise Damaged(
            f"{what} would take {wanted:,} bytes, out of proportion to the {size:,} bytes of the file"
        )


def inflate(data: bytes, limit: int, what: str) -> bytes:
    """Decompress zlib or gzip data to at most `limit` bytes.

    Raises
    ------
    Damaged
        The data are damaged or longer than `limit`; `what` is their name in the message.
    """
    found, decoder = bytearray(), zlib.decompressobj(ZLIB_OR_GZIP)
    try:
        while data:
            found += decoder.decompress(data, CHUNK)
            if len(found) > limit:
                raise Damaged(f"{what} has more than {limit:,} bytes after decompression")
            data = decoder.unconsumed_tail
            if decoder.eof and (data := decoder.unused_data):  # a gzip file may have several members
                decoder = zlib.decompressobj(ZLIB_OR_GZIP)
    except zlib.error as error:
        raise Damaged(f"{what} cannot be decompressed ({error})") from None
    if not decoder.eof:
        raise Damaged(f"{what} is cut off")
    return bytes(found)


def reject_entities(data: bytes) -> None:
    """Raise `Damaged` if XML declares entities, which may expand to any size or include other files."""
    if ENTITY_PATTERN.search(data.replace(b"\0", b"")):  # zero bytes are removed to search UTF-16, too
        raise Damaged("its XML declares entities, which mesh files do not need: remove the declaration")


def parse_size(attributes: Mapping[str, str], key: str, default: int | None = None) -> int:
    """Return an attribute of an XML element that announces a size.

    Raises
    ------
    Damaged
        The attribute is not a number of at most `MAX_DIGITS` digits, or is missing and has no default.
    """
    text = attributes.get(key, "" if default is None else str(default)).strip()
    if not (text.isascii() and text.isdecimal() and len(text) <= MAX_DIGITS):
        raise Damaged(f"{key} is {text[:40]!r}, not a number of at most {MAX_DIGITS} digits")
    return int(text)


def parse_xml(parser: XMLParserType, data: bytes) -> None:
    """Run an expat parser; raise `Damaged` if the XML is malformed or its encoding is unknown."""
    try:
        parser.Parse(data, True)
    except Damaged:
        raise
    except (ExpatError, LookupError, ValueError) as error:
        raise Damaged(f"its XML is damaged ({error})") from None
