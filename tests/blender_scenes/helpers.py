"""Helpers for the tests in Blender: objects, their texture coordinates, and their seams."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np


def set_scene(*objects: bpy.types.Object, edit: bool = False) -> None:
    """Make a scene of the given objects, select them, and make the first one active."""
    for obj in list(bpy.context.scene.collection.objects):
        if obj not in objects:
            bpy.data.objects.remove(obj)
    for obj in objects:
        if obj.name not in bpy.context.scene.collection.objects:
            bpy.context.scene.collection.objects.link(obj)
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]
    if edit:
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")


def new_object(name: str, V: object, F: object) -> bpy.types.Object:
    data = bpy.data.meshes.new(name)
    data.from_pydata(np.asarray(V).tolist(), [], [list(row) for row in F])
    return bpy.data.objects.new(name, data)


def monkey() -> bpy.types.Object:
    """Return Suzanne: 500 triangles and quadrangles in three pieces."""
    bpy.ops.mesh.primitive_monkey_add()
    return bpy.context.active_object


def prism(sides: int = 6) -> bpy.types.Object:
    """Return a closed prism with an n-gon at each end."""
    turn = np.arange(sides) * 2 * np.pi / sides
    ring = np.column_stack((np.cos(turn), np.sin(turn)))
    V = np.vstack([np.column_stack((ring, np.full(sides, z))) for z in (0.0, 2.0)])
    quads = [[i, (i + 1) % sides, sides + (i + 1) % sides, sides + i] for i in range(sides)]
    return new_object("prism", V, [list(range(sides))[::-1], list(range(sides, 2 * sides)), *quads])


def uv_of(obj: bpy.types.Object, layer: str | None = None) -> np.ndarray:
    return mesh_uv(obj.data, layer)


def mesh_uv(mesh: bpy.types.Mesh, layer: str | None = None) -> np.ndarray:
    uv_layer = mesh.uv_layers[layer] if layer else mesh.uv_layers.active
    values = np.empty(2 * len(mesh.loops), dtype=np.float32)
    uv_layer.uv.foreach_get("vector", values)
    return values.reshape(-1, 2).astype(float)


def polygon_areas(obj: bpy.types.Object | None = None, mesh: bpy.types.Mesh | None = None) -> np.ndarray:
    """Return the signed areas of the faces in the map."""
    mesh = obj.data if mesh is None else mesh
    uv, areas = mesh_uv(mesh), []
    for face in mesh.polygons:
        x, y = uv[face.loop_start : face.loop_start + face.loop_total].T
        areas.append((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)
    return np.array(areas)


def cut_edges(obj: bpy.types.Object) -> set[int]:
    """Return the edges whose two faces have different texture coordinates."""
    uv, ends = uv_of(obj), {}
    for face in obj.data.polygons:
        for k, loop in enumerate(face.loop_indices):
            following = face.loop_indices[(k + 1) % face.loop_total]
            at = {obj.data.loops[i].vertex_index: tuple(uv[i]) for i in (loop, following)}
            ends.setdefault(obj.data.loops[loop].edge_index, []).append(at)
    return {edge for edge, sides in ends.items() if any(side != sides[0] for side in sides)}


def grid(n: int, bump: float = 0.0) -> bpy.types.Object:
    """Return a square of n x n quadrangles with a bump."""
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    x, y = (2 * k.ravel() / n - 1 for k in (i, j))
    V = np.column_stack((x, y, bump * np.exp(-4 * (x**2 + y**2))))
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    F = np.stack((at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]), axis=-1).reshape(-1, 4)
    return new_object("grid", V, F)


def select_only(obj: bpy.types.Object, chosen: np.ndarray) -> None:
    """Enter edit mode, and select only the given faces."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.polygons.foreach_set("select", chosen)
    bpy.ops.object.mode_set(mode="EDIT")


def pin(obj: bpy.types.Object, loops: np.ndarray, uv: np.ndarray | None = None) -> None:
    """Pin the texture coordinates of the given corners, after moving them to `uv` if given."""
    layer = obj.data.uv_layers.active or obj.data.uv_layers.new(name="UVMap")
    layer.pin_ensure()
    pins = np.zeros(len(obj.data.loops), dtype=bool)
    pins[loops] = True
    layer.pin.foreach_set("value", pins)
    if uv is not None:
        values = uv_of(obj)
        values[loops] = uv
        layer.uv.foreach_set("vector", values.astype(np.float32).ravel())


def covered_shape(obj: bpy.types.Object) -> Any:
    """Return the union of the faces in the map, as a Shapely geometry."""
    import shapely

    uv = uv_of(obj)
    faces = [uv[face.loop_start : face.loop_start + face.loop_total] for face in obj.data.polygons]
    return shapely.union_all([shapely.Polygon(corners).buffer(0) for corners in faces])


def seams_of(obj: bpy.types.Object) -> set[int]:
    return {edge.index for edge in obj.data.edges if edge.use_seam}


def unwrap(**settings: object) -> set[str]:
    return bpy.ops.uv.linabf_unwrap(**settings)


def assert_refused(text: str, **settings: object) -> None:
    """Assert that the operator fails with an error that contains the given text."""
    try:
        unwrap(**settings)
    except RuntimeError as error:
        assert text in str(error), str(error)
        return
    raise AssertionError(f"not refused: {text}")
