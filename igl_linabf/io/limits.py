"""Limits in proportion to a file, which keep a small file from taking much memory."""

import re
import zlib

from .parsing import Damaged

EXPANSION = 200  # bytes that a byte of a file may become; XML of meshes is compressed up to 50 times
ALWAYS_ALLOWED = 2**26  # bytes that any file may become
ZLIB_OR_GZIP = zlib.MAX_WBITS | 32  # the format is detected
CHUNK = 2**16  # bytes that are decompressed at once
ENTITY_PATTERN = re.compile(rb"<!ENTITY")


def largest_expansion(size: int) -> int:
    """Return the largest number of bytes that a file of `size` bytes may become."""
    return max(ALWAYS_ALLOWED, EXPANSION * size)


def check_expansion(wanted: int, size: int, what: str) -> None:
    """Raise `Damaged` if `wanted` bytes, which `what` announces, are out of proportion to the file."""
    if wanted > largest_expansion(size):
        raise Damaged(
            f"{what} would take {wanted:,} bytes, out of proportion to the {size:,} bytes of the file"
        )


def inflate(data: bytes, limit: int, what: str) -> bytes:
    """Decompress zlib or gzip data to at most `limit` bytes.

    Raises
    ------
    Damaged
        The data are damaged, or longer; `what` names them.
    """
    found, decoder = bytearray(), zlib.decompressobj(ZLIB_OR_GZIP)
    try:
        while data:
            found += decoder.decompress(data, CHUNK)
            if len(found) > limit:
                raise Damaged(f"{what} has more than {limit:,} bytes after decompression")
            data = decoder.unconsumed_tail
            if decoder.eof and (data := decoder.unused_data):  # several members follow each other
                decoder = zlib.decompressobj(ZLIB_OR_GZIP)
    except zlib.error as error:
        raise Damaged(f"{what} cannot be decompressed ({error})") from None
    if not decoder.eof:
        raise Damaged(f"{what} is cut off")
    return bytes(found)


def refuse_entities(data: bytes) -> None:
    """Raise `Damaged` if XML declares entities, which may expand to any size or name other files."""
    if ENTITY_PATTERN.search(data.replace(b"\0", b"")):  # also in UTF-16
        raise Damaged("its XML declares entities, which mesh files do not need: remove the declaration")
