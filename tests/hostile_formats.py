"""Random hostile files of scene formats and of formats that other packages read, and their checks."""

from __future__ import annotations

import base64
import copy
import json
import tempfile
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import igl
import numpy as np
from gltf_files import write_scene
from hostile_files import mutate
from hostile_meshes import require

import igl_linabf as il
from igl_linabf.io import image_maps, read_file, write_file, write_mesh

VALUES: tuple[Any, ...] = (
    *(None, True, False, -1, 0, 1, 2, 3, 7, 255, 5123, 5126, 2**31, 2**32, 2**53, 2**63, 10**400),
    *(
        1.5,
        -0.0,
        1e308,
        "",
        "0",
        "a",
        "../a",
        "data:,",
        "data:;base64,!",
        "VEC3",
        "SCALAR",
        "MAT4",
        "\x1b[2J",
    ),
    *([], [0], [-1], [[]], [0, 0, 0], {}, {"index": 0}, {"index": 9}, {"extensions": {}}, {"uri": "a"}),
)
KEYS = (
    *(
        "extensions",
        "extras",
        "index",
        "texCoord",
        "indices",
        "targets",
        "sparse",
        "bufferView",
        "byteStride",
    ),
    *("matrix", "children", "mesh", "skin", "material", "uri", "sampler", "source", "input", "output"),
    *("baseColorTexture", "normalTexture", "KHR_texture_transform", "EXT_mesh_gpu_instancing", "attributes"),
    *(
        "EXT_mesh_features",
        "EXT_structural_metadata",
        "KHR_materials_variants",
        "FB_ngon_encoding",
        "mappings",
    ),
)
FORMATS = {
    "a.glb": "igl",
    "a.3mf": "lib3mf",
    "a.vtp": "pyvista",
    "a.surf.gii": "nibabel",
    "lh.white": "nibabel",
}
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC"
)


@cache
def scene_text() -> str:
    """Return the JSON of a glTF file with an embedded buffer that uses most features of the reader."""
    with tempfile.TemporaryDirectory() as folder:
        write_scene(Path(folder) / "a.glb")
        data = (Path(folder) / "a.glb").read_bytes()
    length = int.from_bytes(data[12:16], "little")
    text = json.loads(data[20 : 20 + length])
    text["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(data[28 + length :]).decode()
    texture = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2], "texCoord": 0}}}
    text["images"] = [{"uri": "data:image/png;base64," + base64.b64encode(PIXEL).decode()}]
    text["samplers"], text["textures"] = [{"wrapS": 33071}], [{"source": 0, "sampler": 0}]
    text["materials"][0] |= {"pbrMetallicRoughness": {"baseColorTexture": texture}, "normalTexture": texture}
    features = {"EXT_mesh_features": {"featureIds": [{"featureCount": 12}]}}
    variants = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}
    text["meshes"][0]["primitives"][0]["extensions"] = features | variants
    text["nodes"][3]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 6}}}
    text["skins"] = [{"joints": [0], "inverseBindMatrices": 6}]
    text["extensions"] = {
        "EXT_structural_metadata": {"propertyTables": [{"properties": {"p": {"values": 5}}}]},
        "KHR_materials_variants": {"variants": [{"name": "v"}]},
    }
    return json.dumps(text)


def mutate_description(text: Any, rng: np.random.Generator) -> None:
    """Replace, remove, copy or add entries at random places of the JSON of a glTF file."""
    places: list[tuple[Any, Any]] = []
    waiting = [text]
    while waiting:
        holder = waiting.pop()
        pairs = holder.items() if isinstance(holder, dict) else enumerate(holder)
        for key, value in pairs:
            places.append((holder, key))
            if isinstance(value, dict | list):
                waiting.append(value)
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        holder, key = places[rng.integers(len(places))]
        value = copy.deepcopy(VALUES[rng.integers(len(VALUES))])
        kind = rng.integers(5)
        if (isinstance(holder, list) and key >= len(holder)) or (
            isinstance(holder, dict) and key not in holder
        ):
            continue
        if kind == 0:
            del holder[key]
        elif kind == 1:
            other, name = places[rng.integers(len(places))]
            present = name in other if isinstance(other, dict) else name < len(other)
            holder[key] = copy.deepcopy(other[name]) if present else value
        elif kind == 2 and isinstance(holder[key], dict):
            holder[key][KEYS[rng.integers(len(KEYS))]] = value
        elif kind == 3 and isinstance(holder, list):
            holder.append(value)
        else:
            holder[key] = value


def check_description(seed: int) -> str:
    """Read and write a glTF file whose JSON is damaged."""
    rng = np.random.default_rng(seed)
    text = json.loads(scene_text())
    mutate_description(text, rng)
    return check("a.gltf", json.dumps(text).encode())


@cache
def good_file(name: str) -> bytes:
    """Return the bytes of an undamaged file; its name determines the format."""
    V, F = igl.icosahedron()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / name
        if name == "lh.white":
            il.io.import_optional("nibabel").freesurfer.write_geometry(str(path), V, F)
        elif name == "a.glb":
            write_scene(path)
        else:
            write_mesh(path, V, F, V[:, :2])
        return path.read_bytes()


def check_format(seed: int) -> str:
    """Read and write a damaged file of a scene format, or of a format that another package reads."""
    rng = np.random.default_rng(seed)
    name = str(rng.choice(list(FORMATS)))
    return check(name, mutate(good_file(name), rng))


def check(name: str, data: bytes) -> str:
    """Read a file and write it in three formats; return "refused" after a `MeshError` that names the file."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        path = Path(folder) / name
        path.write_bytes(data)
        try:
            mesh = read_file(path)
        except il.MeshError as error:
            require(str(error).isprintable() and folder in str(error), f"no place in {error}")
            return "refused"
        require(mesh.triangles.min() >= 0 and mesh.triangles.max() < len(mesh.V), "faces refer to nothing")
        end = "read and written"
        TC = np.nan_to_num(mesh.V[:, :2])
        for suffix in (".glb", ".obj", ".ply"):
            try:
                write_file(Path(folder) / f"b{suffix}", mesh, TC)
                read_file(Path(folder) / f"b{suffix}")
            except il.MeshError as error:
                require(str(error).isprintable(), f"{error} is not printable")
                end = "refused on writing"
        try:
            image_maps(mesh)
        except il.MeshError:
            end = "read without images"
        own = [w for w in caught if issubclass(w.category, il.MeshWarning)]
        require(len(own) == len(caught), f"warnings: {[str(w.message) for w in caught if w not in own]}")
        return end
