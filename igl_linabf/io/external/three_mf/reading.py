"""Read the placed objects of 3MF files."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...._types import FloatArray
from ....surface import Polygons
from ...limits import check_expansion
from ...mesh_file import MeshFile
from ...parsing import Damaged, Extras, call_reader, import_optional
from ...vertex_splits import warn_about_rounding
from ..checked_meshes import make_checked_mesh_file
from .packages import check_package, find_required_extensions, list_unread_content
from .properties import Properties, assign_colours

UNITS = ("micron", "millimeter", "centimeter", "inch", "foot", "meter")  # in the order of lib3mf's codes
UNKNOWN_EXTENSION_WARNING = 32914  # lib3mf's code for a required extension that it does not support
PLACEMENT_BYTES, CORNER_BYTES = 2048, 96  # estimated bytes per placed object, and per vertex or triangle
METADATA, TYPES, NUMBERS = "its metadata", "its object types", "its part numbers"


class PlacedMesh(NamedTuple):
    """A mesh and its transform from the `<build>` section of the file.

    Attributes
    ----------
    mesh : object of lib3mf
    matrix : (4, 3) float64
        Transform of row vectors.
    name, number : str
        The name of the mesh or its assembly, and the part number.
    """

    mesh: Any
    matrix: FloatArray
    name: str
    number: str


@dataclass(frozen=True)
class ThreeMfFile:
    """The contents of a 3MF file that no other format can store. A new 3MF file gets a copy of them.

    Attributes
    ----------
    metadata : tuple of tuples
        Arguments of lib3mf's `AddMetaData`: namespace, name, value, type, whether it must be preserved.
    types, numbers : tuple
        The object types of the parts as lib3mf's codes, and their part numbers.
    """

    metadata: tuple[tuple[str, str, str, str, bool], ...]
    types: tuple[int, ...]
    numbers: tuple[str, ...]
    kept: tuple[str, ...] = (METADATA, TYPES, NUMBERS)


def parse_3mf(path: Path) -> MeshFile:
    """Read all objects of a 3MF file, placed by the transforms in its `<build>` section."""
    wrapper = import_optional("lib3mf").get_wrapper()
    call_reader(check_package, path)
    model = wrapper.CreateModel()
    reader = model.QueryReader("3mf")
    call_reader(reader.ReadFromFile, path)
    codes = [reader.GetWarning(i)[0] for i in range(reader.GetWarningCount())]
    if UNKNOWN_EXTENSION_WARNING in codes:
        names = ", ".join(call_reader(find_required_extensions, path))
        raise Damaged(
            f"it requires an extension that lib3mf does not support ({names}), and cannot be read correctly "
            "without it: export the file without the extension"
        )
    mesh: MeshFile = call_reader(partial(_parse_model, size=path.stat().st_size), model)
    rest = call_reader(partial(list_unread_content, known=_list_attachment_paths(model)), path)
    return replace(mesh, extras=replace(mesh.extras, unshared=(*mesh.extras.unshared, *rest)))


def _list_attachment_paths(model: Any) -> set[str]:
    """Return the paths of the attachments and the thumbnail, which lib3mf reads in addition to models."""
    found = [model.GetAttachment(i) for i in range(model.GetAttachmentCount())]
    if model.HasPackageThumbnailAttachment():
        found.append(model.GetPackageThumbnailAttachment())
    return {attachment.GetPath().lstrip("/") for attachment in found}


def _parse_model(model: Any, size: int) -> MeshFile:
    V, F, part = [], [], []
    properties, names, points = Properties(model), list[str](), 0
    rows: dict[str, list[NDArray[np.int64]]] = {"colour": [], "material": [], "texture": []}
    placed = list(_iterate_placed_meshes(model, size))
    for mesh, matrix, name, _ in placed:
        positions = records_to_array(mesh.GetVertices(), "<f4", 3).astype(np.float64)
        spacing = np.abs(positions).max(initial=0) * np.finfo(np.float32).eps / 2
        warn_about_rounding(positions, (positions + spacing).astype(np.float32), "V as read by lib3mf")
        F.append(records_to_array(mesh.GetTriangleIndices(), "<u4", 3).astype(np.int64) + points)
        V.append(positions @ matrix[:3] + matrix[3])
        for kind, index in properties.find_corner_rows(mesh).items():
            rows[kind].append(index)
        part.append(np.full(len(F[-1]), len(names)))
        names.append(name or f"object {len(names)}")
        points += len(positions)
    if not V:
        raise Damaged("it has no object")
    rows_of_kind = {kind: np.concatenate(index) for kind, index in rows.items()}
    polygons = Polygons.from_triangles(np.concatenate(F))
    material = rows_of_kind["material"][:, 0]
    source = ThreeMfFile(
        _read_metadata(model),
        tuple(int(placed_mesh.mesh.GetType()) for placed_mesh in placed),
        tuple(placed_mesh.number or placed_mesh.mesh.GetPartNumber() for placed_mesh in placed),
    )
    extras = Extras(
        parts=(tuple(names), np.concatenate(part)),
        units=UNITS[int(model.GetUnit())],
        unshared=_list_unshared(model, source, placed)
        + ("materials hidden by colours",) * properties.covered,
        source=source,
    )
    if not polygons.find_out_of_range(points).any():
        extras = replace(extras, **assign_colours(rows_of_kind, properties, polygons.corners, points))
    if (material >= 0).any():
        words, looks = zip(*properties.materials, strict=True)
        extras = replace(extras, materials=(words, material), looks=looks)
    mesh_file = make_checked_mesh_file(np.concatenate(V), polygons, extras)
    return replace(mesh_file, TC=properties.TC, texture=rows_of_kind["texture"].ravel())


def _read_metadata(model: Any) -> tuple[tuple[str, str, str, str, bool], ...]:
    group = model.GetMetaDataGroup()
    entries = [group.GetMetaData(i) for i in range(group.GetMetaDataCount())]
    return tuple(
        (
            entry.GetNameSpace(),
            entry.GetName(),
            entry.GetValue(),
            entry.GetType(),
            bool(entry.GetMustPreserve()),
        )
        for entry in entries
    )


def _list_unshared(model: Any, source: ThreeMfFile, placed: list[PlacedMesh]) -> tuple[str, ...]:
    """Return descriptions, for warnings, of the contents of the model that other formats cannot store."""
    meshes = [mesh_.mesh for mesh_ in placed]
    textures = model.GetTexture2Ds().Count()
    found = {
        METADATA: bool(source.metadata),
        TYPES: any(kind != 1 for kind in source.types),
        NUMBERS: any(
            number not in ("", mesh_.name) for number, mesh_ in zip(source.numbers, placed, strict=True)
        ),
        "the metadata of its objects": any(mesh_.GetMetaDataGroup().GetMetaDataCount() for mesh_ in meshes),
        "the images of its textures": textures > 0,
        "composite materials": model.GetCompositeMaterials().Count() > 0,
        "its attachments": model.GetAttachmentCount() > textures,
        "its thumbnail": model.HasPackageThumbnailAttachment(),
        "beam lattices": any(mesh_.BeamLattice().GetBeamCount() for mesh_ in meshes),
        "slices": model.GetSliceStacks().Count() > 0,
        "sets of triangles": any(mesh_.GetTriangleSetCount() for mesh_ in meshes),
        "fields and level sets": model.GetLevelSets().Count() + model.GetFunctions().Count() > 0,
    }
    return tuple(what for what, is_there in found.items() if is_there)


def _iterate_placed_meshes(model: Any, size: int) -> Iterator[PlacedMesh]:
    """Yield the meshes in the `<build>` section of the file, including the meshes of assemblies.

    Assemblies may contain assemblies, so the number of meshes may grow exponentially. The memory for the
    meshes is limited in proportion to the `size` of the file.
    """
    items = model.GetBuildItems()
    waiting, taken = deque[tuple[Any, FloatArray, str, str]](), 0
    components: dict[int, list[tuple[Any, FloatArray]]] = {}
    while items.MoveNext():
        item = items.GetCurrent()
        place = _to_matrix(item.GetObjectTransform())
        waiting.append((item.GetObjectResource(), place, "", item.GetPartNumber()))
    while waiting:
        thing, matrix, above, number = waiting.popleft()
        name = thing.GetName() or above
        taken += PLACEMENT_BYTES
        check_expansion(taken, size, "its objects, which assemblies repeat,")
        if thing.IsMeshObject():
            mesh = model.GetMeshObjectByID(thing.GetUniqueResourceID())
            taken += CORNER_BYTES * (mesh.GetVertexCount() + mesh.GetTriangleCount())
            yield PlacedMesh(mesh, matrix, name, number)
            continue
        if thing.IsLevelSetObject():
            continue
        assembly = thing.GetUniqueResourceID()
        if assembly not in components:
            components[assembly] = list(_iterate_components(model.GetComponentsObjectByID(assembly)))
        for part, local in components[assembly]:
            joined = np.vstack((local[:3] @ matrix[:3], local[3] @ matrix[:3] + matrix[3]))
            waiting.append((part, joined, name, number))


def _iterate_components(assembly: Any) -> Iterator[tuple[Any, FloatArray]]:
    """Yield the objects of an assembly and their transforms."""
    for i in range(assembly.GetComponentCount()):
        component = assembly.GetComponent(i)
        yield component.GetObjectResource(), _to_matrix(component.GetTransform())


def _to_matrix(transform: Any) -> FloatArray:
    return np.array([list(row) for row in transform.Fields], dtype=np.float64)


def records_to_array(records: list[Any], kind: str, width: int) -> NDArray[Any]:
    """Return a list of lib3mf records of equal size as rows of an array."""
    return np.frombuffer(b"".join(map(bytes, records)), dtype=kind).reshape(-1, width)
