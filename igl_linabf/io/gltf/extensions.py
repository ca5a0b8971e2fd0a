"""Determine which glTF extensions remain valid in a file with renumbered vertices, accessors and views."""

import warnings
from collections.abc import Callable, Iterator
from fnmatch import fnmatchcase
from typing import Any

from ...errors import MeshWarning, stack_level
from ..parsing import Damaged

DRACO = "KHR_draco_mesh_compression"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
VARIANTS = "KHR_materials_variants"
FEATURES, METADATA, INSTANCES = "EXT_mesh_features", "EXT_structural_metadata", "EXT_mesh_gpu_instancing"
VIEW_KEYS = ("values", "arrayOffsets", "stringOffsets")  # references to buffer views in METADATA
# Keys whose values are accessor numbers; all values in "attributes" are accessor numbers, too.
ACCESSOR_KEYS = {"indices", "input", "output", "inverseBindMatrices"}
# Extensions that remain valid in a new file, because their references to vertices, accessors and buffer views
# are renumbered.
KNOWN_EXTENSIONS = (
    *(FEATURES, METADATA, INSTANCES, "EXT_instance_features", "FB_ngon_encoding"),
    *("KHR_materials_*", "EXT_materials_*", "KHR_texture_*", "EXT_texture_*", "MSFT_texture_dds"),
    *("KHR_lights_*", "EXT_lights_*", "KHR_xmp*", "KHR_node_*", "KHR_animation_pointer"),
    *(DRACO, *MESHOPT),
    *("KHR_mesh_quantization", "MSFT_lod", "VRM", "VRMC_*"),
)


def is_known_extension(name: str) -> bool:
    """Return True if an extension remains valid in a file with other vertices."""
    return any(fnmatchcase(name, pattern) for pattern in KNOWN_EXTENSIONS)


def reject_required_extensions(text: dict[str, Any]) -> None:
    """Raise `Damaged` if the file requires an unknown extension."""
    for name in text.get("extensionsRequired", ()):
        if not is_known_extension(str(name)):
            raise Damaged(
                f"it requires the extension {name}, which is not supported, and cannot be read correctly "
                "without it: export the file without the extension"
            )


def iterate_extended(value: Any) -> Iterator[dict[str, Any]]:
    """Yield all JSON objects in a glTF description that have extensions."""
    return (entry for entry in iterate_objects(value) if isinstance(entry.get("extensions"), dict))


def iterate_objects(value: Any) -> Iterator[dict[str, Any]]:
    """Yield all JSON objects in a glTF description, except for objects within "extras"."""
    if isinstance(value, dict):
        yield value
        for key, inner in value.items():
            if key != "extras":
                yield from iterate_objects(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from iterate_objects(inner)


def has_unknown_references(text: dict[str, Any]) -> bool:
    """Return True if an unknown extension, which may refer to accessors or views by number, is present."""
    return any(
        not is_known_extension(name) for holder in iterate_extended(text) for name in holder["extensions"]
    )


def drop_unknown_extensions(text: dict[str, Any], changed: list[dict[str, Any]]) -> None:
    """Remove unknown extensions of meshes and primitives, because they may refer to vertex numbers."""
    dropped = set[str]()
    for holder in changed:
        extensions = holder.get("extensions", {})
        dropped |= {name for name in extensions if not is_known_extension(name)}
        kept = {name: value for name, value in extensions.items() if is_known_extension(name)}
        holder.pop("extensions", None)
        if kept:
            holder["extensions"] = kept
    if not dropped:
        return
    remaining = {name for holder in iterate_extended(text) for name in holder["extensions"]}
    for key in ("extensionsUsed", "extensionsRequired"):
        if key in text:
            text[key] = [name for name in text[key] if name not in dropped or name in remaining]
            if not text[key]:
                del text[key]
    warnings.warn(
        f"the extensions {', '.join(sorted(dropped))} of meshes may refer to vertex numbers, which have "
        "changed: they are left out; write OBJ or PLY if you do not need them, or apply them again",
        MeshWarning,
        stacklevel=stack_level(),
    )


def iterate_table_properties(text: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the properties of METADATA tables, which refer to buffer views."""
    for table in text.get("extensions", {}).get(METADATA, {}).get("propertyTables", ()):
        yield from table.get("properties", {}).values()


def iterate_instance_attributes(text: dict[str, Any]) -> Iterator[dict[str, int]]:
    """Yield the instance attributes of each node with the extension INSTANCES: accessor numbers by name."""
    for node in text.get("nodes", ()):
        if INSTANCES in node.get("extensions", {}):
            yield node["extensions"][INSTANCES].get("attributes", {})


def find_features_by_vertex_number(primitive: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the entries of the extension FEATURES that use the vertex numbers of a primitive as IDs."""
    features = primitive.get("extensions", {}).get(FEATURES, {}).get("featureIds", ())
    return [feature for feature in features if not {"attribute", "texture"} & set(feature)]


def renumber_accessors(text: Any, change: Callable[[int], int], inside: bool = False) -> None:
    """Apply `change` to each accessor index in the JSON description, except inside extensions."""
    if isinstance(text, dict):
        for key, value in text.items():
            if isinstance(value, int) and not isinstance(value, bool):
                if key in ACCESSOR_KEYS or inside:
                    text[key] = change(value)
            elif key not in ("extras", "extensions", "accessors", "bufferViews"):
                renumber_accessors(value, change, key in ("attributes", "targets"))
    elif isinstance(text, list):
        for value in text:
            renumber_accessors(value, change, inside)
