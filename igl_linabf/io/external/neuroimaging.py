"""Read and write GIFTI and FreeSurfer brain surfaces with nibabel."""

import base64
import binascii
import copy
import gzip
import warnings
from contextlib import suppress
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any
from xml.parsers.expat import ParserCreate

import numpy as np

from ..._types import FloatArray, IntArray
from ...errors import MeshWarning, format_count, stack_level
from ...surface import Polygons
from ..limits import check_expansion, get_max_expanded_bytes, inflate, parse_size, parse_xml, reject_entities
from ..mesh_file import MeshFile
from ..parsing import Damaged, Extras, call_reader, import_optional
from ..references import Folder
from ..vertex_splits import make_flat_surface, to_single_precision
from .checked_meshes import make_checked_mesh_file

POINTS, TRIANGLES = "NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE"
COLOURS = ("NIFTI_INTENT_RGB_VECTOR", "NIFTI_INTENT_RGBA_VECTOR")
METADATA, LABELS, ARRAYS = "its metadata", "its labels", "its other data arrays"
TRIANGLE_FILE_MAGIC = b"\xff\xff\xfe"  # FreeSurfer's triangle surfaces; two lines of text follow
GZIP_MAGIC = b"\x1f\x8b"
MAX_DIMENSIONS = 6  # of an array, by the specification of GIFTI
VOLUME = "the volume that it was made from"


@dataclass(frozen=True, eq=False)
class GiftiFile:
    """The nibabel image of a GIFTI file, and names of the contents that are copied to a new GIFTI file."""

    image: Any
    kept: tuple[str, ...] = (METADATA, LABELS, ARRAYS)


@dataclass(frozen=True)
class FreeSurferFile:
    """The trailer of a FreeSurfer surface: the geometry of the MRI volume, and the commands that were run."""

    trailer: bytes
    kept: tuple[str, ...] = (VOLUME,)


def parse_gifti(path: Path, allow_outside: bool = False) -> MeshFile:
    """Read the surface of a GIFTI file, with the suffix .gii or, if compressed, .gii.gz."""
    nibabel = import_optional("nibabel")
    _check_gifti(path, Folder(path.parent, allow_outside))
    image = call_reader(nibabel.load, path)
    if image is None:
        raise Damaged("its XML has no element GIFTI")
    for array in image.darrays:  # the arrays that are kept are written into the file itself
        array.encoding, array.ext_fname = nibabel.gifti.util.gifti_encoding_codes.code["B64GZ"], ""
    try:
        (points,) = image.get_arrays_from_intent(POINTS)
        (triangles,) = image.get_arrays_from_intent(TRIANGLES)
    except (AttributeError, ValueError):
        raise Damaged(
            "it does not have one array of points and one of triangles: is it a .surf.gii?"
        ) from None
    types = points.data.dtype, triangles.data.dtype
    if not all(of.kind in "fiu" for of in types):
        raise Damaged(f"its arrays are of the types {types[0]} and {types[1]}, not of real numbers")
    V = np.asarray(points.data, dtype=np.float64)
    F = np.asarray(triangles.data)
    if V.ndim != 2 or V.shape[1] != 3 or F.ndim != 2 or F.shape[1] != 3:
        raise Damaged(f"its arrays have the shapes {V.shape} and {F.shape}, not three columns")
    found = {
        METADATA: any(len(element.meta) for element in (image, points, triangles)),
        LABELS: bool(image.labeltable.labels),
        ARRAYS: bool(_get_other_arrays(image)),
        "its coordinate systems": any(map(_is_meaningful, (points.coordsys and [points.coordsys]) or [])),
    }
    return make_checked_mesh_file(
        V,
        Polygons.from_triangles(F.astype(np.int64)),
        Extras(
            colours=_read_point_colours(image, len(V)),
            units="millimeter",
            unshared=tuple(what for what, is_there in found.items() if is_there),
            source=GiftiFile(image),
        ),
    )


