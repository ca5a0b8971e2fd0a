"""Write glTF and GLB: a new file, or the one that was read with texture coordinates."""

import copy
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote, urlsplit

import numpy as np

from ..._types import IntArray
from ...errors import MeshWarning, stack_level
from ..materials import BAKED, MOVE, PLAIN, Material, as_gltf, warn_of_images
from ..mesh_file import MeshFile
from ..references import named_file, renamed
from ..vertex_splits import pages_of_faces, single_precision, unique_tuples
from .extensions import (
    COMPRESSED,
    VIEWS,
    implied_features,
    instances,
    leave_out_of_vertices,
    names_numbers,
    properties,
)
from .images import leave_out_old_images, old_images, texture_uses
from .ngons import EXTENSION
from .reading import TEXTURE, GltfFile, Primitive
from .scene import Gltf, Mode, Target
from .textures import MaterialPages, with_images
from .writing import Buffer, save_new_gltf, triangles_of, write_gltf

TANGENTS, FEATURE = "TANGENT", "_FEATURE_ID_{}"
TEXTURES = (TEXTURE, "TEXCOORD_1")
# keys of accessors; and all in "attributes"
REFERENCES = {"indices", "input", "output", "inverseBindMatrices"}
IMAGES = {
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
    ".webp": "image/webp",
    ".avif": "image/avif",
    ".ktx2": "image/ktx2",
    ".dds": "image/vnd-ms.dds",
}


def save_gltf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write GLB or glTF: a new file, or the one that was read with texture coordinates."""
    if isinstance(mesh.extras.source, GltfFile):
        _rewrite_gltf(temporary, mesh, mesh.extras.source, path)
    else:
        save_new_gltf(temporary, mesh)


def _rewrite_gltf(temporary: str, mesh: MeshFile, source: GltfFile, path: Path) -> None:
    """The file that was read, each primitive's vertices once for each of their texture coordinates."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    gltf, text, buffer = source.gltf, copy.deepcopy(source.gltf.text), Buffer()
    primitives = [text["meshes"][of.mesh]["primitives"][of.number] for of in source.primitives]
    second = int(mesh.first is not None)
    if mesh.images is None or not mesh.images.moved:
        warn_of_images(
            old_images(text, second), BAKED if mesh.images else "bake them anew" if second else MOVE
        )
    if mesh.images is not None and not names_numbers(text):
        leave_out_old_images(text)
    leave_out_of_vertices(text, [*(text["meshes"][of.mesh] for of in source.primitives), *primitives])
    old = [(its.pop("attributes"), its.pop("targets", [])) for its in primitives]
    _leave_out_tangents(text, primitives, old, second)
    for its in primitives:
        its.pop("indices", None)
    _carry_over(gltf, text, buffer)
    _embed_images(text, gltf.folder, path.parent, buffer)
    map_ = mesh.TC * [1, -1] + [0, 1]
    pages = MaterialPages(text)
    for of, primitive, (attributes, targets), page in _parts(mesh, text, source.primitives, primitives, old):
        (own, texture), vertex = unique_tuples(of.vertex, mesh.texture[of.corners])

        def taken(numbers: dict[str, int], rows: IntArray = own) -> dict[str, int]:
            return {
                key: buffer.add(gltf.array(number)[rows], like=gltf.text["accessors"][number])
                for key, number in numbers.items()
            }

        st = buffer.add(single_precision(map_[texture], "TC"))
        primitive |= {"mode": Mode.TRIANGLES, "attributes": {**taken(attributes), TEXTURES[second]: st}}
        _name_features(primitive, own, buffer)
        if targets:
            primitive["targets"] = [taken(target) for target in targets]
        triangles, extensions = triangles_of(mesh, of.faces, of.corners, vertex, of.mirrored)
        primitive["indices"] = buffer.add(triangles.ravel(), Target.INDICES)
        if extensions:
            primitive.setdefault("extensions", {}).update(extensions["extensions"])
            if EXTENSION not in text.setdefault("extensionsUsed", []):
                text["extensionsUsed"].append(EXTENSION)
        if "material" not in primitive:
            primitive["material"] = _plain_material(text)
        pages.assign(primitive, page)
    if mesh.images is not None:
        with_images(text, buffer.put, mesh.images, pages.pages)
    write_gltf(temporary, text, buffer)


def _parts(
    mesh: MeshFile,
    text: dict[str, Any],
    of: list[Primitive],
    primitives: list[dict[str, Any]],
    old: list[Any],
) -> Iterator[tuple[Primitive, dict[str, Any], Any, int]]:
    """The primitives, their descriptions and old attributes, and their pages: one for each page of images."""
    several = mesh.images is not None and mesh.images.pages > 1
    page_of_face = pages_of_faces(mesh) if several else np.zeros(len(mesh.polygons), dtype=np.int64)
    for place, primitive, attributes in zip(of, primitives, old, strict=True):
        blank = copy.deepcopy(primitive)
        for i, page in enumerate(np.unique(page_of_face[place.faces]).tolist()):
            faces = place.faces[page_of_face[place.faces] == page]
            mine = np.isin(mesh.polygons.owner[place.corners], faces)
            part = place._replace(faces=faces, corners=place.corners[mine], vertex=place.vertex[mine])
            if i:
                primitive = copy.deepcopy(blank)
                text["meshes"][place.mesh]["primitives"].append(primitive)
            yield part, primitive, attributes, page


