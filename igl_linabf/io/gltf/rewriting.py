"""Write glTF and GLB: a new file, or the file that was read with new texture coordinates."""

import copy
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import numpy as np

from ..._types import IntArray
from ...errors import MeshWarning, stack_level
from ..materials import (
    DEFAULT_MATERIAL,
    MOVE_HINT,
    REPLACED_HINT,
    Material,
    make_gltf_material,
    warn_of_stale_images,
)
from ..mesh_file import MeshFile
from ..references import Folder
from ..vertex_splits import find_face_pages, find_unique_tuples, to_single_precision
from .container import find_referenced_file, is_relative, iterate_uris
from .extensions import (
    VIEW_KEYS,
    drop_unknown_extensions,
    find_features_by_vertex_number,
    has_unknown_references,
    iterate_instance_attributes,
    iterate_table_properties,
    renumber_accessors,
)
from .images import count_stale_textures, drop_stale_images, iterate_texture_uses
from .ngons import EXTENSION
from .reading import SECOND_TEXTURE, TEXTURE, GltfFile, Primitive
from .scene import Gltf, Mode, Target
from .textures import MaterialPages, add_images
from .writing import Buffer, order_triangles, save_new_gltf, write_gltf

TANGENT, FEATURE_ID = "TANGENT", "_FEATURE_ID_{}"
TEXTURE_ATTRIBUTES = (TEXTURE, SECOND_TEXTURE)
MIME_TYPES = {
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
    ".webp": "image/webp",
    ".avif": "image/avif",
    ".ktx2": "image/ktx2",
    ".dds": "image/vnd-ms.dds",
}