def _check_gifti(path: Path, folder: Folder) -> None:
    """Raise an error if nibabel would read files outside the folder, or take much more memory than the file.

    Raises
    ------
    Damaged
        The text or the arrays would become too large, or an array has fewer sizes than dimensions.
    MeshError
        The data of an array are in a file outside the folder.
    """
    data = path.read_bytes()
    limit, size = get_max_expanded_bytes(len(data)), len(data)
    if data.startswith(GZIP_MAGIC):
        data = inflate(data, limit, "its text")
    reject_entities(data)
    for attributes, texts in _list_gifti_arrays(data):
        encoding = attributes.get("Encoding", "GZ").upper()  # GZipBase64Binary by default, as in nibabel
        if "EXT" in encoding:
            name = attributes.get("ExternalFileName", "")
            if (file := folder.find_file(name)) is None:
                raise Damaged(f"the file {name[:80]!r} of an array is missing")
            size += file.stat().st_size
        for text in texts if "GZ" in encoding else ():
            with suppress(binascii.Error, ValueError):  # nibabel reports invalid base64
                if packed := base64.b64decode(text):
                    limit -= len(inflate(packed, limit, "an array"))
        dimensions = parse_size(attributes, "Dimensionality", 0)
        if dimensions > MAX_DIMENSIONS:
            raise Damaged(f"an array has {dimensions:,} dimensions: GIFTI has 1 to {MAX_DIMENSIONS}")
        sizes = [parse_size(attributes, f"Dim{i}") for i in range(dimensions)]
        check_expansion(8 * prod(sizes), size, "an array")


