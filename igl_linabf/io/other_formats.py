"""Formats that other packages own: 3MF (trimesh), GIFTI and FreeSurfer (nibabel), VTP (pyvista)."""

from __future__ import annotations

import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MeshWarning, stack_level
from ..surface import Polygons
from .mesh_file import MeshFile
from .one_index import one_index
from .parsing import Column, Damaged, Extras, Parsed, polygons_of, untextured

POINTS, TRIANGLES = "NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE"
TEXTURE = "Texture Coordinates"  # in VTP


def _needed(module: str) -> Any:
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(
            f"{error}: pip install 'igl-linabf[formats]' reads and writes this format"
        ) from None


def _quietly(read: Any, *given: Any, **named: Any) -> Any:
    """What another package's reader returns; whatever it raises says that the file is damaged."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read(*given, **named)
    except MemoryError:
        raise
    except Exception as error:  # each package has its own
        raise Damaged(f"{type(error).__name__}: {error}") from None


def parse_3mf(path: Path) -> Parsed:
    """All objects of a 3MF file, where its build places them."""
    trimesh = _needed("trimesh")
    for module in ("networkx", "lxml"):
        _needed(module)
    path.open("rb").close()
    scene = _quietly(trimesh.load_scene, str(path), process=False)
    V, F, parts, names, n = [], [], [], list[str](), 0
    for node in sorted(scene.graph.nodes_geometry):
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        points = np.asarray(mesh.vertices, dtype=np.float64)
        V.append(points @ matrix[:3, :3].T + matrix[:3, 3])
        F.append(np.asarray(mesh.faces, dtype=np.int64) + n)
        parts.append(np.full(len(F[-1]), len(names)))
        names.append(str(node))
        n += len(points)
    if not V:
        raise Damaged("it has no object")
    units = scene.units if isinstance(scene.units, str) else None
    extras = Extras(parts=(tuple(names), np.concatenate(parts)), units=units)
    return _checked(np.concatenate(V), Polygons.of_triangles(np.concatenate(F)), extras)


def parse_gifti(path: Path) -> Parsed:
    """The surface of a GIFTI file."""
    nibabel = _needed("nibabel")
    path.open("rb").close()
    image = _quietly(nibabel.load, str(path))
    try:
        (points,) = image.get_arrays_from_intent(POINTS)
        (triangles,) = image.get_arrays_from_intent(TRIANGLES)
    except (AttributeError, ValueError):
        raise Damaged("it has not one array of points and one of triangles: is it a .surf.gii?") from None
    V = np.asarray(points.data, dtype=np.float64)
    F = np.asarray(triangles.data)
    if V.ndim != 2 or V.shape[1] != 3 or F.ndim != 2 or F.shape[1] != 3:
        raise Damaged(f"its arrays have the shapes {V.shape} and {F.shape}, not three columns")
    return _checked(V, Polygons.of_triangles(F.astype(np.int64)), Extras(source=image, units="millimeter"))


def parse_freesurfer(path: Path) -> Parsed:
    """The surface of a FreeSurfer file, lh.pial for example."""
    nibabel = _needed("nibabel.freesurfer")
    path.open("rb").close()  # what cannot be opened is no damage
    V, F = _quietly(nibabel.read_geometry, str(path))
    polygons = Polygons.of_triangles(np.asarray(F, dtype=np.int64))
    return _checked(np.asarray(V, dtype=np.float64), polygons, Extras(units="millimeter"))


def parse_vtp(path: Path) -> Parsed:
    """The polygons of a VTK file."""
    pyvista = _needed("pyvista")
    path.open("rb").close()
    mesh = _quietly(pyvista.read, str(path))
    if not isinstance(mesh, pyvista.PolyData):
        raise Damaged(f"it holds a {type(mesh).__name__}, no polygons")
    if mesh.n_strips:
        mesh = mesh.triangulate()
    if mesh.n_points == 0 or mesh.GetNumberOfPolys() == 0:
        raise Damaged("it has no polygons")
    cells = mesh.GetPolys()
    offsets = np.asarray(pyvista.convert_array(cells.GetOffsetsArray()), dtype=np.int64)
    corners = np.asarray(pyvista.convert_array(cells.GetConnectivityArray()), dtype=np.int64)
    polygons = polygons_of(Column(corners, np.diff(offsets)))
    if (polygons.sizes < 3).any():
        raise Damaged("it has polygons of less than three corners")
    extras = Extras(source=mesh)
    TC = mesh.active_texture_coordinates
    parsed = _checked(np.asarray(mesh.points, dtype=np.float64), polygons, extras)
    if TC is None:
        return parsed
    map_, same = np.unique(np.asarray(TC, dtype=np.float64)[:, :2], axis=0, return_inverse=True)
    return parsed._replace(TC=map_, texture=same.ravel().astype(np.int64)[polygons.corners])


def _checked(V: np.ndarray, polygons: Polygons, extras: Extras) -> Parsed:
    bad = polygons.outside(len(V))
    if len(bad):
        raise Damaged(f"faces {bad[0]} and {len(bad) - 1} others name vertices outside 0..{len(V) - 1}")
    return untextured(V, polygons, extras)


def save_vtp(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write polygons with texture coordinates at the points; all arrays that were read stay."""
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    pyvista = _needed("pyvista")
    made = one_index(mesh.polygons.corners, mesh.texture)
    rows, source = made.rows[0], mesh.extras.source
    faces = np.insert(made.corners, mesh.polygons.starts, mesh.polygons.sizes)
    written = pyvista.PolyData(mesh.V[rows], faces)
    if isinstance(source, pyvista.PolyData):
        first = source.n_verts + source.n_lines  # cells of points and lines come before
        for name, values in source.point_data.items():
            written.point_data[name] = np.asarray(values)[rows]
        for name, values in source.cell_data.items():
            written.cell_data[name] = np.asarray(values)[first : first + len(mesh.polygons)]
        for name, values in source.field_data.items():
            written.field_data[name] = values
    elif mesh.extras.colours is not None:
        written.point_data["RGB"] = np.round(np.clip(mesh.extras.colours[rows], 0, 1) * 255).astype(np.uint8)
    written.active_texture_coordinates = mesh.TC[made.rows[1]]
    written.save(temporary)


