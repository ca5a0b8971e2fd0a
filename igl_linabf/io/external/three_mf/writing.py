"""Write 3MF files with lib3mf."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...._types import BoolArray, FloatArray
from ....errors import MeshError, MeshWarning, first_few, stack_level
from ....surface import has_distinct_corners
from ...materials import COLOUR
from ...mesh_file import MeshFile
from ...parsing import import_optional
from ...pictures import encode_png
from ...vertex_splits import (
    choose_origin,
    find_rounding_error,
    round_to_single,
    warn_about_rounding,
    warn_of_error,
)
from .properties import PROPERTY_DTYPE
from .reading import UNITS, ThreeMfFile

TEXTURE_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"
MAX_COORDINATE = 1e9  # largest coordinate that lib3mf accepts
INTEGER_DIGITS = 17  # lib3mf's 64-bit integers can hold this many digits
MAX_DECIMALS = 16  # maximum number of decimals that lib3mf writes


def save_3mf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write an object for each part, with texture coordinates at the corners of its triangles."""
    assert mesh.TC is not None and mesh.texture is not None
    lib3mf = import_optional("lib3mf")
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    model.SetUnit(lib3mf.ModelUnit(UNITS.index(mesh.extras.units or "millimeter")))
    names, part = mesh.extras.parts or (("",), np.zeros(len(mesh.polygons), dtype=np.int64))
    source, decimals = mesh.extras.source, MAX_DECIMALS
    if isinstance(source, ThreeMfFile):
        for entry in source.metadata:
            model.GetMetaDataGroup().AddMetaData(*entry)
    group = _add_texture_group(lib3mf, model, mesh)
    part, corners = part[mesh.triangulation.face], mesh.texture[mesh.triangulation.place]
    kept, error = _find_valid_triangles(mesh), 0.0
    for i in np.unique(part[kept]).tolist():
        in_part = (part == i) & kept
        used, F = np.unique(mesh.triangles[in_part], return_inverse=True)
        mesh_object = model.AddMeshObject()
        mesh_object.SetName(names[i] if i >= 0 else "")
        # round the origin in the same way as lib3mf: to six digits, in single precision
        origin = np.array([float(np.float32(f"{x:.6g}")) for x in choose_origin(mesh.V[used])])
        shifted = mesh.V[used] - origin
        decimals = min(decimals, _count_decimals(shifted), _count_decimals(mesh.TC))
        points = round_to_single(shifted, "V")
        error = max(error, find_rounding_error(shifted, points))
        mesh_object.SetGeometry(
            _array_to_records(lib3mf.Position, points),
            _array_to_records(lib3mf.Triangle, F.reshape(-1, 3).astype("<u4")),
        )
        table = np.zeros(int(in_part.sum()), dtype=PROPERTY_DTYPE)
        table["resource"], table["index"] = (
            group.GetResourceID(),
            corners[in_part] + 1,
        )  # property numbers count from 1
        mesh_object.SetAllTriangleProperties(_array_to_records(lib3mf.TriangleProperties, table))
        mesh_object.SetObjectLevelProperty(group.GetResourceID(), int(corners[in_part][0, 0]) + 1)
        transform = wrapper.GetIdentityTransform()
        for k in range(3):
            transform.Fields[3][k] = origin[k]
        item = model.AddBuildItem(mesh_object, transform)
        if isinstance(source, ThreeMfFile) and i >= 0:
            mesh_object.SetType(lib3mf.ObjectType(source.types[i]))
            item.SetPartNumber(source.numbers[i])
    warn_of_error(error, "V")
    warn_about_rounding(mesh.TC, np.round(mesh.TC, decimals), "TC")
    writer = model.QueryWriter("3mf")
    writer.SetDecimalPrecision(decimals)
    # WriteToFile does not report a full disk, and may end the process
    Path(temporary).write_bytes(bytes(writer.WriteToBuffer()))


def _count_decimals(rows: FloatArray) -> int:
    """Return the maximum number of decimals that lib3mf can write for the numbers in `rows`."""
    largest = float(np.abs(rows).max(initial=0))
    if largest > MAX_COORDINATE:
        raise MeshError(
            f"V or TC has the number {largest:.3g}, and 3MF takes at most {MAX_COORDINATE:g}: scale the array"
        )
    before = int(np.floor(np.log10(largest))) + 1 if largest > 0 else 0
    return min(MAX_DECIMALS, INTEGER_DIGITS - before)


def _find_valid_triangles(mesh: MeshFile) -> BoolArray:
    """Return a mask of the triangles that 3MF can store; warn of faces with degenerate triangles."""
    F = mesh.triangles
    kept = has_distinct_corners(F)
    left_out = np.unique(mesh.triangulation.face[~kept])
    if len(left_out) == len(mesh.polygons):
        raise MeshError(
            "no face has three distinct vertices, which 3MF requires: write OBJ, or remove the faces"
        )
    if len(left_out):
        message = (
            f"faces {first_few(left_out)} have a vertex twice, which 3MF does not allow: they are left out"
        )
        warnings.warn(message, MeshWarning, stacklevel=stack_level())
    return kept


def _add_texture_group(lib3mf: Any, model: Any, mesh: MeshFile) -> Any:
    """Add the texture with its coordinates; 3MF does not support coordinates without an image."""
    assert mesh.TC is not None
    attached = model.AddAttachment("/3D/Textures/texture.png", TEXTURE_RELATION)
    attached.ReadFromBuffer(mesh.images.maps[COLOUR][0] if mesh.images else encode_png(np.ones((1, 1))))
    texture = model.AddTexture2DFromAttachment(attached)
    texture.SetContentType(lib3mf.TextureType.PNG)
    group = model.AddTexture2DGroup(texture)
    for u, v in mesh.TC.tolist():
        group.AddTex2Coord(lib3mf.Tex2Coord(u, v))
    return group


def _array_to_records(kind: Any, rows: NDArray[Any]) -> Any:
    """Convert the rows of an array to lib3mf records of type `kind`."""
    return (kind * len(rows)).from_buffer_copy(np.ascontiguousarray(rows).tobytes())
