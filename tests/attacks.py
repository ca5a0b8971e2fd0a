"""Hostile files of all formats, and their check in a child process with limits on memory and time.

`python tests/attacks.py CASES.json ENDS.txt SECONDS` is the child process, as in `fuzzing.py`.
"""

from __future__ import annotations

import base64
import gzip
import json
import re
import struct
import tempfile
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import fuzzing
import igl
import numpy as np
import psutil
from hostile_meshes import require

import igl_linabf as il
from igl_linabf.io import image_maps, read_file, write_file

MEMORY = 2**30  # additional bytes that a case may allocate
SECONDS = 60  # processor time in seconds that a case may take
SECRET = "secret_4711"
V, F = igl.icosahedron()
V32, F16 = V.astype("<f4"), F.astype("<u2")
Build = Callable[[Path], Path]
ATTACKS: dict[str, tuple[Build, str]] = {}  # name: (function that writes the files into a folder, outcome)


def register_attack(name: str, outcome: str = "refused") -> Callable[[Build], Build]:
    """Return a decorator that registers a writer of hostile files and the outcome, "refused" or "right"."""

    def register(build: Build) -> Build:
        ATTACKS[name] = build, outcome
        return build

    return register


def make_gltf_text(**changes: Any) -> dict[str, Any]:
    """Return the JSON of a glTF icosahedron with an embedded buffer; `changes` replace its entries."""
    data = V32.tobytes() + F16.tobytes()
    text = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 60, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": V32.nbytes},
            {"buffer": 0, "byteOffset": V32.nbytes, "byteLength": F16.nbytes},
        ],
        "buffers": [{"byteLength": len(data), "uri": data_uri(data)}],
    }
    return text | changes


