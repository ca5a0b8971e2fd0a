"""Convert arrays to Pillow images, and read and write image files."""

from __future__ import annotations

import os
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime import replacing
from .._types import FloatArray
from ..errors import MemoryLimitError, MeshError
from ..linalg import has_free_memory

# Pillow formats of textures, without EPS and WMF: Pillow decodes them by other programs.
FORMATS = ("AVIF", "BMP", "DDS", "GIF", "JPEG", "JPEG2000", "PNG", "PPM", "PSD", "SGI", "TGA", "TIFF", "WEBP")
PIXEL_MODES = {"1": 1, "L": 255, "LA": 255, "RGB": 255, "RGBA": 255, "I;16": 65535}  # largest pixel values
PIXEL_BYTES = 40  # estimated bytes of memory per pixel while an image is read
VALUES_AT_ONCE = 1 << 22  # number of values to convert at a time, to bound the memory
CHANNELS = {1: "L", 2: "LA", 3: "RGB", 4: "RGBA"}  # Pillow modes by number of channels


def make_image(image: ArrayLike) -> Any:
    """Return the Pillow image of an array with values from 0 to 1."""
    from PIL import Image

    pixels: NDArray[Any] = np.asarray(image, dtype=np.float64)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    if pixels.ndim != 3 or pixels.shape[2] not in CHANNELS or 0 in pixels.shape:
        raise MeshError(f"an image has the shape {pixels.shape}: pass rows, columns and 1 to 4 channels")
    bytes_ = np.empty(pixels.shape, dtype=np.uint8)
    step = max(VALUES_AT_ONCE // (pixels.shape[1] * pixels.shape[2]), 1)
    for row in range(0, len(pixels), step):
        strip = pixels[row : row + step]
        bytes_[row : row + step] = np.rint(np.clip(np.nan_to_num(strip), 0, 1) * 255)
    return Image.fromarray(np.ascontiguousarray(bytes_[:, :, 0] if pixels.shape[2] == 1 else bytes_))


def _open_image(data: bytes) -> Any:
    """Return the Pillow image of a file in one of the `FORMATS`."""
    from PIL import Image

    Image.init()
    return Image.open(BytesIO(data), formats=[kind for kind in FORMATS if kind in Image.OPEN])


def decode_image(data: bytes, name: str) -> FloatArray:
    """Decode the bytes of an image file to pixels (#rows, #columns, 1 to 4) from 0 to 1.

    Raises
    ------
    MeshError
        Pillow cannot read the image, or its pixels do not fit into memory.
    """
    from PIL import Image

    try:
        with _open_image(data) as file:
            if not has_free_memory(
                PIXEL_BYTES * file.width * file.height
            ):  # a small file may announce many pixels
                raise MemoryLimitError(
                    f"{name} has {file.width} x {file.height} pixels, too many for the memory: scale it down"
                )
            image: Image.Image = file
            transparent = file.mode == "PA" or file.info.get("transparency") is not None
            if transparent and file.mode in ("1", "L", "P", "PA", "RGB"):
                image = file.convert("LA" if file.mode in ("1", "L") else "RGBA")
            elif file.mode not in PIXEL_MODES:
                image = file.convert("RGB")
            rows = np.asarray(image, dtype=np.float64) / PIXEL_MODES[image.mode]
    except (MemoryLimitError, MemoryError):
        raise
    except Exception as error:  # decoders of damaged files raise exceptions of any kind
        raise MeshError(f"{name} cannot be read as an image ({error}): write it as PNG") from None
    return rows[:, :, None] if rows.ndim == 2 else rows


def measure_image(data: bytes, name: str) -> tuple[int, int]:
    """Return the width and height of an image file without decoding its pixels.

    Raises
    ------
    MeshError
        Pillow cannot read the image.
    """
    try:
        with _open_image(data) as file:
            return int(file.width), int(file.height)
    except MemoryError:
        raise
    except Exception as error:  # decoders of damaged files raise exceptions of any kind
        raise MeshError(f"{name} cannot be read as an image ({error}): write it as PNG") from None


def encode_png(image: ArrayLike) -> bytes:
    """Return the image as the bytes of a PNG file."""
    data = BytesIO()
    make_image(image).save(data, "PNG")
    return data.getvalue()


def write_image(path: str | os.PathLike[str], image: ArrayLike) -> None:
    """Write an image; the suffix selects the format.

    Parameters
    ----------
    path : path of a PNG file, or of another format that Pillow supports
    image : (#rows, #columns) or (#rows, #columns, 1 to 4) float
        Two channels are grey and alpha. Values are clipped to the range 0 to 1, NaN becomes 0, and 8 bits
        per channel are written.

    Raises
    ------
    MeshError
        The image has a different shape.
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import numpy as np, os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "ramp.png")
    >>> write_image(path, np.linspace(0, 1, 64).reshape(8, 8))
    >>> os.path.getsize(path) > 70
    True
    """
    with replacing(path) as temporary:
        make_image(image).save(temporary)
