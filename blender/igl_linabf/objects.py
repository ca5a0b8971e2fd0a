"""Choose the objects and their scales, and leave edit mode while their meshes are read and written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np


class CannotUnwrapError(Exception):
    """An error that a user can correct; the faces `faces` of `mesh` are selected to show the place."""

    def __init__(self, text: str, mesh: bpy.types.Mesh | None = None, faces: object = ()) -> None:
        super().__init__(text)
        self.mesh, self.faces = mesh, list(faces)


def choose_objects(context: bpy.types.Context) -> tuple[list[bpy.types.Object], list[str]]:
    """Return the objects to unwrap, each mesh once, and the names of omitted linked objects.

    In edit mode, the edited objects are unwrapped, otherwise the selected objects. The mesh of a linked
    object belongs to another file, so that changes to the mesh would be lost.
    """
    editing = context.mode == "EDIT_MESH"
    objects = context.objects_in_mode_unique_data if editing else context.selected_objects
    meshes = {obj.data: obj for obj in reversed(objects) if obj.type == "MESH"}
    if not meshes:
        raise CannotUnwrapError("no mesh object is selected: select the objects to unwrap")
    linked = [obj.name for mesh, obj in meshes.items() if mesh.library or mesh.override_library]
    return [obj for obj in reversed(meshes.values()) if obj.name not in linked], linked[::-1]


def find_largest_frames(depsgraph: bpy.types.Depsgraph, objects: list[bpy.types.Object]) -> list[np.ndarray]:
    """Return the linear part of the transform of the largest instance of each object's mesh, (3, 3).

    All instances share the texture coordinates. Instances by collections and geometry nodes are included.
    """
    largest: dict[bpy.types.Mesh, tuple[float, np.ndarray]] = {obj.data: (0.0, np.eye(3)) for obj in objects}
    for instance in depsgraph.object_instances:
        mesh = instance.object.original.data
        if mesh in largest:
            frame = np.array(instance.matrix_world.to_3x3(), dtype=np.float64)
            scale = _compute_area_scale(frame)
            if scale > largest[mesh][0]:
                largest[mesh] = scale, frame
    return [largest[obj.data][1] for obj in objects]


def _compute_area_scale(frame: np.ndarray) -> float:
    """Return the area scale of a transform (3, 3): the norm of its scales in the three axis planes."""
    a, b, c = frame.T
    return float(np.linalg.norm([np.cross(a, b), np.cross(b, c), np.cross(c, a)]))


@contextmanager
def object_mode(context: bpy.types.Context) -> Iterator[None]:
    """Leave edit mode during the `with` block, because mesh arrays are accessible in object mode only.

    At the end, only the edited objects return to edit mode; Blender would include all selected objects.
    """
    edited = list(context.objects_in_mode) if context.mode == "EDIT_MESH" else []
    if not edited:
        yield
        return
    selected = list(context.selected_objects)
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        _select_objects(context, edited)
        bpy.ops.object.mode_set(mode="EDIT")
        _select_objects(context, selected)


def _select_objects(context: bpy.types.Context, objects: list[bpy.types.Object]) -> None:
    """Select the given objects, and deselect all other objects."""
    for obj in {*context.selected_objects, *objects}:
        obj.select_set(obj in objects)