def data_uri(data: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def write_gltf(folder: Path, text: Any) -> Path:
    path = folder / "a.gltf"
    path.write_text(text if isinstance(text, str) else json.dumps(text))
    return path


def write(name: str, data: bytes) -> Build:
    """Return a function that writes one file."""

    def build(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return build


def png(width: int, height: int) -> bytes:
    """Return a PNG file that announces a size and has no pixels."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")


# References to files outside the folder of the mesh, in its sibling folder `outside`.
LEADING_OUT = {
    "..": "../outside/{}",
    "inside and out": "sub/../../outside/{}",
    "absolute": "{outside}/{}",
    "percent-encoded": "..%2Foutside%2F{}",
    "percent-encoded dots": "%2e%2e/outside/{}",
    "backslashes": "..\\outside\\{}",
    "encoded backslashes": "..%5Coutside%5C{}",
    "a link": "link_{}",
    "a linked folder": "linked/{}",
}


def write_secret_beside(folder: Path, name: str, how: str) -> str:
    """Write a secret file into the sibling folder, and return a reference to it."""
    outside = folder.parent / "outside"
    outside.mkdir()
    (folder / "sub").mkdir()
    (outside / name).write_bytes(f"newmtl {SECRET}\nKd 1 0 0\n{SECRET} {SECRET}\n".encode() + V32.tobytes())
    (folder / f"link_{name}").symlink_to(outside / name)
    (folder / "linked").symlink_to(outside)
    return LEADING_OUT[how].format(name, outside=outside)


def add_references() -> None:
    for how in LEADING_OUT:

        def buffer(folder: Path, how: str = how) -> Path:
            uri = write_secret_beside(folder, "secret.bin", how)
            return write_gltf(folder, make_gltf_text(buffers=[{"byteLength": 200, "uri": uri}]))

        def image(folder: Path, how: str = how) -> Path:
            images = [{"uri": write_secret_beside(folder, "secret.png", how)}]
            return write_gltf(folder, make_gltf_text(images=images, textures=[{"source": 0}]))

        register_attack(f"glTF: a buffer outside, {how}")(buffer)
        register_attack(f"glTF: an image outside, {how}")(image)
        if "%" in LEADING_OUT[how]:
            continue

        def library(folder: Path, how: str = how) -> Path:
            name = write_secret_beside(folder, "secret.mtl", how)
            return write_obj(folder, f"mtllib {name}\nusemtl {SECRET[:6]}\n")

        def map_(folder: Path, how: str = how) -> Path:
            name = write_secret_beside(folder, "secret.png", how)
            (folder / "a.mtl").write_text(f"newmtl red\nmap_Kd {name}\n")
            return write_obj(folder, "mtllib a.mtl\nusemtl red\n")

        register_attack(f"OBJ: a library outside, {how}", "right")(library)
        register_attack(f"MTL: an image outside, {how}", "right, without images")(map_)


def write_obj(folder: Path, head: str, tail: str = "") -> Path:
    lines = [f"v {x} {y} {z}" for x, y, z in V.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (F + 1).tolist()]
    path = folder / "a.obj"
    path.write_text(head + "\n".join(lines) + "\n" + tail, encoding="utf-8")
    return path


add_references()


@register_attack("glTF: an image by a file URI", "right")
def _(folder: Path) -> Path:
    write_secret_beside(folder, "secret.png", "..")
    images = [{"uri": f"file://{folder.parent / 'outside' / 'secret.png'}"}]
    return write_gltf(folder, make_gltf_text(images=images, textures=[{"source": 0}]))


@register_attack("glTF: an accessor without data announces 10^8 rows")
def _(folder: Path) -> Path:
    accessors = [{"componentType": 5126, "count": 10**8, "type": "VEC3"}, make_gltf_text()["accessors"][1]]
    return write_gltf(folder, make_gltf_text(accessors=accessors))


@register_attack("glTF: 20,000 primitives share one buffer")
def _(folder: Path) -> Path:
    data = np.zeros((20_000, 3), "<f4").tobytes()
    primitive = {"attributes": {"POSITION": 0}}
    return write_gltf(
        folder,
        make_gltf_text(
            meshes=[{"primitives": [primitive] * 20_000}],
            accessors=[{"bufferView": 0, "componentType": 5126, "count": 20_000, "type": "VEC3"}],
            bufferViews=[{"buffer": 0, "byteLength": len(data)}],
            buffers=[{"byteLength": len(data), "uri": data_uri(data)}],
        ),
    )


@register_attack("glTF: a thousand targets without data")
def _(folder: Path) -> Path:
    accessors = [*make_gltf_text()["accessors"], {"componentType": 5126, "count": 12, "type": "VEC3"}]
    accessors[0] = {**accessors[0], "count": 10**6}
    accessors[2]["count"] = 10**6
    primitive = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 2}] * 1000}
    return write_gltf(folder, make_gltf_text(accessors=accessors, meshes=[{"primitives": [primitive]}]))


@register_attack("glTF: 2,000 nodes each place the instances of one accessor", "right")
def _(folder: Path) -> Path:
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}
    return write_gltf(folder, make_gltf_text(nodes=[{"mesh": 0, "extensions": extension}] * 2_000))


def add_gltf_numbers() -> None:
    base = make_gltf_text()["accessors"]
    for count in (2**31, 2**32, 2**63, -1, 1.5, "12", None):
        register_attack(f"glTF: an accessor of {count} rows")(
            lambda folder, n=count: write_gltf(
                folder, make_gltf_text(accessors=[{**base[0], "count": n}, base[1]])
            )
        )
    for index in (2**31, 2**32 - 1):
        data = V32.tobytes() + np.array([0, 1, index], "<u4").tobytes()

        def wrong_index(folder: Path, data: bytes = data) -> Path:
            views = [{"buffer": 0, "byteLength": 144}, {"buffer": 0, "byteOffset": 144, "byteLength": 12}]
            accessors = [base[0], {**base[1], "componentType": 5125, "count": 3}]
            buffers = [{"byteLength": len(data), "uri": data_uri(data)}]
            return write_gltf(folder, make_gltf_text(bufferViews=views, accessors=accessors, buffers=buffers))

        register_attack(f"glTF: an index {index}")(wrong_index)
    for name in ("NaN", "Infinity", "1e999"):
        register_attack(f"glTF: a matrix of {name}")(
            lambda folder, name=name: write_gltf(
                folder, json.dumps(make_gltf_text(nodes=[{"mesh": 0, "scale": [7, 7, 7]}])).replace("7", name)
            )
        )
        register_attack(f"glTF: extras of {name}")(
            lambda folder, name=name: write_gltf(
                folder, json.dumps(make_gltf_text(extras="?")).replace('"?"', name)
            )
        )
    register_attack("glTF: a scale of 1e308 twice")(
        lambda folder: write_gltf(
            folder,
            make_gltf_text(
                nodes=[{"children": [1], "scale": [1e308] * 3}, {"mesh": 0, "scale": [1e308] * 3}]
            ),
        )
    )
    for value in (np.nan, np.inf):
        data = np.where(np.arange(36).reshape(12, 3) == 7, value, V32).astype("<f4").tobytes() + F16.tobytes()
        register_attack(f"glTF: a position {value}", "refused on writing")(
            lambda folder, data=data: write_gltf(
                folder, make_gltf_text(buffers=[{"byteLength": len(data), "uri": data_uri(data)}])
            )
        )


add_gltf_numbers()


@register_attack("glTF: nodes that are their own descendants")
def _(folder: Path) -> Path:
    return write_gltf(
        folder, make_gltf_text(nodes=[{"mesh": 0}, {"children": [2]}, {"children": [1], "mesh": 0}])
    )


@register_attack("glTF: 10^5 nested nodes", "right")
def _(folder: Path) -> Path:
    chain = [{"children": [i + 1]} for i in range(100_000)]
    return write_gltf(folder, make_gltf_text(nodes=[*chain, {"mesh": 0}]))


for depth in (90, 500, 100_000):

    @register_attack(f"glTF: JSON of {depth} levels", "right" if depth < 100 else "refused")
    def _(folder: Path, depth: int = depth) -> Path:
        text = json.dumps(make_gltf_text(extras=0))
        return write_gltf(folder, text.replace('"extras": 0', '"extras": ' + "[" * depth + "]" * depth))


for what, part in {
    "a name": {"nodes": [{"mesh": 0, "name": "\ud800"}]},
    "the copyright": {"asset": {"version": "2.0", "copyright": "\udfff"}},
    "a key": {"extras": {"a": [{"\ud800": 1}]}},
}.items():
    register_attack(f"glTF: half of a surrogate pair in {what}")(
        lambda folder, part=part: write_gltf(folder, make_gltf_text(**part))
    )


@register_attack("glTF: 20,000 buffers are the file itself", "right")
def _(folder: Path) -> Path:
    text = make_gltf_text(extras="x" * 500_000)
    text["buffers"] += [{"byteLength": 1, "uri": "a.gltf"}, {"byteLength": 1, "uri": "./%61.gltf"}] * 10_000
    return write_gltf(folder, text)


@register_attack("glTF: 20,000 buffer views share one buffer")
def _(folder: Path) -> Path:
    text = make_gltf_text(extensionsUsed=["UNKNOWN_views"], extensions={"UNKNOWN_views": {}})
    data = V32.tobytes() + F16.tobytes() + bytes(500_000)
    text["buffers"] = [{"byteLength": len(data), "uri": data_uri(data)}]
    text["bufferViews"] += [{"buffer": 0, "byteLength": len(data)}] * 20_000
    return write_gltf(folder, text)


@register_attack("glTF: 10,000 images are one file", "right")
def _(folder: Path) -> Path:
    (folder / "a.png").write_bytes(png(2, 2) + bytes(500_000))
    return write_gltf(folder, make_gltf_text(images=[{"uri": "a.png"}] * 10_000))


def write_textured_gltf(folder: Path, image: bytes | str) -> Path:
    """Write a material with an embedded image, given by its bytes or their base64."""
    encoded = image if isinstance(image, str) else base64.b64encode(image).decode()
    uri = f"data:image/png;base64,{encoded}"
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    text = make_gltf_text(images=[{"uri": uri}], textures=[{"source": 0}], materials=[material])
    text["meshes"][0]["primitives"][0]["material"] = 0
    return write_gltf(folder, text)


POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\nshowpage\n"
IMAGES: dict[str, bytes | str] = {
    "60,000 x 60,000 pixels": png(60_000, 60_000),
    "PostScript": POSTSCRIPT,
    "base64 that is cut off": "abc",
    "base64 that is not ASCII": "\xe9",
    "DDS of an unknown kind": b"DDS \x7c\0\0\0" + bytes(68) + b"\x20\0\0\0\x04\0\0\0WXYZ" + bytes(40),
    "PSD of 2^32 - 1 pixels": b"8BPS" + struct.pack(">H6xHIIHH", 1, 3, 2**32 - 1, 1, 8, 3) + bytes(14),
}
for what, image in IMAGES.items():
    register_attack(f"glTF: an image of {what}", "right, without images")(
        partial(write_textured_gltf, image=image)
    )


CONTROL = "\x1b]0;pwned\x07\r\n\u202e"


@register_attack("glTF: names that control a terminal", "right")
def _(folder: Path) -> Path:
    text = make_gltf_text(materials=[{"name": CONTROL, "alphaMode": "MASK"}], extensionsUsed=[CONTROL])
    text["meshes"][0]["primitives"][0] |= {"material": 0, "extensions": {CONTROL: {}}}
    text["meshes"][0]["primitives"][0]["attributes"][f"_{CONTROL}"] = 0
    text["meshes"][0]["name"] = text["nodes"][0]["name"] = CONTROL
    return write_gltf(folder, text)


@register_attack("glTF: a required extension that controls a terminal")
def _(folder: Path) -> Path:
    return write_gltf(folder, make_gltf_text(extensionsRequired=[CONTROL]))


def write_compressed(name: str, data: bytes, **mark: Any) -> Build:
    """Return a function that writes a glTF file whose mesh is compressed by Draco or meshopt."""

    def build(folder: Path) -> Path:
        text = make_gltf_text()
        text["buffers"].append({"byteLength": len(data), "uri": data_uri(data)})
        if name == DRACO:
            view = {"buffer": len(text["buffers"]) - 1, "byteLength": len(data)}
            text["bufferViews"].append(view)
            for accessor in text["accessors"]:
                del accessor["bufferView"]
            attributes = {"POSITION": 0}
            entry = {"bufferView": len(text["bufferViews"]) - 1, "attributes": attributes, **mark}
            text["meshes"][0]["primitives"][0]["extensions"] = {name: entry}
        else:
            entry = {
                "buffer": len(text["buffers"]) - 1,
                "byteLength": len(data),
                "mode": "ATTRIBUTES",
                **mark,
            }
            text["bufferViews"][0]["extensions"] = {name: entry}
        return write_gltf(folder, text)

    return build


DRACO, MESHOPT = "KHR_draco_mesh_compression", "EXT_meshopt_compression"
HUGE = b"\xff\xff\xff\xff\x0f"  # 2^32 - 1, in groups of seven bits
DRACO_HEAD = b"DRACO\x02\x02\x01\x01\x00\x00\x00"
MESHOPT_BLOCK = b"\xa0" + bytes(200)
for title, attack in {
    "Draco: 4 * 10^9 triangles": write_compressed(DRACO, DRACO_HEAD + b"\x04" + HUGE + bytes(90)),
    "Draco: 4 * 10^9 vertices": write_compressed(DRACO, DRACO_HEAD + HUGE + b"\x04" + bytes(90)),
    "Draco: data that end in the header": write_compressed(DRACO, DRACO_HEAD[:9]),
    "Draco: no data": write_compressed(DRACO, b""),
    "Draco: text instead of data": write_compressed(DRACO, b"x" * 1000),
    "Draco: an attribute that the data lack": write_compressed(DRACO, DRACO_HEAD, attributes={"NORMAL": 7}),
    "Draco: a buffer view that does not exist": write_compressed(DRACO, DRACO_HEAD, bufferView=10**9),
    "meshopt: 2^32 rows": write_compressed(MESHOPT, MESHOPT_BLOCK, count=2**32, byteStride=256),
    "meshopt: rows of 3 bytes": write_compressed(MESHOPT, MESHOPT_BLOCK, count=4, byteStride=3),
    "meshopt: no data": write_compressed(MESHOPT, b"", count=12, byteStride=12),
    "meshopt: zeros": write_compressed(MESHOPT, bytes(100), count=12, byteStride=12),
    "meshopt: random bytes": write_compressed(
        MESHOPT, b"\xa0" + np.random.default_rng(0).bytes(400), count=144, byteStride=256
    ),
    "meshopt: more rows than the view holds": write_compressed(
        MESHOPT, MESHOPT_BLOCK, count=99, byteStride=12
    ),
}.items():
    register_attack(title)(attack)


@register_attack("OBJ: names that control a terminal", "right")
def _(folder: Path) -> Path:
    name = CONTROL.replace("\r\n", "")
    return write_obj(folder, f"{name}\nmtllib {name}.mtl\nusemtl {name}\no {name}\n")


@register_attack("MTL: NaN, 1e999 and keywords with slashes", "right")
def _(folder: Path) -> Path:
    (folder / "a.png").write_bytes(b"no image")
    (folder / "a.mtl").write_text("newmtl red\nKd nan nan nan\nd 1e999\nKe inf 0 0\nmap_/../../x a.png\n")
    return write_obj(folder, "mtllib a.mtl\nusemtl red\n")


for corner in ("2147483648", "4294967296", "9223372036854775808", "-2147483649", "9" * 5000):
    register_attack(f"OBJ: an index {corner[:20]}")(
        lambda folder, corner=corner: write_obj(folder, "", f"f 1 2 {corner}\n")
    )
for number in ("nan", "1e999", "1e308"):
    register_attack(f"OBJ: a vertex {number}", "refused on writing")(
        lambda folder, number=number: write_obj(folder, "", f"v {number} 0 0\nf 1 2 13\n")
    )


@register_attack("OBJ: a face of 20,000 corners", "right")
def _(folder: Path) -> Path:
    t = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    star = (1 + 0.5 * (np.arange(20_000) % 2))[:, None] * np.column_stack((np.cos(t), np.sin(t)))
    lines = [f"v {x} {y} 0" for x, y in star.tolist()] + ["f " + " ".join(map(str, range(1, 20_001)))]
    return write("a.obj", "\n".join(lines).encode())(folder)


@register_attack("OBJ: a face of 4,000 random corners", "right")
def _(folder: Path) -> Path:
    places = np.random.default_rng(0).random((4_000, 3)).tolist()
    lines = [f"v {x} {y} {z}" for x, y, z in places] + ["f " + " ".join(map(str, range(1, 4_001)))]
    return write("a.obj", "\n".join(lines).encode())(folder)


@register_attack("MTL: 30,000 images of UDIM tiles", "right, without images")
def _(folder: Path) -> Path:
    (folder / "a.mtl").write_text(
        "newmtl red\n" + "".join(f"map_{i} {i}.<UDIM>.png\n" for i in range(30_000))
    )
    return write_obj(folder, "mtllib a.mtl\nusemtl red\n")


@register_attack("MTL: an image with a million folders in its path", "right, without images")
def _(folder: Path) -> Path:
    (folder / "a.mtl").write_text(f"newmtl red\nmap_Kd {'a/' * 10**6}b.png\n")
    return write_obj(folder, "mtllib a.mtl\nusemtl red\n")


PLY_HEAD = "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
register_attack("PLY: 4,000,000,000 vertices")(
    write("a.ply", (PLY_HEAD.format("binary_little_endian", 4 * 10**9) + "end_header\n").encode() + bytes(99))
)
register_attack("PLY: a list of 2^32 - 1 corners")(
    write(
        "a.ply",
        (
            PLY_HEAD.format("binary_little_endian", 3)
            + "element face 1\nproperty list uint int vertex_indices\nend_header\n"
        ).encode()
        + bytes(36)
        + b"\xff" * 4,
    )
)
register_attack("PLY: 10,000 lists of 0 or 1 numbers")(
    write(
        "a.ply",
        (
            PLY_HEAD.format("binary_little_endian", 0)
            + "element rows 500\n"
            + "".join(f"property list uchar uchar p{i}\n" for i in range(10_000))
            + "element face 0\nproperty list uchar int vertex_indices\nend_header\n"
        ).encode()
        + b"".join(b"\x01\0" * k + b"\0" * (10_000 - k) for k in range(500)),
    )
)
register_attack("PLY: properties that control a terminal")(
    write("a.ply", PLY_HEAD.format("ascii", 0).encode() + f"{CONTROL[:9]}\nend_header\n".encode())
)
register_attack("OFF: 4,000,000,000 vertices")(write("a.off", b"OFF\n4000000000 4000000000 0\n0 0 0\n"))
register_attack("STL: 2^32 - 1 triangles")(write("a.stl", bytes(80) + b"\xff" * 4 + bytes(50)))
register_attack("FreeSurfer: 2^31 - 1 vertices")(
    write("lh.white", b"\xff\xff\xfemade\n\n" + struct.pack(">ii", 2**31 - 1, 2**31 - 1) + bytes(99))
)
register_attack("FreeSurfer: a quadrangle file of 2^24 - 1 vertices")(
    write("lh.white", b"\xff\xff\xff" + b"\xff" * 6 + bytes(99))
)


@register_attack("FreeSurfer: a patch of 2^32 - 1 vertices")
def _(folder: Path) -> Path:
    nibabel = il.io.import_optional("nibabel")
    nibabel.freesurfer.write_geometry(str(folder / "lh.white"), V, F)
    return write("lh.cut.patch.3d", b"\xff" * 8 + bytes(99))(folder)


ENTITIES = '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa">{}]>'.format(
    "".join(f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(12))
)


def gifti(
    data: str,
    encoding: str = "ASCII",
    rows: int = 12,
    doctype: str = "",
    name: str = "",
    dimensions: int = 2,
    more: str = "",
) -> bytes:
    def array(intent: str, kind: str, text: str) -> str:
        return (
            f'<DataArray {more}Intent="NIFTI_INTENT_{intent}" DataType="NIFTI_TYPE_{kind}" '
            f'ArrayIndexingOrder="RowMajorOrder" Dimensionality="{dimensions}" Dim0="{rows}" Dim1="3" '
            f'Encoding="{encoding}" Endian="LittleEndian" ExternalFileName="{name}" ExternalFileOffset="">'
            f"<Data>{text}</Data></DataArray>"
        )

    arrays = array("POINTSET", "FLOAT32", data) + array("TRIANGLE", "INT32", data)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>{doctype}<GIFTI Version="1.0" NumberOfDataArrays="2">{arrays}'
        "</GIFTI>"
    ).encode()


BOMB = zlib.compress(bytes(2**28), 9)
register_attack("GIFTI: entities")(write("a.surf.gii", gifti("&m;", doctype=ENTITIES)))
register_attack("GIFTI: arrays of 10^9 rows")(write("a.surf.gii", gifti("0 0 0", rows=10**9)))
register_attack("GIFTI: arrays that decompress to 268 MB")(
    write("a.surf.gii", gifti(base64.b64encode(BOMB).decode(), "GZipBase64Binary"))
)
register_attack("GIFTI: arrays of 10^9 rows after an attribute with >")(
    write("a.surf.gii", gifti("0 0 0", rows=10**9, more='A=">" '))
)
register_attack("GIFTI: arrays of -1 rows")(write("a.surf.gii", gifti("0 0 0", rows=-1)))
register_attack("GIFTI: another root element")(write("a.surf.gii", b'<?xml version="1.0"?><X/>'))
register_attack("GIFTI: an unknown encoding")(
    write("a.surf.gii", gifti("0 0 0").replace(b"UTF-8", b"UTF-81_0"))
)
register_attack("VTP: an unknown encoding")(
    lambda folder: write("a.vtp", vtp().replace(b'"1.0"?', b'"1.0" encoding="UTF-81_0"?'))(folder)
)
register_attack("GIFTI: complex points")(
    write("a.surf.gii", gifti("0 0 0").replace(b"TYPE_FLOAT32", b"TYPE_COMPLEX64"))
)
register_attack("GIFTI: 10^11 dimensions")(write("a.surf.gii", gifti("0 0 0", dimensions=10**11)))
for how, text in (("between other characters", "!{}"), ("in CDATA", "<![CDATA[{}]]>"), ("beside", "<a/>{}")):
    register_attack(f"GIFTI: arrays that decompress to 268 MB, {how}")(
        write("a.surf.gii", gifti(text.format(base64.b64encode(BOMB).decode()), "B64GZ"))
    )
for how in LEADING_OUT:
    if "%" not in LEADING_OUT[how]:

        @register_attack(f"GIFTI: an array outside, {how}")
        def array_outside(folder: Path, how: str = how) -> Path:
            name = write_secret_beside(folder, "secret.dat", how)
            return write("a.surf.gii", gifti("", "ExternalFileBinary", name=name))(folder)


register_attack("GIFTI: a text that decompresses to 1 GB")(
    lambda folder: write("a.surf.gii.gz", gzip.compress(gifti(" " * 2**28), 9) * 4)(folder)
)


def vtp(
    points: int | str = 12, width: int | str = 3, doctype: str = "", data: str = "", form: str = "ascii"
) -> bytes:
    numbers = data or " ".join(map(str, V.ravel().tolist()))
    corners, ends = " ".join(map(str, F.ravel().tolist())), " ".join(map(str, range(3, 61, 3)))
    packed = ' compressor="vtkZLibDataCompressor"' if form == "binary" else ""
    return (
        f'<?xml version="1.0"?>{doctype}<VTKFile type="PolyData" version="0.1" '
        f'byte_order="LittleEndian"{packed}>'
        f'<PolyData><Piece NumberOfPoints="{points}" NumberOfPolys="20"><Points><DataArray type="Float32" '
        f'NumberOfComponents="{width}" format="{form}">{numbers}</DataArray></Points><Polys>'
        f'<DataArray type="Int64" Name="connectivity" format="ascii">{corners}</DataArray>'
        f'<DataArray type="Int64" Name="offsets" format="ascii">{ends}</DataArray>'
        "</Polys></Piece></PolyData></VTKFile>"
    ).encode()


register_attack("VTP: a plain file", "right")(write("a.vtp", vtp()))
register_attack("VTP: entities")(write("a.vtp", vtp(doctype=ENTITIES, data="&m;")))
register_attack("VTP: 10^9 points")(write("a.vtp", vtp(points=10**9)))
register_attack("VTP: 10^9 components")(write("a.vtp", vtp(width=10**9)))
for number in ("1000000000x", " 1000000000", "+1000000000", "1&#48;00000000"):
    register_attack(f"VTP: {number} points")(write("a.vtp", vtp(points=number)))
    register_attack(f"VTP: {number} components")(write("a.vtp", vtp(width=number)))
register_attack("VTP: 10^9 components in UTF-16")(
    write("a.vtp", vtp(width=10**9).decode().replace('"1.0"?', '"1.0" encoding="UTF-16"?').encode("utf-16"))
)
register_attack("VTP: -1 components")(write("a.vtp", vtp(width=-1)))
for blocks in (
    (1, 2**31, 0, 9),
    (2**30, 2**15, 0, 9),
    (2, 2**32 - 1, 1, 9),
    (1, 16, 2**32 - 1, 9),
    (1, 16, 0, 2**31),
):
    for spaces in (0, 1100):
        data = " " * spaces + base64.b64encode(struct.pack("<4I", *blocks)).decode()
        register_attack(f"VTP: compressed blocks {blocks} after {spaces} spaces")(
            write("a.vtp", vtp(data=data, form="binary"))
        )
register_attack("VTP: an offset of 10^15 corners")(
    write("a.vtp", vtp().replace(b" 60</DataArray>", b" 1000000000000000</DataArray>"))
)
FAR_OFFSETS = base64.b64encode(struct.pack("<I20q", 160, *[10**15] * 20))
register_attack("VTP: a binary offset of 10^15 corners")(
    write(
        "a.vtp", re.sub(rb'offsets" format="ascii">[^<]*', b'offsets" format="binary">' + FAR_OFFSETS, vtp())
    )
)
for method in ("ZLib", "LZ4", "LZMA"):

    @register_attack(f"VTP: an offset of 10^15 corners compressed by {method}")
    def compressed_offsets(folder: Path, method: str = method) -> Path:
        numbers, packed = np.full(20, 10**15).tobytes(), bytearray(1000)
        module = il.io.import_optional("vtkmodules.vtkIOCore")
        compressor = getattr(module, f"vtk{method}DataCompressor")()
        size = compressor.Compress(numbers, len(numbers), packed, len(packed))
        header = base64.b64encode(struct.pack("<4I", 1, len(numbers), 0, size))
        data = header + base64.b64encode(bytes(packed[:size]))
        text = re.sub(rb'offsets" format="ascii">[^<]*', b'offsets" format="binary">' + data, vtp())
        root = f'version="0.1" compressor="{compressor.GetClassName()}"'.encode()
        return write("a.vtp", text.replace(b'version="0.1"', root))(folder)


register_attack("VTP: an unknown compressor")(
    write("a.vtp", vtp().replace(b"byte_order", b'compressor="vtkXDataCompressor" byte_order'))
)
register_attack("VTP: 10^5 nested elements")(
    write("a.vtp", vtp().replace(b"<Points>", b"<a>" * 10**5 + b"</a>" * 10**5 + b"<Points>"))
)


def package(model: str, compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Return a 3MF file with a model."""
    types = (
        '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
        "</Types>"
    )
    relations = (
        '<?xml version="1.0"?><Relationships '
        'xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
        'Target="/3D/3dmodel.model" Id="r" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
    )
    data = BytesIO()
    with zipfile.ZipFile(data, "w", compression, compresslevel=9) as file:
        file.writestr("[Content_Types].xml", types)
        file.writestr("_rels/.rels", relations)
        file.writestr("3D/3dmodel.model", model)
    return data.getvalue()


def model_3mf(objects: str, build: int = 1, doctype: str = "", padding: str = "") -> str:
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>{doctype}<model unit="millimeter" '
        f'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>{objects}</resources>'
        f'{padding}<build><item objectid="{build}"/></build></model>'
    )


MESH_3MF = (
    '<object id="1" type="model"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
    '<vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices><triangles><triangle v1="0" v2="2" '
    'v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="3"/><triangle v1="2" v2="0" '
    'v3="3"/></triangles></mesh></object>'
)
ASSEMBLIES = "".join(
    f'<object id="{i}" type="model"><components>'
    + f'<component objectid="{i - 1}"/>' * 10
    + "</components></object>"
    for i in range(2, 10)
)
register_attack("3MF: a plain file", "right")(write("a.3mf", package(model_3mf(MESH_3MF))))
register_attack("3MF: entities")(write("a.3mf", package(model_3mf(MESH_3MF, doctype=ENTITIES))))
register_attack("3MF: a zip bomb of 268 MB")(
    lambda folder: write("a.3mf", package(model_3mf(MESH_3MF, padding=" " * 2**28)))(folder)
)
register_attack("3MF: assemblies of 10^8 objects")(
    write("a.3mf", package(model_3mf(MESH_3MF + ASSEMBLIES, build=9)))
)


@contextmanager
def limit_resources() -> Iterator[None]:
    """Limit the memory and the processor time of this process."""
    import resource

    used, hard = resource.getrusage(resource.RUSAGE_SELF), resource.getrlimit(resource.RLIMIT_AS)[1]
    seconds = int(used.ru_utime + used.ru_stime)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds + SECONDS, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_AS, (psutil.Process().memory_info().vms + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, hard))


