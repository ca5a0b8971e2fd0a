"""FreeSurfer's surfaces, by nibabel, and its flat patches, which nibabel does not write."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import MeshError, some
from ..surface import Polygons, topology_of
from .mesh_file import MeshFile
from .one_index import doubled, flat_surface
from .packages import checked, needed, quietly
from .parsing import Extras

PATCH = np.dtype([("vertex", ">i4"), ("place", ">f4", 3)])


def parse_freesurfer(path: Path) -> MeshFile:
    """The surface of a FreeSurfer file, lh.pial for example."""
    V, F = quietly(needed("nibabel.freesurfer").read_geometry, path)
    polygons = Polygons.of_triangles(np.asarray(F, dtype=np.int64))
    return checked(np.asarray(V, dtype=np.float64), polygons, Extras(units="millimeter"))


def save_surf(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write the flat map as a surface."""
    points, triangles = flat_surface(mesh)
    needed("nibabel.freesurfer").write_geometry(temporary, points, triangles, create_stamp="igl_linabf")


def save_patch(temporary: str, mesh: MeshFile, path: Path) -> None:
    """Write a flat patch: the vertices that have a place in the plane, by their numbers on the surface.

    Numbers count from 1, and are negative on the boundary. The triangles are those of the surface.
    """
    made = doubled(mesh)
    vertex, times = np.unique(made.vertex, return_counts=True)
    if (times > 1).any():
        raise MeshError(
            f"vertices {some(vertex[times > 1])} are on seams, and a patch has one place for each: write "
            ".surf or .gii, or flatten a disk"
        )
    used, F = np.unique(mesh.triangles, return_inverse=True)
    loops = topology_of(F.reshape(-1, 3), used).loops
    border = np.isin(made.vertex, used[np.concatenate(loops)] if loops else ())
    rows = np.zeros(len(vertex), dtype=PATCH)
    rows["vertex"] = np.where(border, -1, 1) * (made.vertex + 1)
    rows["place"][:, :2] = made.TC
    head = np.array([-1, len(rows)], dtype=">i4")
    Path(temporary).write_bytes(head.tobytes() + rows.tobytes())
