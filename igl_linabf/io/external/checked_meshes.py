"""Check the meshes that optional packages return."""

from ..._types import FloatArray
from ...errors import first_few
from ...surface import Polygons
from ..mesh_file import MeshFile
from ..parsing import Damaged, Extras


def make_checked_mesh_file(V: FloatArray, polygons: Polygons, extras: Extras) -> MeshFile:
    """Return a mesh that another package has read; raise `Damaged` if faces refer to missing vertices."""
    outside = polygons.find_out_of_range(len(V))
    if len(outside):
        raise Damaged(f"faces {first_few(outside)} refer to vertices outside 0..{len(V) - 1}")
    return MeshFile(V, polygons, extras=extras)