def check_attack(name: str, _: int = 0) -> str:
    """Read the files of an attack, write them in other formats, and return the outcome."""
    build, _ = ATTACKS[name]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "given"
        folder.mkdir()
        path = build(folder)
        before = sorted(Path(place).rglob("*"))
        with warnings.catch_warnings(record=True) as caught, limit_resources():
            warnings.simplefilter("always")
            end = read_and_write(path, Path(place) / "out")
        messages = [end, *(str(warning.message) for warning in caught)]
        require(all(message.isprintable() for message in messages), f"messages are not printable: {messages}")
        require(SECRET not in "".join(messages), f"a secret is in {messages}")
        outputs = [path for path in Path(place).rglob("*") if path not in before and path.is_file()]
        require(all(path.parent.name == "out" for path in outputs), f"other files were written: {outputs}")
        require(all(SECRET.encode() not in path.read_bytes() for path in outputs), "a secret was written")
        for path in outputs:
            if path.suffix == ".glb":
                read_file(path)  # checks that the JSON is strict
        return end.partition(":")[0]


def read_and_write(path: Path, out: Path) -> str:
    """Read a file and write it as GLB, OBJ and PLY; return the outcome."""
    out.mkdir()
    try:
        mesh = read_file(path)
    except il.MeshError as error:
        require(path.name in str(error) or str(path.parent) in str(error), f"no file in {error}")
        return f"refused: {error}"
    end = "right"
    TC = mesh.V[:, :2] - mesh.V[:, :2].min(axis=0)
    for suffix in (".glb", ".obj", ".ply"):
        try:
            write_file(out / f"b{suffix}", mesh, TC)
        except il.MeshError as error:
            end = f"refused on writing: {error}"
    try:
        image_maps(mesh)
    except il.MeshError as error:
        end = f"{end}, without images: {error}"
    return end


def main() -> None:
    fuzzing.run_as_child({name: partial(check_attack, name) for name in ATTACKS})


if __name__ == "__main__":
    main()