def save_gifti(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the flat map as a surface, as flat cortices are: u, v, 0.

    Vertices keep their numbers if each has one texture coordinate at most; those without are at the origin.
    """
    assert mesh.TC is not None and mesh.texture is not None  # a caller's mistake
    gifti = _needed("nibabel.gifti")
    made = one_index(mesh.polygons.corners, mesh.texture)
    if len(np.unique(made.rows[0])) == len(made.rows[0]):
        points = np.zeros((len(mesh.V), 3))
        points[made.rows[0], :2] = mesh.TC[made.rows[1]]
        triangles = mesh.split.F
    else:
        points = np.column_stack((mesh.TC[made.rows[1]], np.zeros(len(made.rows[1]))))
        triangles = made.corners[mesh.split.place]
        warnings.warn(
            "vertices are written once for each of their texture coordinates: data of the given vertices "
            "does not fit to the flat surface",
            MeshWarning,
            stacklevel=stack_level(),
        )
    meta = {"GeometricType": "Flat"}
    source = mesh.extras.source
    if hasattr(source, "get_arrays_from_intent"):
        given = dict(source.get_arrays_from_intent(POINTS)[0].meta)
        meta = {**{key: given[key] for key in given if key.startswith("Anatomical")}, **meta}
    arrays = [
        gifti.GiftiDataArray(points.astype(np.float32), intent=POINTS, meta=gifti.GiftiMetaData(meta)),
        gifti.GiftiDataArray(triangles.astype(np.int32), intent=TRIANGLES),
    ]
    image = gifti.GiftiImage(darrays=arrays)
    Path(temporary).write_bytes(image.to_bytes())
