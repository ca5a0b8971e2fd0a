"""3MF, by lib3mf: objects where the build places them, their names, the unit, texture coordinates."""

import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._types import BoolArray, FloatArray
from ...errors import MeshError, MeshWarning, some, stack_level
from ...surface import Polygons, distinct_corners
from ..mesh_file import MeshFile
from ..parsing import Damaged, Extras
from ..pictures import png
from ..vertex_splits import single_precision
from .optional_packages import call_reader, checked_mesh_file, import_optional

UNITS = ("micron", "millimeter", "centimeter", "inch", "foot", "meter")  # as lib3mf numbers them
RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"
PROPERTY = np.dtype([("resource", "<u4"), ("index", "<u4", 3)])  # of a triangle's corners


def parse_3mf(path: Path) -> MeshFile:
    """All objects of a 3MF file, where its build places them."""
    wrapper = import_optional("lib3mf").get_wrapper()
    model = wrapper.CreateModel()
    call_reader(model.QueryReader("3mf").ReadFromFile, path)
    mesh: MeshFile = call_reader(_parse_model, model)
    return mesh


def _parse_model(model: Any) -> MeshFile:
    V, F, TC, FTC, part = [], [], [], [], []
    names, points, rows = list[str](), 0, 0
    for mesh, matrix, name in _placed_meshes(model):
        given = _record_array(mesh.GetVertices(), "<f4", 3).astype(np.float64)
        F.append(_record_array(mesh.GetTriangleIndices(), "<u4", 3).astype(np.int64) + points)
        V.append(given @ matrix[:3] + matrix[3])
        map_, index = _texture(model, mesh)
        TC.append(map_)
        FTC.append(np.where(index < 0, -1, index + rows))
        part.append(np.full(len(F[-1]), len(names)))
        names.append(name or f"object {len(names)}")
        points, rows = points + len(given), rows + len(map_)
    if not V:
        raise Damaged("it has no object")
    extras = Extras(parts=(tuple(names), np.concatenate(part)), units=UNITS[int(model.GetUnit())])
    made = checked_mesh_file(np.concatenate(V), Polygons.of_triangles(np.concatenate(F)), extras)
    return replace(made, TC=np.concatenate(TC), texture=np.concatenate(FTC).ravel())


def _placed_meshes(model: Any) -> Iterator[tuple[Any, FloatArray, str]]:
    """The meshes of the build, those in assemblies as well: mesh, transform (4, 3) of rows, name."""
    items = model.GetBuildItems()
    waiting = []
    while items.MoveNext():
        item = items.GetCurrent()
        waiting.append((item.GetObjectResource(), _matrix(item.GetObjectTransform()), ""))
    while waiting:
        thing, matrix, above = waiting.pop(0)
        name = thing.GetName() or above
        if thing.IsMeshObject():
            yield model.GetMeshObjectByID(thing.GetUniqueResourceID()), matrix, name
            continue
        assembly = model.GetComponentsObjectByID(thing.GetUniqueResourceID())
        for i in range(assembly.GetComponentCount()):
            of = assembly.GetComponent(i)
            own = _matrix(of.GetTransform())
            joined = np.vstack((own[:3] @ matrix[:3], own[3] @ matrix[:3] + matrix[3]))
            waiting.append((of.GetObjectResource(), joined, name))


def _matrix(transform: Any) -> FloatArray:
    return np.array([list(row) for row in transform.Fields], dtype=np.float64)


def _record_array(records: list[Any], kind: str, width: int) -> NDArray[Any]:
    """lib3mf's lists of records, all of one size, as rows."""
    return np.frombuffer(b"".join(map(bytes, records)), dtype=kind).reshape(-1, width)