def save_gltf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write GLB or glTF: a new file, or the file that was read with new texture coordinates."""
    if isinstance(mesh.extras.source, GltfFile):
        _rewrite_gltf(temporary, mesh, mesh.extras.source, path)
    else:
        save_new_gltf(temporary, mesh)


def _rewrite_gltf(temporary: str, mesh: MeshFile, source: GltfFile, path: Path) -> None:
    """Write the file that was read, with a copy of each vertex for each of its texture coordinates."""
    bare, mesh = mesh.lacks_texture, mesh.fill_missing_texture()
    assert mesh.TC is not None and mesh.texture is not None
    gltf, text, buffer = source.gltf, copy.deepcopy(source.gltf.text), Buffer()
    primitives = [text["meshes"][place.mesh]["primitives"][place.number] for place in source.primitives]
    second = int(mesh.first is not None)
    if mesh.images is None or not mesh.images.moved:
        warn_of_stale_images(
            count_stale_textures(text, second),
            REPLACED_HINT if mesh.images else "bake them again" if second else MOVE_HINT,
        )
    if mesh.images is not None and not has_unknown_references(text):
        drop_stale_images(text)
    if gltf.compression:
        warnings.warn(
            f"the file was compressed by {' and '.join(gltf.compression)}, and is written uncompressed: "
            "compress it again, for example by `gltf-transform`",
            MeshWarning,
            stacklevel=stack_level(),
        )
    drop_unknown_extensions(text, [*(text["meshes"][place.mesh] for place in source.primitives), *primitives])
    old = [(entry.pop("attributes"), entry.pop("targets", [])) for entry in primitives]
    _drop_tangents(text, primitives, old, second)
    for entry in primitives:
        entry.pop("indices", None)
    _copy_buffers(gltf, text, buffer)
    _embed_images(text, gltf.folder, path.parent, buffer)
    map_ = mesh.TC * [1, -1] + [0, 1]
    rounded = to_single_precision(map_, "TC")
    pages = MaterialPages(text)
    for place, primitive, (attributes, targets), page in _split_by_page(
        mesh, text, source.primitives, primitives, old
    ):
        (rows_used, texture), vertex = find_unique_tuples(place.vertex, mesh.texture[place.corners])

        def copy_rows(numbers: dict[str, int], rows: IntArray = rows_used) -> dict[str, int]:
            return {
                key: buffer.append_array(gltf.read_array(number, rows), like=gltf.text["accessors"][number])
                for key, number in numbers.items()
            }

        primitive |= {"mode": Mode.TRIANGLES, "attributes": copy_rows(attributes)}
        if not bare[place.faces].all():
            primitive["attributes"][TEXTURE_ATTRIBUTES[second]] = buffer.append_array(rounded[texture])
        _store_feature_ids(primitive, rows_used, buffer)
        if targets:
            primitive["targets"] = [copy_rows(target) for target in targets]
        triangles, extensions = order_triangles(mesh, place.faces, vertex, place.mirrored)
        primitive["indices"] = buffer.append_array(triangles.ravel(), Target.INDICES)
        if extensions:
            primitive.setdefault("extensions", {}).update(extensions["extensions"])
            if EXTENSION not in text.setdefault("extensionsUsed", []):
                text["extensionsUsed"].append(EXTENSION)
        if "material" not in primitive:
            primitive["material"] = _add_default_material(text)
        pages.assign(primitive, page)
    if mesh.images is not None:
        add_images(text, buffer.append_bytes, mesh.images, pages.pages)
    write_gltf(temporary, text, buffer)


def _split_by_page(
    mesh: MeshFile,
    text: dict[str, Any],
    places: list[Primitive],
    primitives: list[dict[str, Any]],
    old: list[Any],
) -> Iterator[tuple[Primitive, dict[str, Any], Any, int]]:
    """Yield primitives, split by page, each with its description, its old attributes and its page."""
    has_pages = mesh.images is not None and mesh.images.pages > 1
    page_of_face = find_face_pages(mesh) if has_pages else np.zeros(len(mesh.polygons), dtype=np.int64)
    for place, primitive, attributes in zip(places, primitives, old, strict=True):
        blank = copy.deepcopy(primitive)
        for i, page in enumerate(np.unique(page_of_face[place.faces]).tolist()):
            faces = place.faces[page_of_face[place.faces] == page]
            is_kept = np.isin(mesh.polygons.polygon_of_corner[place.corners], faces)
            part = place._replace(faces=faces, corners=place.corners[is_kept], vertex=place.vertex[is_kept])
            if i:
                primitive = copy.deepcopy(blank)
                text["meshes"][place.mesh]["primitives"].append(primitive)
            yield part, primitive, attributes, page


def _drop_tangents(
    text: dict[str, Any], primitives: list[dict[str, Any]], old: list[Any], second: int
) -> None:
    """Remove the old texture coordinates, and the tangents derived from them, from attributes and targets.

    Tangents are kept if the normal map uses texture coordinates that have not changed.
    """
    replaced = (TANGENT, TEXTURE_ATTRIBUTES[second])
    count = 0
    for primitive, (attributes, targets) in zip(primitives, old, strict=True):
        material = text["materials"][primitive["material"]] if "material" in primitive else {}
        normal = [use for use in iterate_texture_uses(material) if use.key == "normalTexture"]
        is_kept = (
            any(use.coordinates for use in normal)
            if not second
            else not any(use.coordinates == second for use in normal)
        )
        count += TANGENT in attributes and not is_kept
        for attribute_set in (attributes, *targets):
            for name in replaced:
                if name != TANGENT or not is_kept:
                    attribute_set.pop(name, None)
    if count:
        warnings.warn(
            f"the tangents ({TANGENT}) of {count} of its primitives were made for the old texture "
            "coordinates: they are left out, and readers compute new tangents, as glTF specifies",
            MeshWarning,
            stacklevel=stack_level(),
        )


def _store_feature_ids(primitive: dict[str, Any], vertex_index: IntArray, buffer: Buffer) -> None:
    """Store feature IDs that were implied by the old vertex numbers as an attribute."""
    attributes = primitive["attributes"]
    for feature in find_features_by_vertex_number(primitive):
        feature["attribute"] = next(
            k for k in range(len(attributes) + 1) if FEATURE_ID.format(k) not in attributes
        )
        attributes[FEATURE_ID.format(feature["attribute"])] = buffer.append_array(
            vertex_index.astype(np.float32)
        )


def _add_default_material(text: dict[str, Any]) -> int:
    """Return the number of the default material, which readers need in order to keep texture coordinates."""
    materials = text.setdefault("materials", [])
    for i, material in enumerate(materials):
        if material.get("name") == DEFAULT_MATERIAL:
            return i
    materials.append(make_gltf_material(Material(), DEFAULT_MATERIAL))
    return len(materials) - 1


def _copy_buffers(gltf: Gltf, text: dict[str, Any], buffer: Buffer) -> None:
    """Copy the buffer data that the description still uses to the new buffer.

    If an unknown extension may refer to views or accessors, all of them are copied and keep their numbers.
    """
    views, accessors = dict[int, int](), dict[int, int]()

    def copy_view(number: int) -> int:
        if number not in views:
            entry = text["bufferViews"][number]
            kept = ("byteStride", "target", "name", "extras", "extensions")
            properties = {key: entry[key] for key in kept if key in entry}
            views[number] = buffer.append_bytes(gltf.read_view(number), **properties)
        return views[number]

    def copy_accessor(number: int) -> int:
        if number not in accessors:
            accessor = text["accessors"][number]
            sparse = [accessor["sparse"][key] for key in ("indices", "values") if "sparse" in accessor]
            for holder in (*([accessor] if "bufferView" in accessor else []), *sparse):
                holder["bufferView"] = copy_view(holder["bufferView"])
            accessors[number] = len(buffer.accessors)
            buffer.accessors.append(accessor)
        return accessors[number]

    if has_unknown_references(text):
        for number in range(len(text.get("bufferViews", ()))):
            copy_view(number)
        for number in range(len(text.get("accessors", ()))):
            copy_accessor(number)
    for image in text.get("images", ()):
        if "bufferView" in image:
            image["bufferView"] = copy_view(image["bufferView"])
    for table_property in iterate_table_properties(text):
        table_property |= {key: copy_view(table_property[key]) for key in VIEW_KEYS if key in table_property}
    for attributes in iterate_instance_attributes(text):
        attributes |= {key: copy_accessor(number) for key, number in attributes.items()}
    renumber_accessors(text, copy_accessor)


def _embed_images(text: dict[str, Any], old: Folder, new: Path, buffer: Buffer) -> None:
    """Embed image files in the new file, and make all other references relative to its folder."""
    views = dict[Path, int]()  # many images may name one file
    for image in text.get("images", ()):
        file, kind = (
            find_referenced_file(image.get("uri"), old),
            MIME_TYPES.get(Path(str(image.get("uri"))).suffix.lower()),
        )
        if file is not None and kind is not None and not old.find_tiles(unquote(image["uri"])):
            del image["uri"]
            file = file.resolve()
            if file not in views:
                views[file] = buffer.append_bytes(file.read_bytes())
            image |= {"bufferView": views[file], "mimeType": kind}
    for holder, key in iterate_uris(text):
        if is_relative(holder[key]) and old.contains(unquote(holder[key])):
            holder[key] = quote(old.relocate_reference(unquote(holder[key]), new))
