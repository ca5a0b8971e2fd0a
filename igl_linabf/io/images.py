"""Images: as files, and inside GLB files as the texture of what is there."""

from __future__ import annotations

import json
import os
import struct
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime import replacing
from ..errors import MeshError
from .files import write_mesh
from .gltf import write_glb

LINEAR_MIPMAPS, LINEAR = 9987, 9729  # glTF's numbers for filters
MODES = {1: "L", 3: "RGB", 4: "RGBA"}


def write_image(path: str | os.PathLike[str], image: ArrayLike) -> None:
    """Write an image; Pillow chooses the format by the suffix.

    Parameters
    ----------
    path : path of a PNG file, or of another format of Pillow
    image : (#rows, #columns) or (#rows, #columns, 1, 3 or 4) float
        From 0 to 1; what lies beyond is cut off, and NaN is 0. 8 bits a channel are written.

    Raises
    ------
    MeshError
        The image has another shape.
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
        _picture(image).save(temporary)


def write_textured(
    path: str | os.PathLike[str],
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike,
    image: ArrayLike,
) -> None:
    """Write a GLB file of a surface with an image as its texture.

    Parameters
    ----------
    path : path of a GLB file
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
        Texture coordinates in the unit square, v upwards.
    FTC : (#F, 3) int
    image : (#rows, #columns[, 1, 3 or 4]) float
        From 0 to 1, the upper row first, as `bake` returns it. Viewers take it for sRGB.

    Raises
    ------
    MeshError
        The suffix is not .glb, or arrays have other shapes.
    OSError
        The file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import igl, igl_linabf, os, tempfile
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F, resolution=64)
    >>> path = os.path.join(tempfile.mkdtemp(), "ball.glb")
    >>> write_textured(path, V, F, atlas.TC, atlas.FTC, igl_linabf.bake(V, F, atlas, V / 2 + 0.5, 64))
    >>> os.path.getsize(path) > 1000
    True
    """
    if os.path.splitext(path)[1].lower() != ".glb":
        raise MeshError(f"{path} does not end in .glb: images are written into GLB files only")
    with replacing(path) as temporary:
        write_mesh(temporary, V, F, TC, FTC)
        embed_texture(temporary, image)


def embed_texture(path: str | os.PathLike[str], image: ArrayLike) -> None:
    """Make an image the texture of all that a GLB file holds; colours at vertices are left out."""
    data = BytesIO()
    _picture(image).save(data, "PNG")
    with open(path, "rb") as file:
        content = file.read()
    length = struct.unpack_from("<I", content, 12)[0]
    description: dict[str, Any] = json.loads(content[20 : 20 + length])
    size = description["buffers"][0]["byteLength"]
    binary = content[28 + length : 28 + length + size]
    binary += b"\0" * (-len(binary) % 4)
    description["bufferViews"].append(
        {"buffer": 0, "byteOffset": len(binary), "byteLength": len(data.getvalue())}
    )
    description["buffers"][0]["byteLength"] = len(binary) + len(data.getvalue())
    description["images"] = [{"bufferView": len(description["bufferViews"]) - 1, "mimeType": "image/png"}]
    description["samplers"] = [{"magFilter": LINEAR, "minFilter": LINEAR_MIPMAPS}]
    description["textures"] = [{"source": 0, "sampler": 0}]
    for material in description["materials"]:
        shading = material.get("pbrMetallicRoughness", {})
        material["pbrMetallicRoughness"] = {**shading, "metallicFactor": 0, "baseColorTexture": {"index": 0}}
    for mesh in description["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["attributes"].pop("COLOR_0", None)  # viewers would multiply by it
    write_glb(str(path), description, [binary, data.getvalue()])


def _picture(image: ArrayLike) -> Any:
    from PIL import Image

    pixels: NDArray[Any] = np.asarray(image, dtype=np.float64)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    if pixels.ndim != 3 or pixels.shape[2] not in MODES or 0 in pixels.shape:
        raise MeshError(f"an image has the shape {pixels.shape}: pass rows, columns and 1, 3 or 4 channels")
    bytes_ = np.rint(np.clip(np.nan_to_num(pixels), 0, 1) * 255).astype(np.uint8)
    return Image.fromarray(np.ascontiguousarray(bytes_[:, :, 0] if pixels.shape[2] == 1 else bytes_))
