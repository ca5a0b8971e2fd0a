"""Surfaces of brains, by nibabel: GIFTI and FreeSurfer."""

from pathlib import Path

import numpy as np

from ...surface import Polygons
from ..mesh_file import MeshFile
from ..parsing import Damaged, Extras
from ..vertex_splits import flat_surface
from .optional_packages import call_reader, checked_mesh_file, import_optional

POINTS, TRIANGLES = "NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE"


def parse_gifti(path: Path) -> MeshFile:
    """The surface of a GIFTI file."""
    image = call_reader(import_optional("nibabel").load, path)
    try:
        (points,) = image.get_arrays_from_intent(POINTS)
        (triangles,) = image.get_arrays_from_intent(TRIANGLES)
    except (AttributeError, ValueError):
        raise Damaged("it has not one array of points and one of triangles: is it a .surf.gii?") from None
    V = np.asarray(points.data, dtype=np.float64)
    F = np.asarray(triangles.data)
    if V.ndim != 2 or V.shape[1] != 3 or F.ndim != 2 or F.shape[1] != 3:
        raise Damaged(f"its arrays have the shapes {V.shape} and {F.shape}, not three columns")
    return checked_mesh_file(
        V, Polygons.of_triangles(F.astype(np.int64)), Extras(source=image, units="millimeter")
    )


def save_gifti(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the flat map as a surface, as flat cortices are."""
    gifti = import_optional("nibabel.gifti")
    points, triangles = flat_surface(mesh)
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


def parse_freesurfer(path: Path) -> MeshFile:
    """The surface of a FreeSurfer file, lh.pial for example."""
    V, F = call_reader(import_optional("nibabel.freesurfer").read_geometry, path)
    polygons = Polygons.of_triangles(np.asarray(F, dtype=np.int64))
    return checked_mesh_file(np.asarray(V, dtype=np.float64), polygons, Extras(units="millimeter"))


def save_surf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the flat map as a surface."""
    points, triangles = flat_surface(mesh)
    import_optional("nibabel.freesurfer").write_geometry(
        temporary, points, triangles, create_stamp="igl_linabf"
    )