def _list_gifti_arrays(data: bytes) -> list[tuple[dict[str, str], list[str]]]:
    """Return the attributes of each data array, and the pieces of text in its elements `Data`.

    nibabel decodes each piece separately; a piece ends where an element begins or ends.
    """
    arrays: list[tuple[dict[str, str], list[list[str]]]] = [({}, [[]])]
    depth = 0  # number of open elements `Data`

    def start_element(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += name == "Data"
        if name == "DataArray":
            arrays.append((attributes, []))
        arrays[-1][1].append([])

    def end_element(name: str) -> None:
        nonlocal depth
        depth -= name == "Data"
        arrays[-1][1].append([])

    def add_text(text: str) -> None:
        if depth:
            arrays[-1][1][-1].append(text)

    parser = ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start_element, end_element
    parser.CharacterDataHandler = add_text
    parse_xml(parser, data)
    return [(attributes, list(filter(str.strip, map("".join, texts)))) for attributes, texts in arrays[1:]]


def _get_other_arrays(image: Any) -> list[Any]:
    """Return the data arrays of a GIFTI image, except for points and triangles."""
    names = import_optional("nibabel.nifti1").intent_codes.niistring
    return [array for array in image.darrays if names[array.intent] not in (POINTS, TRIANGLES)]


def _is_meaningful(system: Any) -> bool:
    """Return True if a coordinate system names the space of the points, or transforms to another space."""
    return bool(system.dataspace or system.xformspace or not np.array_equal(system.xform, np.eye(4)))


def _read_point_colours(image: Any, n: int) -> FloatArray | None:
    """Return the colours of the vertices, from 0 to 1, or None."""
    for intent in COLOURS:
        for array in image.get_arrays_from_intent(intent):
            if array.data.shape in ((n, 3), (n, 4)) and array.data.dtype.kind in "fiu":
                values = np.asarray(array.data, dtype=np.float64)
                return values / 255 if array.data.dtype.kind in "ui" else values
    return None


def save_gifti(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write a GIFTI file whose surface is the flat map, as other programs do for flat cortices."""
    gifti = import_optional("nibabel.gifti")
    points, triangles, vertex = make_flat_surface(mesh)
    of_points, of_triangles = {"GeometricType": "Flat"}, dict[str, str]()
    source, image = mesh.extras.source, gifti.GiftiImage()
    if isinstance(source, GiftiFile):
        given = source.image
        image = gifti.GiftiImage(meta=given.meta, labeltable=given.labeltable)
        of_points = {**given.get_arrays_from_intent(POINTS)[0].meta, **of_points}
        of_triangles = dict(given.get_arrays_from_intent(TRIANGLES)[0].meta)
        if vertex is not None and "TopologicalType" in of_triangles:
            of_triangles["TopologicalType"] = "Cut"
    for data, intent, meta in (
        (to_single_precision(points, "TC"), POINTS, of_points),
        (triangles.astype(np.int32), TRIANGLES, of_triangles),
    ):
        image.add_gifti_data_array(gifti.GiftiDataArray(data, intent=intent, meta=gifti.GiftiMetaData(meta)))
    if isinstance(source, GiftiFile):
        for array in _select_rows(_get_other_arrays(source.image), vertex, len(mesh.V)):
            image.add_gifti_data_array(array)
    data = image.to_bytes(mode="force")  # arrays of types that are not in the specification are kept, too
    Path(temporary).write_bytes(gzip.compress(data, mtime=0) if path.suffix.lower() == ".gz" else data)


def _select_rows(arrays: list[Any], vertex: IntArray | None, n: int) -> list[Any]:
    """Return the rows `vertex` of each array that has n rows, one per vertex; discard all other arrays.

    If `vertex` is None, return all arrays unchanged.
    """
    if vertex is None:
        return arrays
    selected = []
    for array in arrays:
        if len(array.data) == n:
            array = copy.copy(array)
            array.data = array.data[vertex]
            array.dims = list(array.data.shape)
            selected.append(array)
    if len(selected) < len(arrays):
        warnings.warn(
            f"{len(arrays) - len(selected)} data arrays of the GIFTI file do not have one value per vertex, "
            "and vertices are duplicated: the arrays are left out",
            MeshWarning,
            stacklevel=stack_level(),
        )
    return selected


def parse_freesurfer(path: Path) -> MeshFile:
    """Read the surface of a FreeSurfer file, for example lh.pial."""
    data = path.read_bytes()
    _check_counts(data)
    V, F = call_reader(import_optional("nibabel.freesurfer").read_geometry, path)
    polygons = Polygons.from_triangles(np.asarray(F, dtype=np.int64))
    trailer = _read_trailer(data, 12 * (len(V) + len(F)))
    extras = Extras(
        units="millimeter",
        unshared=(VOLUME,) * bool(trailer),
        source=FreeSurferFile(trailer) if trailer else None,
    )
    return make_checked_mesh_file(np.asarray(V, dtype=np.float64), polygons, extras)


def _check_counts(data: bytes) -> None:
    """Raise `Damaged` if a surface file is too short for the vertices and faces that it announces."""
    if data.startswith(TRIANGLE_FILE_MAGIC):
        start = _find_counts(data)
        n, m = (int.from_bytes(data[start + k : start + k + 4], "big") for k in (0, 4))
        needed = start + 8 + 12 * (n + m)
    else:  # a quad surface: four vertices per face, coordinates of two or four bytes
        n, m = (int.from_bytes(data[k : k + 3], "big") for k in (3, 6))
        needed = 9 + 3 * n * (2 if data.startswith(b"\xff\xff\xff") else 4) + 12 * m
    if needed > len(data):
        raise Damaged(
            f"it has {len(data)} bytes, but {format_count(n, 'vertex')} and {format_count(m, 'face')} "
            f"need {needed}"
        )


def _find_counts(data: bytes) -> int:
    """Return the byte offset of the counts of vertices and faces, after two lines of text."""
    first = data.find(b"\n", len(TRIANGLE_FILE_MAGIC))
    second = data.find(b"\n", first + 1)
    if first < 0 or second < 0:
        raise Damaged("the two lines of text at its start have no line ends")
    return second + 1


def _read_trailer(data: bytes, size: int) -> bytes:
    """Return the bytes of a triangle surface after its vertices and faces, which occupy `size` bytes."""
    if not data.startswith(TRIANGLE_FILE_MAGIC):
        return b""
    return data[_find_counts(data) + 8 + size :]  # 8 bytes: the counts of vertices and faces


def save_freesurfer(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the flat map as a FreeSurfer surface."""
    points, triangles, _ = make_flat_surface(mesh)
    trailer = mesh.extras.source.trailer if isinstance(mesh.extras.source, FreeSurferFile) else b""
    counts = np.array([len(points), len(triangles)], ">i4")
    parts = (counts, to_single_precision(points, "TC").astype(">f4"), triangles.astype(">i4"))
    # nibabel's writer is not used, because it omits rows without an error if the disk is full
    data = b"".join((TRIANGLE_FILE_MAGIC, b"igl_linabf\n\n", *(part.tobytes() for part in parts), trailer))
    Path(temporary).write_bytes(data)