def _leave_out_tangents(
    text: dict[str, Any], primitives: list[dict[str, Any]], old: list[Any], second: int
) -> None:
    """Leave out, of attributes and targets, what was made of the old map; glTF has tangents made of a map.

    Tangents stay where their image goes with other texture coordinates.
    """
    made_of_the_map = (TANGENTS, TEXTURES[second])
    count = 0
    for primitive, (attributes, targets) in zip(primitives, old, strict=True):
        material = text["materials"][primitive["material"]] if "material" in primitive else {}
        normal = [use for use in texture_uses(material) if use.key == "normalTexture"]
        stay = (
            any(use.coordinates for use in normal)
            if not second
            else not any(use.coordinates == second for use in normal)
        )
        count += TANGENTS in attributes and not stay
        for held in (attributes, *targets):
            for name in made_of_the_map:
                if name != TANGENTS or not stay:
                    held.pop(name, None)
    if count:
        warnings.warn(
            f"the tangents ({TANGENTS}) of {count} of its primitives were made for the old texture "
            "coordinates: they are left out, and readers make new ones, as glTF asks them to",
            MeshWarning,
            stacklevel=stack_level(),
        )


def _name_features(primitive: dict[str, Any], own: IntArray, buffer: Buffer) -> None:
    """Write what the old numbers of vertices told, as an attribute: they have others now."""
    attributes = primitive["attributes"]
    for of in implied_features(primitive):
        of["attribute"] = next(k for k in range(len(attributes) + 1) if FEATURE.format(k) not in attributes)
        attributes[FEATURE.format(of["attribute"])] = buffer.add(own.astype(np.float32))


def _plain_material(text: dict[str, Any]) -> int:
    """Readers drop texture coordinates that no material goes with."""
    materials = text.setdefault("materials", [])
    for i, material in enumerate(materials):
        if material.get("name") == PLAIN:
            return i
    materials.append(as_gltf(Material(), PLAIN))
    return len(materials) - 1


def _carry_over(gltf: Gltf, text: dict[str, Any], buffer: Buffer) -> None:
    """Move what the description still uses of the old buffers to the new one.

    All of it, and under its old numbers, if an extension may name some that nobody knows of.
    """
    views, accessors = dict[int, int](), dict[int, int]()

    def view(number: int) -> int:
        if number not in views:
            given = text["bufferViews"][number]
            more = {key: given[key] for key in ("byteStride", "target", "name", "extras") if key in given}
            kept = {key: of for key, of in given.get("extensions", {}).items() if key not in COMPRESSED}
            views[number] = buffer.put(gltf.view(number), **more, **({"extensions": kept} if kept else {}))
        return views[number]

    def moved(number: int) -> int:
        if number not in accessors:
            accessor = text["accessors"][number]
            sparse = [accessor["sparse"][key] for key in ("indices", "values") if "sparse" in accessor]
            for holder in (*([accessor] if "bufferView" in accessor else []), *sparse):
                holder["bufferView"] = view(holder["bufferView"])
            accessors[number] = len(buffer.accessors)
            buffer.accessors.append(accessor)
        return accessors[number]

    if names_numbers(text):
        for number in range(len(text.get("bufferViews", ()))):
            view(number)
        for number in range(len(text.get("accessors", ()))):
            moved(number)
    for image in text.get("images", ()):
        if "bufferView" in image:
            image["bufferView"] = view(image["bufferView"])
    for of in properties(text):
        of |= {key: view(of[key]) for key in VIEWS if key in of}
    for attributes in instances(text):
        attributes |= {key: moved(number) for key, number in attributes.items()}
    _visit(text, moved)


def _embed_images(text: dict[str, Any], old: Path, new: Path, buffer: Buffer) -> None:
    """Images in files of their own go into the new file; other names lead from its folder."""
    for image in text.get("images", ()):
        file, kind = _file_of(image.get("uri"), old), IMAGES.get(Path(str(image.get("uri"))).suffix.lower())
        if file is not None and kind is not None:
            del image["uri"]
            image |= {"bufferView": buffer.put(file.read_bytes()), "mimeType": kind}
    for holder, key in _names_of_files(text):
        if _file_of(holder[key], old) is not None:
            holder[key] = quote(renamed(unquote(holder[key]), old, new))


def _file_of(uri: Any, folder: Path) -> Path | None:
    """The file that a relative name leads to; None if it is no such name, or leads nowhere."""
    if not isinstance(uri, str) or urlsplit(uri).scheme:
        return None
    return named_file(unquote(uri), folder)


def _names_of_files(value: Any) -> Iterator[tuple[dict[str, Any], str]]:
    """Where a description names files: "uri", "schemaUri", ..."""
    if isinstance(value, list):
        for inner in value:
            yield from _names_of_files(inner)
    elif isinstance(value, dict):
        for key, inner in value.items():
            if key.lower().endswith("uri"):
                yield value, key
            elif key not in ("extras", "buffers"):
                yield from _names_of_files(inner)


def _visit(text: Any, change: Callable[[int], int], inside: bool = False) -> None:
    """Apply `change` to each number of an accessor in the description, extensions aside."""
    if isinstance(text, dict):
        for key, value in text.items():
            if isinstance(value, int) and not isinstance(value, bool):
                if key in REFERENCES or inside:
                    text[key] = change(value)
            elif key not in ("extras", "extensions", "accessors", "bufferViews"):
                _visit(value, change, key in ("attributes", "targets"))
    elif isinstance(text, list):
        for value in text:
            _visit(value, change, inside)