def _texture(model: Any, mesh: Any) -> tuple[FloatArray, NDArray[np.int64]]:
    """Texture coordinates, and their rows at the corners of the triangles; -1 where there is none."""
    given = np.frombuffer(b"".join(map(bytes, mesh.GetAllTriangleProperties())), dtype=PROPERTY)
    index = np.full((len(given), 3), -1, dtype=np.int64)
    TC: list[FloatArray] = [np.zeros((0, 2))]
    groups, rows = model.GetTexture2DGroups(), 0
    while groups.MoveNext():
        group = groups.GetCurrentTexture2DGroup()
        number = np.asarray(group.GetAllPropertyIDs(), dtype=np.int64)
        mine = given["resource"] == group.GetResourceID()
        if not len(number) or not mine.any():
            continue
        pairs = [group.GetTex2Coord(i) for i in number.tolist()]
        TC.append(np.array([(pair.U, pair.V) for pair in pairs]))
        index[mine] = np.searchsorted(number, given["index"][mine].astype(np.int64)) + rows
        rows += len(number)
    return np.concatenate(TC), index


def save_3mf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write an object for each part, with texture coordinates at the corners of its triangles."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    lib3mf = import_optional("lib3mf")
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    model.SetUnit(lib3mf.ModelUnit(UNITS.index(mesh.extras.units or "millimeter")))
    names, part = mesh.extras.parts or (("",), np.zeros(len(mesh.polygons), dtype=np.int64))
    group = _group(lib3mf, model, mesh)
    part, corners = part[mesh.split.face], mesh.texture[mesh.split.place]
    kept = _with_three_vertices(mesh)
    for i in np.unique(part[kept]).tolist():
        mine = (part == i) & kept
        used, F = np.unique(mesh.triangles[mine], return_inverse=True)
        thing = model.AddMeshObject()
        thing.SetName(names[i] if i >= 0 else "")
        points = single_precision(mesh.V[used], "V")
        thing.SetGeometry(
            _records(lib3mf.Position, points), _records(lib3mf.Triangle, F.reshape(-1, 3).astype("<u4"))
        )
        table = np.zeros(int(mine.sum()), dtype=PROPERTY)
        table["resource"], table["index"] = group.GetResourceID(), corners[mine] + 1  # they count from 1
        thing.SetAllTriangleProperties(_records(lib3mf.TriangleProperties, table))
        thing.SetObjectLevelProperty(group.GetResourceID(), int(corners[mine][0, 0]) + 1)
        model.AddBuildItem(thing, wrapper.GetIdentityTransform())
    model.QueryWriter("3mf").WriteToFile(temporary)


def _with_three_vertices(mesh: MeshFile) -> BoolArray:
    """The triangles that 3MF takes; a warning names the faces of the others."""
    F = mesh.triangles
    kept = distinct_corners(F)
    left_out = np.unique(mesh.split.face[~kept])
    if len(left_out) == len(mesh.polygons):
        raise MeshError("no face has three vertices, as 3MF asks for: write OBJ, or remove them")
    if len(left_out):
        said = f"faces {some(left_out)} have a vertex twice, which 3MF does not know: they are left out"
        warnings.warn(said, MeshWarning, stacklevel=stack_level())
    return kept


def _group(lib3mf: Any, model: Any, mesh: MeshFile) -> Any:
    """The texture with its coordinates; 3MF knows none without an image."""
    assert mesh.TC is not None
    attached = model.AddAttachment("/3D/Textures/texture.png", RELATION)
    attached.ReadFromBuffer(mesh.image or png(np.ones((1, 1))))
    texture = model.AddTexture2DFromAttachment(attached)
    texture.SetContentType(lib3mf.TextureType.PNG)
    group = model.AddTexture2DGroup(texture)
    for u, v in mesh.TC.tolist():
        group.AddTex2Coord(lib3mf.Tex2Coord(u, v))
    return group


def _records(kind: Any, rows: NDArray[Any]) -> Any:
    """Rows as an array of lib3mf's records."""
    return (kind * len(rows)).from_buffer_copy(np.ascontiguousarray(rows).tobytes())
