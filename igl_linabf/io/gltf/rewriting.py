"""Write glTF and GLB: a new file, or the one that was read with texture coordinates."""

import copy
import mimetypes
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from ..._types import IntArray
from ..materials import PLAIN, Material, as_gltf, warn_of_images
from ..mesh_file import MeshFile
from ..vertex_splits import single_precision, unique_tuples
from .ngons import EXTENSION
from .reading import TEXTURE, GltfFile
from .scene import Gltf, Mode, Target
from .writing import Buffer, save_new_gltf, triangles_of, write_gltf

# keys of accessors; and all in "attributes"
REFERENCES = {"indices", "input", "output", "inverseBindMatrices"}


def save_gltf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write GLB or glTF: a new file, or the one that was read with texture coordinates."""
    if isinstance(mesh.extras.source, GltfFile):
        _rewrite_gltf(temporary, mesh, mesh.extras.source)
    else:
        save_new_gltf(temporary, mesh)


def _rewrite_gltf(temporary: str, mesh: MeshFile, source: GltfFile) -> None:
    """The file that was read, each primitive's vertices once for each of their texture coordinates."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    gltf, text, buffer = source.gltf, copy.deepcopy(source.gltf.text), Buffer()
    primitives = [text["meshes"][of.mesh]["primitives"][of.number] for of in source.primitives]
    old = [(its.pop("attributes"), its.pop("targets", [])) for its in primitives]
    for its in primitives:
        its.pop("indices", None)
    if mesh.image is None:
        warn_of_images(len(text.get("textures", ())))
    else:
        text.pop("images", None)  # it is the only one then
    _carry_over(gltf, text, buffer)
    map_ = mesh.TC * [1, -1] + [0, 1]
    for of, primitive, (attributes, targets) in zip(source.primitives, primitives, old, strict=True):
        (own, texture), vertex = unique_tuples(of.vertex, mesh.texture[of.corners])

        def taken(numbers: dict[str, int], rows: IntArray = own) -> dict[str, int]:
            return {
                key: buffer.add(gltf.array(number)[rows], like=gltf.text["accessors"][number])
                for key, number in numbers.items()
            }

        attributes.pop(TEXTURE, None)
        st = buffer.add(single_precision(map_[texture], "TC"))
        primitive |= {"mode": Mode.TRIANGLES, "attributes": {**taken(attributes), TEXTURE: st}}
        if targets:
            primitive["targets"] = [taken(target) for target in targets]
        triangles, extensions = triangles_of(mesh, of.faces, of.corners, vertex)
        primitive["indices"] = buffer.add(triangles.ravel(), Target.INDICES)
        if extensions:
            primitive.setdefault("extensions", {}).update(extensions["extensions"])
            if EXTENSION not in text.setdefault("extensionsUsed", []):
                text["extensionsUsed"].append(EXTENSION)
        if "material" not in primitive:
            primitive["material"] = _plain_material(text)
    write_gltf(temporary, text, buffer, mesh.image)


def _plain_material(text: dict[str, Any]) -> int:
    """Readers drop texture coordinates that no material goes with."""
    materials = text.setdefault("materials", [])
    for i, material in enumerate(materials):
        if material.get("name") == PLAIN:
            return i
    materials.append(as_gltf(Material(), PLAIN))
    return len(materials) - 1


def _carry_over(gltf: Gltf, text: dict[str, Any], buffer: Buffer) -> None:
    """Move what the description still uses of the old buffers, and all images, to the new one."""
    views, accessors = dict[int, int](), dict[int, int]()

    def move(holder: dict[str, Any]) -> None:
        number = holder["bufferView"]
        if number not in views:
            given = text["bufferViews"][number]
            more = {key: given[key] for key in ("byteStride", "target", "name") if key in given}
            views[number] = buffer.put(gltf.view(number), **more)
        holder["bufferView"] = views[number]

    def moved(number: int) -> int:
        if number not in accessors:
            accessor = text["accessors"][number]
            sparse = [accessor["sparse"][key] for key in ("indices", "values") if "sparse" in accessor]
            for holder in (*([accessor] if "bufferView" in accessor else []), *sparse):
                move(holder)
            accessors[number] = len(buffer.accessors)
            buffer.accessors.append(accessor)
        return accessors[number]

    for image in text.get("images", ()):
        if "bufferView" in image:
            move(image)
        else:
            _embed(image, gltf.folder, buffer)
    _visit(text, moved)


def _embed(image: dict[str, Any], folder: Path, buffer: Buffer) -> None:
    """An image in a file of its own goes into the new file."""
    uri = str(image.get("uri", "data:"))
    file = folder / unquote(uri)
    kind = mimetypes.guess_type(uri)[0]
    if not uri.startswith("data:") and kind in ("image/png", "image/jpeg") and file.is_file():
        del image["uri"]
        image |= {"bufferView": buffer.put(file.read_bytes()), "mimeType": kind}


def _visit(text: Any, change: Callable[[int], int], inside: bool = False) -> None:
    """Apply `change` to each number of an accessor in the description."""
    if isinstance(text, dict):
        for key, value in text.items():
            if isinstance(value, int) and not isinstance(value, bool):
                if key in REFERENCES or inside:
                    text[key] = change(value)
            elif key not in ("extras", "accessors", "bufferViews"):
                _visit(value, change, key in ("attributes", "targets"))
    elif isinstance(text, list):
        for value in text:
            _visit(value, change, inside)
