"""Read the vertices of an object, at its scale and with its modifiers."""

from __future__ import annotations

import bpy
import numpy as np

from .objects import CannotUnwrapError

INDEX = "linabf_vertex"  # name of a temporary attribute with the index of each vertex


def read_positions(
    obj: bpy.types.Object, frame: np.ndarray, context: bpy.types.Context, modifiers: bool, mirrored_axis: int
) -> np.ndarray:
    """Return the vertices of an object at its scale: in world space, up to a rigid motion or a reflection.

    Parameters
    ----------
    obj : the object
    frame : (3, 3) float64, the linear part of its transform
    context : the context
    modifiers : whether the modifiers move the vertices
    mirrored_axis : the axis along which a mirrored object is reflected; its faces keep their orientation, as
        in the Unwrap operator of Blender

    Returns
    -------
    V : (#V, 3) float64
    """
    co = _read_modified_positions(obj, context) if modifiers else read(obj.data.vertices, "co", np.float32, 3)
    V = co.reshape(-1, 3).astype(np.float64) @ frame.T
    if np.linalg.det(frame) < 0:
        V[:, mirrored_axis] *= -1
    return V


def _read_modified_positions(obj: bpy.types.Object, context: bpy.types.Context) -> np.ndarray:
    """Return the positions of the mesh's vertices after all modifiers.

    Subdivision Surface, Mirror, Array and Solidify append vertices to the vertices of the mesh. An
    attribute that Blender passes through the modifiers shows whether the first vertices are still the same.
    """
    mesh, n = obj.data, len(obj.data.vertices)
    attribute = mesh.attributes.new(INDEX, "INT", "POINT")
    name = attribute.name  # Blender may append a number to the name
    try:
        attribute.data.foreach_set("value", np.arange(n, dtype=np.int32))
        mesh.update()
        evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
        result = evaluated.to_mesh()
        index = result.attributes.get(name)
        kept = index is not None and np.array_equal(read(index.data, "value", np.int32)[:n], np.arange(n))
        co = read(result.vertices, "co", np.float32, 3)[: 3 * n]
        evaluated.to_mesh_clear()
    finally:
        mesh.attributes.remove(mesh.attributes[name])
    if not kept:
        names = ", ".join(modifier.name for modifier in obj.modifiers if modifier.show_viewport)
        raise CannotUnwrapError(
            f"{obj.name}: its modifiers ({names}) remove or reorder vertices: apply or hide those that do, "
            "or switch Use Modifiers off",
            mesh,
        )
    return co


def read(collection: bpy.types.bpy_prop_collection, name: str, kind: type, width: int = 1) -> np.ndarray:
    """Return an attribute of all elements of a Blender collection as an array."""
    values = np.empty(len(collection) * width, dtype=kind)
    collection.foreach_get(name, values)
    return values
