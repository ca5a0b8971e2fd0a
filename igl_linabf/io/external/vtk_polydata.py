"""Read and write VTP, the polygons of VTK, with pyvista."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..._types import FloatArray, IntArray
from ..materials import quantise_colours
from ..mesh_file import MeshFile
from ..parsing import Column, Damaged, Extras, call_reader, import_optional, make_polygons, triangulate_strips
from ..vertex_splits import split_vertices
from .checked_meshes import make_checked_mesh_file
from .vtk_sizes import check_announced_sizes

# VTK's codes for normals, texture coordinates and tangents, and the number of these codes.
NORMALS, TEXTURE, TANGENTS, ATTRIBUTES = 2, 3, 10, 11
NEW_TEXTURE = "Texture Coordinates"


@dataclass(frozen=True, eq=False)
class VtpFile:
    """The pyvista mesh of a VTP file, and names of the contents that are copied to a new VTP file."""

    mesh: Any
    kept: tuple[str, ...]


def parse_vtp(path: Path) -> MeshFile:
    """Read the polygons of a VTP file."""
    pyvista = import_optional("pyvista")
    data = path.read_bytes()
    with pyvista.vtk_verbosity("off"), pyvista.VtkErrorCatcher(send_to_logging=False):
        check_announced_sizes(data)  # damaged data are reported when they are read
    mesh = call_reader(_read_polydata, data)
    extra_cells = "its lines and points" if mesh.n_lines or mesh.n_verts else ""
    if mesh.n_strips:
        mesh = triangulate_strip_cells(mesh)
    if mesh.n_points == 0 or mesh.GetNumberOfPolys() == 0:
        raise Damaged("it has no polygons")
    corners, sizes = _read_cells(pyvista, mesh.GetPolys())
    polygons = make_polygons(Column(corners, sizes))
    if (polygons.sizes < 3).any():
        raise Damaged("it has polygons with fewer than three corners")
    texture = _get_texture_name(mesh.GetPointData())
    normals = mesh.point_data.active_normals
    arrays = _describe_arrays(mesh)
    tangents = "its tangents" if _get_attribute_name(mesh.GetPointData(), TANGENTS) else ""
    extras = Extras(
        colours=_read_colours(mesh.point_data, 0, mesh.n_points),
        face_colours=_read_colours(mesh.cell_data, mesh.n_verts + mesh.n_lines, len(polygons)),
        normals=None if normals is None else np.asarray(normals, dtype=np.float64),
        normal=None if normals is None else corners,
        unshared=tuple(filter(None, (arrays, extra_cells, tangents))),
        source=VtpFile(mesh, (arrays,)),
    )
    mesh_file = make_checked_mesh_file(np.asarray(mesh.points, dtype=np.float64), polygons, extras)
    if texture is None:
        return mesh_file
    TC = np.asarray(mesh.point_data[texture], dtype=np.float64)[:, :2]
    unique_TC, row = np.unique(TC, axis=0, return_inverse=True)
    return replace(mesh_file, TC=unique_TC, texture=row.ravel().astype(np.int64)[polygons.corners])


def _read_polydata(data: bytes) -> Any:
    """Parse a VTK file; raise the first error that VTK reports, because VTK itself continues after errors.

    VTK gets the bytes instead of a path, because it would open the file twice, and another process may
    replace the file in between.
    """
    pyvista, readers = (import_optional(name) for name in ("pyvista", "vtkmodules.vtkIOXML"))
    with pyvista.vtk_verbosity("off"), pyvista.VtkErrorCatcher(send_to_logging=False) as caught:
        reader = readers.vtkXMLPolyDataReader()
        reader.ReadFromInputStringOn()
        reader.SetInputString(data)
        reader.Update()
    errors = [event.alert for event in caught.events if event.kind.upper() != "WARNING"]
    if errors:
        raise Damaged(errors[0].splitlines()[0])
    return pyvista.wrap(reader.GetOutput())


def _read_cells(pyvista: Any, cells: Any) -> tuple[IntArray, IntArray]:
    """Return the points of VTK cells, concatenated, and the number of points of each cell."""
    offsets, corners = (
        np.asarray(pyvista.convert_array(array), dtype=np.int64)
        for array in (cells.GetOffsetsArray(), cells.GetConnectivityArray())
    )
    return corners, np.diff(offsets)


def triangulate_strip_cells(mesh: Any) -> Any:
    """Return the mesh with its triangle strips replaced by triangles; each one gets its strip's cell data.

    VTK's own triangle filter is not used, because it produces incorrect cell data.
    """
    pyvista = import_optional("pyvista")
    (corners, sizes), (of_strips, lengths) = (
        _read_cells(pyvista, cells) for cells in (mesh.GetPolys(), mesh.GetStrips())
    )
    if (lengths < 3).any() or of_strips.max(initial=0) >= mesh.n_points:
        raise Damaged("it has triangle strips with fewer than three points, or with missing points")
    triangles, strip = triangulate_strips(of_strips, np.repeat(np.arange(len(lengths)), lengths))
    faces = np.insert(corners, np.cumsum(sizes) - sizes, sizes)
    faces = np.concatenate((faces, np.insert(triangles, 0, 3, axis=1).ravel()))
    extra_cells = {"verts": mesh.verts} if mesh.n_verts else {}
    if mesh.n_lines:
        extra_cells["lines"] = mesh.lines
    triangulated = pyvista.PolyData(mesh.points, faces, **extra_cells)
    triangulated.GetPointData().ShallowCopy(mesh.GetPointData())
    triangulated.GetFieldData().ShallowCopy(mesh.GetFieldData())
    strip_start = mesh.n_verts + mesh.n_lines + len(sizes)
    rows = np.concatenate((np.arange(strip_start), strip_start + strip))
    for name, values in mesh.cell_data.items():
        triangulated.cell_data[name] = np.asarray(values)[rows]
    _restore_active(mesh.GetCellData(), triangulated.GetCellData())
    return triangulated


def _describe_arrays(mesh: Any) -> str:
    """Describe, for warnings, the arrays other than normals, tangents, colours and texture coordinates."""
    points = mesh.GetPointData()
    known = {
        _get_attribute_name(points, NORMALS),
        _get_texture_name(points),
        _get_attribute_name(points, TANGENTS),
    }
    known |= {_find_colour_array(mesh.point_data), _find_colour_array(mesh.cell_data)}
    arrays = (*mesh.point_data.items(), *mesh.cell_data.items(), *mesh.field_data.items())
    names = [name for name, _ in arrays if name not in known]
    return f"the arrays {', '.join(names)}" if names else ""


def _get_attribute_name(data: Any, attribute: int) -> str | None:
    """Return the name of the array that VTK uses for an attribute, or None."""
    array = data.GetAbstractAttribute(attribute)
    return None if array is None else str(array.GetName())


def _get_texture_name(points: Any) -> str | None:
    """Return the name of the array of texture coordinates; None unless it has at least two components."""
    name = _get_attribute_name(points, TEXTURE)
    return name if name is not None and points.GetArray(name).GetNumberOfComponents() > 1 else None


def _find_colour_array(arrays: Any) -> str | None:
    """Return the name of the first byte array with three or four columns, VTK's form of colours."""
    for name, values in arrays.items():
        if values.dtype == np.uint8 and values.ndim == 2 and values.shape[1] in (3, 4):
            return str(name)
    return None


