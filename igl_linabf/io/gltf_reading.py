"""Read glTF and GLB, and write what was read again with texture coordinates."""

import copy
import mimetypes
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np

from .._types import FloatArray, IntArray
from ..surface import Polygons
from .gltf import INDICES, VERTEX_ATTRIBUTES, Buffer, save_new_gltf, triangles_of, write_gltf
from .gltf_scene import Gltf, load_gltf, placements
from .materials import PLAIN, Material, as_gltf, of_gltf, srgb, warn_of_images
from .mesh_file import MeshFile
from .ngons import EXTENSION, polygons_among
from .one_index import one_index, single
from .parsing import Damaged, Extras
from .strips import triangles_of_strips

# keys of accessors; and all in "attributes"
REFERENCES = {"indices", "input", "output", "inverseBindMatrices"}
UNMOVED: tuple[str, FloatArray] = ("", np.eye(4))


class Primitive(NamedTuple):
    """Where the faces of a primitive are.

    Attributes
    ----------
    mesh, number : int
        Its place in the file.
    faces, corners : (#f,) int64 and (#c,) int64
        Of the polygons.
    vertex : (#c,) int64
        Its own vertex at each corner.
    """

    mesh: int
    number: int
    faces: IntArray
    corners: IntArray
    vertex: IntArray


@dataclass(frozen=True, eq=False)
class GltfFile:
    """The file itself."""

    gltf: Gltf
    primitives: list[Primitive]


def parse_gltf(path: Path) -> MeshFile:
    """The mesh of a glTF or GLB file; each mesh once, where the first node shows it."""
    try:
        return _parsed(load_gltf(path))
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise Damaged(
            f"its description is not as glTF 2.0 has it ({type(error).__name__}: {error})"
        ) from None


def _parsed(gltf: Gltf) -> MeshFile:
    shown, primitives = placements(gltf), list[Primitive]()
    V, corners, sizes = list[FloatArray](), list[IntArray](), list[IntArray]()
    attributes: dict[str, list[FloatArray | None]] = {"TEXCOORD_0": [], "COLOR_0": [], "NORMAL": []}
    material = list[IntArray]()
    points = faces = at = 0
    for i, j, primitive in gltf.primitives():
        matrix = shown.get(i, UNMOVED)[1]
        its = primitive["attributes"]
        local = gltf.numbers(its["POSITION"])
        if local.ndim != 2 or local.shape[1] != 3:
            raise Damaged(f"the positions of its mesh {i} have not three columns")
        polygons = _polygons(gltf, primitive, len(local))
        k, m = len(polygons), len(polygons.corners)
        V.append(local @ matrix[:3, :3].T + matrix[:3, 3])
        primitives.append(Primitive(i, j, faces + np.arange(k), at + np.arange(m), polygons.corners))
        corners.append(polygons.corners + points)
        sizes.append(polygons.sizes)
        for name, rows in attributes.items():
            values = gltf.numbers(its[name]) if name in its else None
            rows.append(values if values is not None and values.shape[:1] == local.shape[:1] else None)
        if (normals := attributes["NORMAL"][-1]) is not None:
            attributes["NORMAL"][-1] = normals @ np.linalg.pinv(matrix[:3, :3])
        number = int(primitive.get("material", -1))
        material.append(np.full(k, number if number < len(gltf.listed("materials")) else -1))
        points, faces, at = points + len(local), faces + k, at + m
    if not primitives or not at:
        raise Damaged("it has no mesh of triangles")
    flat, size = np.concatenate(corners), np.concatenate(sizes)
    merged = _welded(np.concatenate(V), np.repeat([p.mesh for p in primitives], [len(v) for v in V]))
    used, corner = np.unique(merged[flat], return_inverse=True)
    colours, normals = _whole(attributes["COLOR_0"]), _whole(attributes["NORMAL"])
    part = [np.full(len(p.faces), p.mesh) for p in primitives]
    names = [
        shown.get(i, UNMOVED)[0] or str(mesh.get("name", f"mesh {i}"))
        for i, mesh in enumerate(gltf.listed("meshes"))
    ]
    words = [str(of.get("name", f"material {i}")) for i, of in enumerate(gltf.listed("materials"))]
    named = any("name" in of for of in gltf.listed("materials"))
    extras = Extras(
        colours=None if colours is None else np.column_stack((srgb(colours[:, :3]), colours[:, 3:]))[used],
        normals=normals,
        normal=None if normals is None else flat,
        parts=(tuple(names), np.concatenate(part)),
        materials=(tuple(words), np.concatenate(material)) if named else None,
        looks=tuple(map(of_gltf, gltf.listed("materials"))) if named else None,
        units="meter",
        source=GltfFile(gltf, primitives),
    )
    polygons = Polygons(corner.ravel().astype(np.int64), size)
    made = MeshFile(np.concatenate(V)[used], polygons, extras=extras)
    map_ = _whole(attributes["TEXCOORD_0"])
    if map_ is None:
        return made
    TC, same = np.unique(map_, axis=0, return_inverse=True)
    return replace(made, TC=TC * [1, -1] + [0, 1], texture=same.ravel()[flat].astype(np.int64))


