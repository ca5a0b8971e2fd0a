"""Write 3MF."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...._types import BoolArray, FloatArray
from ....errors import MeshError, MeshWarning, some, stack_level
from ....surface import distinct_corners
from ...materials import COLOUR
from ...mesh_file import MeshFile
from ...pictures import png
from ...vertex_splits import origin_of, single_precision, warn_of_rounding
from ..optional_packages import import_optional
from .properties import PROPERTY
from .reading import UNITS, ThreeMfFile

RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"

# The largest coordinate that lib3mf takes.
LARGEST = 1e9

# Digits that lib3mf's integers of 64 bits hold, less one; and the most that it writes after the point. With
# more, it writes wrong numbers; with less, it rounds small bodies. tests/io/test_precision.py.
DIGITS, MOST_DECIMALS = 17, 16


def save_3mf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write an object for each part, with texture coordinates at the corners of its triangles."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    lib3mf = import_optional("lib3mf")
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    model.SetUnit(lib3mf.ModelUnit(UNITS.index(mesh.extras.units or "millimeter")))
    names, part = mesh.extras.parts or (("",), np.zeros(len(mesh.polygons), dtype=np.int64))
    source, decimals = mesh.extras.source, MOST_DECIMALS
    if isinstance(source, ThreeMfFile):
        for entry in source.metadata:
            model.GetMetaDataGroup().AddMetaData(*entry)
    group = _group(lib3mf, model, mesh)
    part, corners = part[mesh.split.face], mesh.texture[mesh.split.place]
    kept = _with_three_vertices(mesh)
    for i in np.unique(part[kept]).tolist():
        mine = (part == i) & kept
        used, F = np.unique(mesh.triangles[mine], return_inverse=True)
        thing = model.AddMeshObject()
        thing.SetName(names[i] if i >= 0 else "")
        # lib3mf writes six digits of it, in single precision
        origin = np.array([float(np.float32(f"{x:.6g}")) for x in origin_of(mesh.V[used])])
        near = mesh.V[used] - origin
        decimals = min(decimals, _decimals(near), _decimals(mesh.TC))
        points = single_precision(near, "V")
        thing.SetGeometry(
            _records(lib3mf.Position, points), _records(lib3mf.Triangle, F.reshape(-1, 3).astype("<u4"))
        )
        table = np.zeros(int(mine.sum()), dtype=PROPERTY)
        table["resource"], table["index"] = group.GetResourceID(), corners[mine] + 1  # they count from 1
        thing.SetAllTriangleProperties(_records(lib3mf.TriangleProperties, table))
        thing.SetObjectLevelProperty(group.GetResourceID(), int(corners[mine][0, 0]) + 1)
        transform = wrapper.GetIdentityTransform()
        for k in range(3):
            transform.Fields[3][k] = origin[k]
        item = model.AddBuildItem(thing, transform)
        if isinstance(source, ThreeMfFile) and i >= 0:
            thing.SetType(lib3mf.ObjectType(source.types[i]))
            item.SetPartNumber(source.numbers[i])
    warn_of_rounding(mesh.TC, np.round(mesh.TC, decimals), "TC")
    writer = model.QueryWriter("3mf")
    writer.SetDecimalPrecision(decimals)
    writer.WriteToFile(temporary)


def _decimals(rows: FloatArray) -> int:
    """How many digits after the point these numbers may have, whose integers lib3mf writes."""
    largest = float(np.abs(rows).max(initial=0))
    if largest > LARGEST:
        raise MeshError(f"V or TC has the number {largest:.3g}, and 3MF takes {LARGEST:g} at most: scale it")
    before = int(np.floor(np.log10(largest))) + 1 if largest > 0 else 0
    return min(MOST_DECIMALS, DIGITS - before)


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
    attached.ReadFromBuffer(mesh.images.maps[COLOUR][0] if mesh.images else png(np.ones((1, 1))))
    texture = model.AddTexture2DFromAttachment(attached)
    texture.SetContentType(lib3mf.TextureType.PNG)
    group = model.AddTexture2DGroup(texture)
    for u, v in mesh.TC.tolist():
        group.AddTex2Coord(lib3mf.Tex2Coord(u, v))
    return group


def _records(kind: Any, rows: NDArray[Any]) -> Any:
    """Rows as an array of lib3mf's records."""
    return (kind * len(rows)).from_buffer_copy(np.ascontiguousarray(rows).tobytes())