def _read_colours(arrays: Any, first: int, count: int) -> FloatArray | None:
    """Return `count` colours, starting at row `first` of the colour array; None without this array."""
    name = _find_colour_array(arrays)
    return None if name is None else np.asarray(arrays[name], dtype=np.float64)[first : first + count] / 255


def save_vtp(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write polygons with texture coordinates at the points, and with all other arrays of a mesh from VTP."""
    pyvista, source, extras = import_optional("pyvista"), mesh.extras.source, mesh.extras
    split = split_vertices(mesh, normals=not isinstance(source, VtpFile))
    rows = split.vertex
    faces = np.insert(split.corners, mesh.polygons.starts, mesh.polygons.sizes)
    written = pyvista.PolyData(mesh.V[rows], faces)
    name = NEW_TEXTURE
    if isinstance(source, VtpFile):
        name = _get_texture_name(source.mesh.GetPointData()) or NEW_TEXTURE
        copy_polydata_arrays(written, source.mesh, rows)
    else:
        if extras.colours is not None:
            written.point_data["RGB"] = quantise_colours(extras.colours[rows])
        if extras.face_colours is not None:
            written.cell_data["RGB"] = quantise_colours(extras.face_colours)
        if split.normals is not None:
            written.point_data["Normals"] = split.normals
            written.GetPointData().SetActiveAttribute("Normals", NORMALS)
    written.point_data[name] = split.TC
    written.GetPointData().SetActiveAttribute(name, TEXTURE)
    writer = import_optional("vtkmodules.vtkIOXML").vtkXMLPolyDataWriter()
    writer.SetInputData(written)
    writer.SetDataModeToBinary()
    writer.SetWriteToOutputString(True)  # VTK's file writer does not report a full disk
    writer.Write()
    Path(temporary).write_bytes(writer.GetOutputString().encode())


def copy_polydata_arrays(written: Any, given: Any, rows: IntArray) -> None:
    """Copy the arrays of points (at `rows`), cells and fields, and their active attributes, to a new mesh.

    The old texture coordinates and the tangents derived from them are not copied.
    """
    first = given.n_verts + given.n_lines  # VTK numbers cells of points and lines before polygons
    points = given.GetPointData()
    replaced = {_get_texture_name(points), _get_attribute_name(points, TANGENTS)}
    for name, values in given.point_data.items():
        if name not in replaced:
            written.point_data[name] = np.asarray(values)[rows]
    for name, values in given.cell_data.items():
        written.cell_data[name] = np.asarray(values)[first : first + written.n_cells]
    for name, values in given.field_data.items():
        written.field_data[name] = values
    _restore_active(given.GetPointData(), written.GetPointData())
    _restore_active(given.GetCellData(), written.GetCellData())


def _restore_active(given: Any, written: Any) -> None:
    """Mark arrays as active scalars, normals and other attributes, as in the original data."""
    for attribute in range(ATTRIBUTES):
        name = _get_attribute_name(given, attribute)
        if name is not None and written.HasArray(name):
            written.SetActiveAttribute(name, attribute)
