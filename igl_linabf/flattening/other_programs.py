"""Maps by Blender (`bpy`) and MeshLab (`pymeshlab`), if these programs are installed.

Each program runs in a separate process, because the libraries of both programs conflict.
"""

from collections.abc import Callable
from importlib.util import find_spec
from time import perf_counter

import numpy as np

from .._runtime import Arrays, run_as_child_process, run_in_child_process
from .._types import FloatArray, IntArray

PATIENCE = 3_600.0  # seconds after which a program counts as hanging


def _flatten_by_blender(mesh: Arrays) -> Arrays:
    import bpy

    V, F = mesh["V"], mesh["F"]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(V.tolist(), [], F.tolist())
    thing = bpy.data.objects.new("mesh", data)
    bpy.context.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    start = perf_counter()
    bpy.ops.uv.unwrap(method="ANGLE_BASED", fill_holes=False, correct_aspect=False, margin=0.0)
    seconds = perf_counter() - start
    bpy.ops.object.mode_set(mode="OBJECT")
    corners = np.zeros(2 * len(data.loops))
    data.uv_layers.active.uv.foreach_get("vector", corners)
    vertex = np.zeros(len(data.loops), dtype=np.int64)
    data.loops.foreach_get("vertex_index", vertex)
    uv = np.zeros((len(V), 2))
    uv[vertex] = corners.reshape(-1, 2)
    return {"uv": uv, "seconds": np.array(seconds)}


def _flatten_by_meshlab(mesh: Arrays) -> Arrays:
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(mesh["V"], mesh["F"].astype(np.int32)))
    start = perf_counter()
    meshes.compute_texcoord_parametrization_least_squares_conformal_maps()
    seconds = perf_counter() - start
    uv = np.array(meshes.current_mesh().vertex_tex_coord_matrix())
    return {"uv": uv, "seconds": np.array(seconds)}


PEERS: dict[str, tuple[str, Callable[[Arrays], Arrays]]] = {
    "Blender ABF": ("bpy", _flatten_by_blender),
    "MeshLab LSCM": ("pymeshlab", _flatten_by_meshlab),
}


def list_installed_programs() -> list[str]:
    """Return the names of the programs whose package is installed."""
    return [name for name, (package, _) in PEERS.items() if find_spec(package) is not None]


def run_program(name: str, V: FloatArray, F: IntArray) -> tuple[FloatArray, float]:
    """Run an external program; return its map, (#V, 2), and its running time in seconds.

    Raises
    ------
    RuntimeError
        The program failed (the message contains its last line of output), or hangs.
    """
    arrays = {"V": V, "F": F}
    result = run_in_child_process("igl_linabf.flattening.other_programs", name, arrays, PATIENCE)
    return result["uv"], float(result["seconds"])


if __name__ == "__main__":
    run_as_child_process({name: flatten for name, (_, flatten) in PEERS.items()})
