"""Read the container of glTF 2.0, text or binary: the JSON description and the buffers.

The description stays JSON, because libraries such as pygltflib discard unknown contents.
"""

import base64
import binascii
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import unquote

from ..parsing import Damaged
from ..references import Folder
from .compression import decompress_gltf
from .extensions import reject_required_extensions
from .scene import Gltf
from .validation import check_data, check_description

SCHEME_PATTERN = re.compile(r"[A-Za-z][\w+.-]+:")  # scheme of a URI; a single letter is a Windows drive


def load_gltf(path: Path, allow_outside: bool = False) -> Gltf:
    """Read the container of a glTF file, and its buffers that are stored in other files."""
    data = path.read_bytes()
    blob, size = b"", len(data)
    if data[:4] == b"glTF":
        data, blob = _split_chunks(data)
    try:
        text = json.loads(data, parse_constant=_reject_json_constant)
    except (ValueError, RecursionError) as error:
        raise Damaged(f"its description is not valid JSON ({error})") from None
    asset = text.get("asset") if isinstance(text, dict) else None
    version = str(asset.get("version", "")) if isinstance(asset, dict) else ""
    if version.split(".")[0] != "2":
        named = f"of version {version}" if version else "without a version"
        raise Damaged(f"it is a glTF {named}: write it as glTF 2.0, for example from Blender")
    check_description(text)
    reject_required_extensions(text)
    folder = Folder(path.parent, allow_outside)
    for image in text.get("images", ()):
        find_referenced_file(image.get("uri"), folder)  # raises if the image is outside the folder
    contents = dict[Path, bytes]()
    buffers = [
        # only buffer 0 can be in the container
        _read_buffer(buffer, folder, blob if i == 0 else b"", i, contents)
        for i, buffer in enumerate(text.get("buffers", ()))
    ]
    gltf = decompress_gltf(Gltf(text, buffers, folder, size))
    check_data(gltf)
    return gltf


def _reject_json_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a JSON number")


def _split_chunks(data: bytes) -> tuple[bytes, bytes]:
    """Return the JSON chunk and the binary chunk of a GLB file."""
    start, declared, chunks = 12, int.from_bytes(data[8:12], "little"), dict[bytes, bytes]()
    if declared > len(data):
        raise Damaged(f"its header declares {declared} bytes, but it has {len(data)}")
    while start + 8 <= len(data):
        length, kind = int.from_bytes(data[start : start + 4], "little"), data[start + 4 : start + 8]
        if start + 8 + length > len(data):
            raise Damaged(f"its chunk at byte {start} is cut off")
        chunks.setdefault(kind, data[start + 8 : start + 8 + length])
        start += 8 + length
    if b"JSON" not in chunks:
        raise Damaged("it has no chunk of JSON at byte 12")
    return chunks[b"JSON"], chunks.get(b"BIN\0", b"")


def _read_buffer(
    buffer: dict[str, Any], folder: Folder, inside: bytes, number: int, contents: dict[Path, bytes]
) -> bytes:
    """Return the bytes of a buffer; `contents` keeps the files, because many buffers may name one file."""
    uri = buffer.get("uri")
    if uri is None:
        return inside
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except (binascii.Error, ValueError):  # ValueError: characters that are not ASCII
            raise Damaged(f"its buffer {number} is not valid base64") from None
    file = find_referenced_file(uri, folder)
    if file is None:
        raise Damaged(f"its buffer {number} is in a file that is missing, {uri}")
    file = file.resolve()
    if file not in contents:
        contents[file] = file.read_bytes()
    return contents[file]


def find_referenced_file(uri: Any, folder: Folder) -> Path | None:
    """Return the file that a relative URI points to; None for other URIs and missing files.

    Raises
    ------
    MeshError
        The file is outside the folder.
    """
    return folder.find_file(unquote(uri)) if is_relative(uri) else None


def is_relative(uri: Any) -> bool:
    """Return True if a URI is relative to the folder of the file."""
    return isinstance(uri, str) and not SCHEME_PATTERN.match(uri)


def iterate_uris(value: Any) -> Iterator[tuple[dict[str, Any], str]]:
    """Yield each JSON object that holds a URI, and the key of the URI, such as "uri" or "schemaUri"."""
    if isinstance(value, list):
        for inner in value:
            yield from iterate_uris(inner)
    elif isinstance(value, dict):
        for key, inner in value.items():
            if key.lower().endswith("uri"):
                yield value, key
            elif key not in ("extras", "buffers"):
                yield from iterate_uris(inner)
