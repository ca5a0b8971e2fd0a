"""Blender's meshes as arrays, and the atlas back into them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np


class CannotUnwrapError(Exception):
    """What is wrong, in a sentence; `mesh` and `faces` are to be selected, if there are any."""

    def __init__(self, text: str, mesh: bpy.types.Mesh | None = None, faces: Sequence[int] = ()) -> None:
        super().__init__(text)
        self.mesh, self.faces = mesh, faces


@dataclass(frozen=True)
class Part:
    """The faces of one object that are to be unwrapped.

    Attributes
    ----------
    thing : the object
    V : (#V, 3) float64, all its vertices at the object's scale
    polygons : (#f,) int64, the faces
    loops : (#l,) int64, their corners, face after face
    sizes : (#f,) int64, the number of corners of each
    F : list of lists, the vertices of each
    seams : (#E, 2) int64, the marked edges
    """

    thing: bpy.types.Object
    V: np.ndarray
    polygons: np.ndarray
    loops: np.ndarray
    sizes: np.ndarray
    F: list[list[int]]
    seams: np.ndarray


def part_of(thing: bpy.types.Object, selected: bool, modifiers: bpy.types.Depsgraph | None) -> Part | None:
    """The faces of an object, all or the selected ones; None where there are none."""
    mesh = thing.data
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
    V = _positions(thing, modifiers)
    bad = ~np.isfinite(V).all(axis=1)[vertices]
    if bad.any():
        faces = polygons[np.unique(np.repeat(np.arange(len(sizes)), sizes)[bad])]
        raise CannotUnwrapError(
            f"{thing.name}: {len(faces)} faces have a vertex at no place (NaN or infinite); they are "
            "selected: move or remove it",
            mesh,
            faces.tolist(),
        )
    edges = _read(mesh.edges, "vertices", np.int32, 2).reshape(-1, 2).astype(np.int64)
    F = [row.tolist() for row in np.split(vertices, begin[1:])]
    return Part(thing, V, polygons, loops, sizes, F, edges[_read(mesh.edges, "use_seam", bool)])


def write_uv(part: Part, uv: np.ndarray, second: bool = False) -> None:
    """Put texture coordinates into the active UV layer, or the second one; it is made where there is none."""
    mesh = part.thing.data
    layer = mesh.uv_layers.active or mesh.uv_layers.new(name="UVMap")
    if second and layer is not None:
        layer = mesh.uv_layers[1] if len(mesh.uv_layers) > 1 else mesh.uv_layers.new(name="Lightmap")
    if layer is None:
        raise CannotUnwrapError(
            f"{part.thing.name} has as many UV layers as Blender allows: remove one", mesh
        )
    values = _read(layer.data, "uv", np.float32, 2).reshape(-1, 2)
    values[part.loops] = uv
    layer.data.foreach_set("uv", values.ravel())  # by `layer.uv` the undo's copy would change, too
    mesh.update()


def mark_seams(part: Part, seams: np.ndarray, keep: bool) -> None:
    """Mark edges as seams; those between the unwrapped faces that are none are unmarked, unless kept."""
    mesh, n = part.thing.data, len(part.V)
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
    """Select these faces, and no others of the mesh."""
    chosen = np.zeros(len(mesh.polygons), dtype=bool)
    chosen[list(faces)] = True
    starts, sizes = (_read(mesh.polygons, name, np.int32)[chosen] for name in ("loop_start", "loop_total"))
    loops = np.concatenate(
        [np.arange(a, a + size) for a, size in zip(starts, sizes, strict=True)] or [np.empty(0, int)]
    )
    for domain, of, name in (("vert", mesh.vertices, "vertex_index"), ("edge", mesh.edges, "edge_index")):
        picked = np.zeros(len(of), dtype=bool)
        picked[_read(mesh.loops, name, np.int32)[loops]] = True
        _select(mesh, domain, picked)
    _select(mesh, "poly", chosen)
    mesh.update()


def _select(mesh: bpy.types.Mesh, domain: str, chosen: np.ndarray) -> None:
    """By the attribute behind `select`, which Blender 5.0's `from_pydata` makes of a wrong type for edges."""
    name = f".select_{domain}"
    held = mesh.attributes.get(name)
    if held is not None and held.data_type != "BOOLEAN":
        mesh.attributes.remove(held)
        held = None
    kind = {"vert": "POINT", "edge": "EDGE", "poly": "FACE"}[domain]
    held = held or mesh.attributes.new(name, "BOOLEAN", kind)
    held.data.foreach_set("value", chosen)


def _positions(thing: bpy.types.Object, modifiers: bpy.types.Depsgraph | None) -> np.ndarray:
    """The vertices as they are in the world, up to rotation: an object's scale stretches its texture.

    A mirrored object keeps the orientation of its faces, as Blender's own unwrap does.
    """
    n = len(thing.data.vertices)
    if modifiers is None:
        co = _read(thing.data.vertices, "co", np.float32, 3)
    else:
        evaluated = thing.evaluated_get(modifiers)
        made = evaluated.to_mesh()
        try:
            if len(made.vertices) != n:
                raise CannotUnwrapError(
                    f"{thing.name}: its modifiers make {len(made.vertices)} vertices of {n}, and not only "
                    "another shape of its faces: apply them, or switch Use Modifiers off",
                    thing.data,
                )
            co = _read(made.vertices, "co", np.float32, 3)
        finally:
            evaluated.to_mesh_clear()
    linear = np.array(thing.matrix_world.to_3x3(), dtype=np.float64)
    V = co.reshape(-1, 3).astype(np.float64) @ linear.T
    return V * [-1, 1, 1] if np.linalg.det(linear) < 0 else V


def _read(of: bpy.types.bpy_prop_collection, name: str, kind: type, width: int = 1) -> np.ndarray:
    values = np.empty(len(of) * width, dtype=kind)
    of.foreach_get(name, values)
    return values
