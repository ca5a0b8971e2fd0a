"""Convert Blender meshes to arrays, and write the atlas back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np


class CannotUnwrapError(Exception):
    """An error that a user can fix; `faces` of `mesh` are the faces to select."""

    def __init__(self, text: str, mesh: bpy.types.Mesh | None = None, faces: Sequence[int] = ()) -> None:
        super().__init__(text)
        self.mesh, self.faces = mesh, faces


@dataclass(frozen=True)
class Part:
    """The faces of one object that are unwrapped.

    Attributes
    ----------
    obj : the object
    V : (#V, 3) float64, all vertices of the object, at its scale
    polygons : (#f,) int64, the indices of the faces
    loops : (#l,) int64, the corners of all faces, in order
    sizes : (#f,) int64, the number of corners of each face
    F : list of lists, the vertices of each face
    seams : (#E, 2) int64, the marked edges
    """

    obj: bpy.types.Object
    V: np.ndarray
    polygons: np.ndarray
    loops: np.ndarray
    sizes: np.ndarray
    F: list[list[int]]
    seams: np.ndarray


def read_part(obj: bpy.types.Object, selected: bool, modifiers: bpy.types.Depsgraph | None) -> Part | None:
    """Return all faces of an object, or the selected faces; None if there are no faces."""
    mesh = obj.data
    polygons = np.arange(len(mesh.polygons))
    if selected:
        polygons = polygons[_read(mesh.polygons, "select", bool) & ~_read(mesh.polygons, "hide", bool)]
    if not len(polygons):
        return None
    sizes = _read(mesh.polygons, "loop_total", np.int32)[polygons].astype(np.int64)
    starts = _read(mesh.polygons, "loop_start", np.int32)[polygons].astype(np.int64)
    begin = np.cumsum(sizes) - sizes
    loops = np.repeat(starts - begin, sizes) + np.arange(sizes.sum())
    vertices = _read(mesh.loops, "vertex_index", np.int32)[loops].astype(np.int64)
    V = _positions(obj, modifiers)
    bad = ~np.isfinite(V).all(axis=1)[vertices]
    if bad.any():
        faces = polygons[np.unique(np.repeat(np.arange(len(sizes)), sizes)[bad])]
        raise CannotUnwrapError(
            f"{obj.name}: {len(faces)} faces have a vertex at no place (NaN or infinite); they are "
            "selected: move or remove it",
            mesh,
            faces.tolist(),
        )
    edges = _read(mesh.edges, "vertices", np.int32, 2).reshape(-1, 2).astype(np.int64)
    F = [row.tolist() for row in np.split(vertices, begin[1:])]
    return Part(obj, V, polygons, loops, sizes, F, edges[_read(mesh.edges, "use_seam", bool)])


def write_uv(part: Part, uv: np.ndarray, second: bool = False) -> None:
    """Write texture coordinates to the active or the second UV layer; create the layer if necessary."""
    mesh = part.obj.data
    layer = mesh.uv_layers.active or mesh.uv_layers.new(name="UVMap")
    if second and layer is not None:
        layer = mesh.uv_layers[1] if len(mesh.uv_layers) > 1 else mesh.uv_layers.new(name="Lightmap")
    if layer is None:
        raise CannotUnwrapError(f"{part.obj.name} has as many UV layers as Blender allows: remove one", mesh)
    values = _read(layer.data, "uv", np.float32, 2).reshape(-1, 2)
    values[part.loops] = uv
    layer.data.foreach_set("uv", values.ravel())  # `layer.uv` would also change the copy for undo
    mesh.update()


def mark_seams(part: Part, seams: np.ndarray, keep: bool) -> None:
    """Mark edges as seams; unless `keep`, clear the marks of all other edges of the unwrapped faces."""
    mesh, n = part.obj.data, len(part.V)
    ends = np.sort(_read(mesh.edges, "vertices", np.int32, 2).reshape(-1, 2).astype(np.int64), axis=1)
    key, marked = ends[:, 0] * n + ends[:, 1], _read(mesh.edges, "use_seam", bool)
    if not keep:
        corners = np.concatenate([np.column_stack((row, np.roll(row, -1))) for row in part.F])
        corners.sort(axis=1)
        marked &= ~np.isin(key, corners[:, 0] * n + corners[:, 1])
    seams = np.sort(seams, axis=1)
    mesh.edges.foreach_set("use_seam", marked | np.isin(key, seams[:, 0] * n + seams[:, 1]))
    mesh.update()


def select_faces(mesh: bpy.types.Mesh, faces: Sequence[int]) -> None:
    """Select exactly these faces of the mesh."""
    chosen = np.zeros(len(mesh.polygons), dtype=bool)
    chosen[list(faces)] = True
    starts, sizes = (_read(mesh.polygons, name, np.int32)[chosen] for name in ("loop_start", "loop_total"))
    loops = np.concatenate(
        [np.arange(a, a + size) for a, size in zip(starts, sizes, strict=True)] or [np.empty(0, int)]
    )
    for domain, collection, name in (
        ("vert", mesh.vertices, "vertex_index"),
        ("edge", mesh.edges, "edge_index"),
    ):
        picked = np.zeros(len(collection), dtype=bool)
        picked[_read(mesh.loops, name, np.int32)[loops]] = True
        _select(mesh, domain, picked)
    _select(mesh, "poly", chosen)
    mesh.update()


def _select(mesh: bpy.types.Mesh, domain: str, chosen: np.ndarray) -> None:
    """Set the attribute behind `select`; `from_pydata` of Blender 5.0 gives it a wrong type for edges."""
    name = f".select_{domain}"
    attribute = mesh.attributes.get(name)
    if attribute is not None and attribute.data_type != "BOOLEAN":
        mesh.attributes.remove(attribute)
        attribute = None
    kind = {"vert": "POINT", "edge": "EDGE", "poly": "FACE"}[domain]
    attribute = attribute or mesh.attributes.new(name, "BOOLEAN", kind)
    attribute.data.foreach_set("value", chosen)


def _positions(obj: bpy.types.Object, modifiers: bpy.types.Depsgraph | None) -> np.ndarray:
    """Return the vertices in world space up to a rigid motion, because the scale of an object matters.

    A mirrored object keeps the orientation of its faces, as in the Unwrap operator of Blender.
    """
    n = len(obj.data.vertices)
    if modifiers is None:
        co = _read(obj.data.vertices, "co", np.float32, 3)
    else:
        evaluated = obj.evaluated_get(modifiers)
        evaluated_mesh = evaluated.to_mesh()
        try:
            if len(evaluated_mesh.vertices) != n:
                raise CannotUnwrapError(
                    f"{obj.name}: its modifiers make {len(evaluated_mesh.vertices)} vertices of {n}, and not "
                    "only another shape of its faces: apply them, or switch Use Modifiers off",
                    obj.data,
                )
            co = _read(evaluated_mesh.vertices, "co", np.float32, 3)
        finally:
            evaluated.to_mesh_clear()
    linear = np.array(obj.matrix_world.to_3x3(), dtype=np.float64)
    V = co.reshape(-1, 3).astype(np.float64) @ linear.T
    return V * [-1, 1, 1] if np.linalg.det(linear) < 0 else V


def _read(collection: bpy.types.bpy_prop_collection, name: str, kind: type, width: int = 1) -> np.ndarray:
    """Return an attribute of all elements of a collection."""
    values = np.empty(len(collection) * width, dtype=kind)
    collection.foreach_get(name, values)
    return values
