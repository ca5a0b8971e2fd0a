"""Check that a glTF description follows the parts of the glTF 2.0 specification that this package uses."""

from typing import Any

import numpy as np

from ...errors import first_few
from ..limits import check_expansion
from ..parsing import Damaged
from .extensions import (
    DRACO,
    FEATURES,
    INSTANCES,
    MESHOPT,
    METADATA,
    VARIANTS,
    VIEW_KEYS,
    iterate_instance_attributes,
    iterate_objects,
    renumber_accessors,
)
from .images import TEXTURE_TRANSFORM, find_texture_uses
from .scene import DTYPES, INSTANCE_ATTRIBUTES, UNSIGNED, WIDTHS, Gltf
from .schema import (
    Index,
    Integer,
    ListOf,
    Number,
    ObjectOf,
    OfType,
    OneOf,
    Record,
    Schema,
    check_depth,
    check_values,
)

CORNER_BYTES = 64  # estimated bytes of memory per corner of a face
INSTANCE_BYTES = 512  # estimated bytes of memory for the transform of an instance

TEXT, FLAG = OfType(str), OfType(bool)
NAME: dict[str, Schema] = {"name": TEXT}
STRIDE = Integer(4, 252)
ACCESSORS = ObjectOf(Index("accessors"))
PLACED: dict[str, Schema] = {"bufferView": Index("bufferViews")}
OFFSET: dict[str, Schema] = {"byteOffset": Integer()}
FACTORS: dict[str, Schema] = {
    "baseColorFactor": ListOf(Number(), 4),
    "metallicFactor": Number(),
    "roughnessFactor": Number(),
}
ACCESSOR = Record(
    {
        **NAME,
        **PLACED,
        **OFFSET,
        "normalized": FLAG,
        "sparse": Record(
            required={
                "count": Integer(0, 2**32),
                "indices": Record(OFFSET, {**PLACED, "componentType": OneOf(UNSIGNED)}),
                "values": Record(OFFSET, PLACED),
            }
        ),
    },
    {"componentType": OneOf(tuple(map(int, DTYPES))), "count": Integer(0, 2**32), "type": OneOf(WIDTHS)},
)
PRIMITIVE = Record(
    {
        "indices": Index("accessors"),
        "material": Index("materials"),
        "mode": Integer(0, 6),
        "targets": ListOf(ACCESSORS),
    },
    {"attributes": ACCESSORS},
)
NODE = Record(
    {
        **NAME,
        "children": ListOf(Index("nodes")),
        "mesh": Index("meshes"),
        "matrix": ListOf(Number(), 16),
        "translation": ListOf(Number(), 3),
        "rotation": ListOf(Number(), 4),
        "scale": ListOf(Number(), 3),
    }
)
COMPRESSED_VIEW = Record(
    {**OFFSET, "filter": OneOf(("NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"))},
    {
        "buffer": Index("buffers"),
        "byteLength": Integer(),
        "byteStride": Integer(1, 256),
        "count": Integer(0, 2**32),
        "mode": OneOf(("ATTRIBUTES", "TRIANGLES", "INDICES")),
    },
)
DESCRIPTION = Record(
    {
        "scene": Index("scenes"),
        "scenes": ListOf(Record({"nodes": ListOf(Index("nodes"))})),
        "nodes": ListOf(NODE),
        "meshes": ListOf(Record(NAME, {"primitives": ListOf(PRIMITIVE)})),
        "accessors": ListOf(ACCESSOR),
        "bufferViews": ListOf(
            Record(
                {
                    **OFFSET,
                    "byteStride": STRIDE,
                    "extensions": Record(dict.fromkeys(MESHOPT, COMPRESSED_VIEW)),
                },
                {"buffer": Index("buffers"), "byteLength": Integer()},
            )
        ),
        "buffers": ListOf(Record({"uri": TEXT})),
        "materials": ListOf(
            Record(
                {
                    **NAME,
                    "pbrMetallicRoughness": Record(FACTORS),
                    "emissiveFactor": ListOf(Number(), 3),
                    "alphaMode": TEXT,
                }
            )
        ),
        "textures": ListOf(
            Record(
                {
                    "sampler": Index("samplers"),
                    "source": Index("images"),
                    "extensions": ObjectOf(Record({"source": Index("images")})),
                }
            )
        ),
        "images": ListOf(Record({"uri": TEXT, "bufferView": Index("bufferViews")})),
        "samplers": ListOf(Record({"wrapS": Integer(), "wrapT": Integer()})),
        "animations": ListOf(
            Record({"samplers": ListOf(Record({"input": Index("accessors"), "output": Index("accessors")}))})
        ),
        "skins": ListOf(Record({"inverseBindMatrices": Index("accessors")})),
        "cameras": ListOf(Record()),
        "extensionsUsed": ListOf(TEXT),
        "extensionsRequired": ListOf(TEXT),
    },
    {"asset": Record({"copyright": TEXT}, {"version": TEXT})},
)
TABLE = Record({"properties": ObjectOf(Record({key: Index("bufferViews") for key in VIEW_KEYS}))})
EXTENSIONS: dict[str, Schema] = {
    DRACO: Record(required={"bufferView": Index("bufferViews"), "attributes": ObjectOf(Integer())}),
    TEXTURE_TRANSFORM: Record(
        {
            "offset": ListOf(Number(), 2),
            "scale": ListOf(Number(), 2),
            "rotation": Number(),
            "texCoord": Integer(),
        }
    ),
    FEATURES: Record({"featureIds": ListOf(Record())}),
    METADATA: Record({"propertyTables": ListOf(TABLE)}),
    INSTANCES: Record({"attributes": ACCESSORS}),
    VARIANTS: Record({"mappings": ListOf(Record({"material": Index("materials")}))}),
}
# types that glTF allows for the vertex attributes that are read
ATTRIBUTE_TYPES = {
    "POSITION": ("VEC3",),
    "NORMAL": ("VEC3",),
    "TEXCOORD_0": ("VEC2",),
    "TEXCOORD_1": ("VEC2",),
    "COLOR_0": ("VEC3", "VEC4"),
}