def _whole(rows: list[FloatArray | None]) -> FloatArray | None:
    """An attribute, if all primitives have it in one width."""
    known = [values for values in rows if values is not None and values.ndim == 2]
    if len(known) < len(rows) or len({values.shape[1] for values in known}) > 1:
        return None
    return np.concatenate(known)


def _polygons(gltf: Gltf, primitive: dict[str, Any], n: int) -> Polygons:
    """The faces of a primitive, by its own vertices."""
    index = gltf.array(primitive["indices"]).astype(np.int64) if "indices" in primitive else np.arange(n)
    mode = primitive.get("mode", 4)
    if mode == 4:
        if len(index) % 3:
            raise Damaged(f"{len(index)} indices are no triangles")
        F = index.reshape(-1, 3)
    elif mode == 5:
        F = triangles_of_strips(index, np.zeros_like(index))
    else:
        F = np.column_stack(
            (np.full(max(len(index) - 2, 0), index[0] if len(index) else 0), index[1:-1], index[2:])
        )
    if len(F) and int(F.max()) >= n:
        raise Damaged(f"triangles name vertices beyond the {n} of their mesh")
    return polygons_among(F) if EXTENSION in primitive.get("extensions", {}) else Polygons.of_triangles(F)


def _welded(V: FloatArray, mesh: IntArray) -> IntArray:
    """For each vertex the first of its mesh in the same place: glTF doubles them at creases and seams."""
    _, first, same = np.unique(
        np.column_stack((mesh, V + 0.0)), axis=0, return_index=True, return_inverse=True
    )
    return np.asarray(first[same.ravel()])


def save_gltf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write GLB or glTF: a new file, or the one that was read with texture coordinates."""
    if isinstance(mesh.extras.source, GltfFile):
        _save_again(temporary, mesh, mesh.extras.source)
    else:
        save_new_gltf(temporary, mesh)


def _save_again(temporary: str, mesh: MeshFile, source: GltfFile) -> None:
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
        (own, texture), vertex = one_index(of.vertex, mesh.texture[of.corners])

        def taken(numbers: dict[str, int], rows: IntArray = own) -> dict[str, int]:
            return {
                key: buffer.add(gltf.array(number)[rows], VERTEX_ATTRIBUTES, gltf.text["accessors"][number])
                for key, number in numbers.items()
            }

        attributes.pop("TEXCOORD_0", None)
        st = buffer.add(single(map_[texture], "TC"), VERTEX_ATTRIBUTES)
        primitive |= {"mode": 4, "attributes": {**taken(attributes), "TEXCOORD_0": st}}
        if targets:
            primitive["targets"] = [taken(target) for target in targets]
        triangles, extensions = triangles_of(mesh, of.faces, of.corners, vertex)
        primitive["indices"] = buffer.add(triangles.ravel(), INDICES)
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