def check_description(text: dict[str, Any]) -> None:
    """Raise `Damaged` if a description does not follow glTF 2.0, or refers to a missing entry."""
    check_depth(text)
    check_values(text)
    counts = {name: len(entries) for name, entries in text.items() if isinstance(entries, list)}
    DESCRIPTION.check(text, "", counts)
    extensions = Record(EXTENSIONS)
    for holder in iterate_objects(text):
        if "extensions" in holder:
            ObjectOf(Record()).check(holder["extensions"], "extensions", counts)
            extensions.check(holder["extensions"], "extensions", counts)
    for use in find_texture_uses(text):
        Index("textures").check(use.holder[use.key]["index"], f"{use.key}.index", counts)

    def check_accessor(number: int) -> int:
        Index("accessors").check(number, "reference to an accessor", counts)
        return number

    renumber_accessors(text, check_accessor)
    _reject_cycles(text.get("nodes", []))


def _reject_cycles(nodes: list[dict[str, Any]]) -> None:
    """Raise `Damaged` if a node is its own ancestor."""
    parents = np.zeros(len(nodes), dtype=np.int64)
    for node in nodes:
        for child in node.get("children", ()):
            parents[child] += 1
    waiting, done = np.flatnonzero(parents == 0).tolist(), 0
    while waiting:
        done += 1
        for child in nodes[waiting.pop()].get("children", ()):
            parents[child] -= 1
            if not parents[child]:
                waiting.append(child)
    if done < len(nodes):
        raise Damaged(f"its nodes {first_few(np.flatnonzero(parents))} are their own descendants")


def check_data(gltf: Gltf) -> None:
    """Raise `Damaged` if data of accessors are missing, or need memory out of proportion to the file."""
    accessors = gltf.get_entries("accessors")
    views = gltf.get_entries("bufferViews")
    for number in range(len(views)):
        gltf.check_view(number)
    viewed = sum(view["byteLength"] for view in views)
    check_expansion(viewed, gltf.total_bytes, "its buffer views, which share data,")
    unstored = 0
    for number, accessor in enumerate(accessors):
        gltf.check_rows(number)
        if "bufferView" not in accessor or "sparse" in accessor:
            unstored += accessor["count"] * gltf.row_bytes(number)
    check_expansion(unstored, gltf.total_bytes, "its accessors without data")
    used = 0
    for i, j, primitive in gltf.iterate_primitives():
        used += _check_primitive(gltf, primitive, f"meshes[{i}].primitives[{j}]")
    check_expansion(used, gltf.total_bytes, "its primitives, which share data,")
    instanced = list(iterate_instance_attributes(gltf.text))
    for attributes in instanced:
        for name, kind in INSTANCE_ATTRIBUTES.items():
            if name in attributes and accessors[attributes[name]]["type"] != kind:
                raise Damaged(f"its instance attribute {name} is not {kind}")
    instances = sum(
        max((accessors[number]["count"] for number in attributes.values()), default=0)
        for attributes in instanced
    )
    check_expansion(INSTANCE_BYTES * instances, gltf.total_bytes, "its instances")


def _check_primitive(gltf: Gltf, primitive: dict[str, Any], place: str) -> int:
    """Check the accessors of a primitive, and return the number of bytes of memory that it needs."""
    accessors, attributes = gltf.get_entries("accessors"), primitive["attributes"]
    for name, types in ATTRIBUTE_TYPES.items():
        if name in attributes and accessors[attributes[name]]["type"] not in types:
            raise Damaged(f"its {place}.attributes.{name} is not {' or '.join(types)}")
    n = int(accessors[attributes["POSITION"]]["count"])
    targets = primitive.get("targets", [])
    for holder in (attributes, *targets):
        for name, number in holder.items():
            if accessors[number]["count"] != n:
                raise Damaged(
                    f"its {place} has {n} positions, but {accessors[number]['count']} rows of {name}"
                )
    corners = n
    if "indices" in primitive:
        indices = accessors[primitive["indices"]]
        if indices["type"] != "SCALAR" or indices["componentType"] not in UNSIGNED:
            raise Damaged(f"its {place}.indices are not unsigned integers")
        corners = int(indices["count"])
    row_size = sum(gltf.row_bytes(number) for holder in (attributes, *targets) for number in holder.values())
    return CORNER_BYTES * corners + min(n, corners) * row_size
