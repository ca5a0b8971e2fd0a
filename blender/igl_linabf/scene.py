"""Convert Blender meshes to arrays, and write texture coordinates, seams and selections back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np

from .objects import CannotUnwrapError
from .shapes import read


@dataclass(frozen=True)
class Part:
    """The faces of one object that are to be unwrapped.

    Attributes
    ----------
    obj : the object
    V : (#V, 3) float64, all vertices of the object, at its scale
    polygons : (#f,) int64, the indices of the faces
    sizes : (#f,) int64, the number of corners of each face
    loops : (#l,) int64, the corners of all faces, in order
    corners : (#l,) int64, the vertex of each corner
    edges : (#l,) int64, the edge from each corner to the next one of its face
    uv : (#l, 2) float32, the texture coordinates before unwrapping
    pinned : (#l,) bool, whether the texture coordinates are pinned
    """

    obj: bpy.types.Object
    V: np.ndarray
    polygons: np.ndarray
    sizes: np.ndarray
    loops: np.ndarray
    corners: np.ndarray
    edges: np.ndarray
    uv: np.ndarray
    pinned: np.ndarray

    @property
    def starts(self) -> np.ndarray:
        """The index of the first corner of each face."""
        return np.cumsum(self.sizes) - self.sizes

    @property
    def next_corners(self) -> np.ndarray:
        """The index of the next corner of the same face, for each corner."""
        following = np.arange(1, len(self.loops) + 1)
        following[self.starts + self.sizes - 1] = self.starts
        return following

    @property
    def seams(self) -> np.ndarray:
        """The vertices of the part's edges that are marked as seams, (#E, 2)."""
        used = np.unique(self.edges)
        marked = used[read(self.obj.data.edges, "use_seam", bool)[used]]
        return read(self.obj.data.edges, "vertices", np.int32, 2).reshape(-1, 2)[marked].astype(np.int64)

    @property
    def materials(self) -> np.ndarray:
        """The material slot of each face."""
        return read(self.obj.data.polygons, "material_index", np.int32)[self.polygons]

    def select(self, chosen: np.ndarray) -> Part:
        """Return the part with only the faces in the mask `chosen`."""
        at = np.repeat(chosen, self.sizes)
        names = "loops", "corners", "edges", "uv", "pinned"
        kept = {name: getattr(self, name)[at] for name in names}
        return replace(self, polygons=self.polygons[chosen], sizes=self.sizes[chosen], **kept)


def read_part(obj: bpy.types.Object, V: np.ndarray, selected: bool, second: bool) -> Part:
    """Return all faces of an object, or the selected faces; `second` reads the second UV layer."""
    mesh = obj.data
    polygons = np.arange(len(mesh.polygons))
    if selected:
        polygons = polygons[read(mesh.polygons, "select", bool) & ~read(mesh.polygons, "hide", bool)]
    sizes = read(mesh.polygons, "loop_total", np.int32)[polygons].astype(np.int64)
    first = read(mesh.polygons, "loop_start", np.int32)[polygons].astype(np.int64)
    loops = np.repeat(first - np.cumsum(sizes) + sizes, sizes) + np.arange(sizes.sum())
    corners = read(mesh.loops, "vertex_index", np.int32)[loops].astype(np.int64)
    edges = read(mesh.loops, "edge_index", np.int32)[loops].astype(np.int64)
    bad = ~np.isfinite(V).all(axis=1)[corners]
    if bad.any():
        faces = polygons[np.unique(np.repeat(np.arange(len(sizes)), sizes)[bad])]
        raise CannotUnwrapError(
            f"{obj.name}: {len(faces)} faces have a vertex without a position (NaN or infinite); they are "
            "selected: move or remove it",
            mesh,
            faces,
        )
    layer = _find_layer(mesh, second)
    uv, pinned = np.zeros((len(loops), 2), dtype=np.float32), np.zeros(len(loops), dtype=bool)
    if layer is not None:
        uv = read(layer.data, "uv", np.float32, 2).reshape(-1, 2)[loops]
        pins = mesh.attributes.get(f".pn.{layer.name}")
        pinned = pinned if pins is None else read(pins.data, "value", bool)[loops]
    return Part(obj, V, polygons, sizes, loops, corners, edges, uv, pinned)


def write_uv(part: Part, uv: np.ndarray, second: bool) -> None:
    """Write texture coordinates to the active or the second UV layer; create the layer if necessary."""
    mesh = part.obj.data
    layer = _find_layer(mesh, second)
    if layer is None:
        if not mesh.uv_layers:
            mesh.uv_layers.new(name="UVMap")
        layer = mesh.uv_layers.new(name="Lightmap") if second else mesh.uv_layers.active
    if layer is None:
        raise CannotUnwrapError(f"{part.obj.name} has as many UV layers as Blender allows: remove one", mesh)
    values = read(layer.data, "uv", np.float32, 2).reshape(-1, 2)
    values[part.loops] = uv
    layer.data.foreach_set("uv", values.ravel())  # `layer.uv` would also change the undo copy
    mesh.update()


def _find_layer(mesh: bpy.types.Mesh, second: bool) -> bpy.types.MeshUVLoopLayer | None:
    """Return the active or the second UV layer, if there is one."""
    if second:
        return mesh.uv_layers[1] if len(mesh.uv_layers) > 1 else None
    return mesh.uv_layers.active


def mark_seams(part: Part, rows: np.ndarray, keep: bool) -> None:
    """Mark the edges along which the map is cut as seams, including edges to faces outside the part.

    Parameters
    ----------
    part : the part
    rows : (#l,) int64, an index of the texture coordinates of each corner
    keep : whether marks of other edges of the part stay
    """
    mesh, edges = part.obj.data, part.edges
    ends = np.column_stack((rows, rows[part.next_corners]))
    backwards = part.corners > part.corners[part.next_corners]
    ends[backwards] = ends[backwards, ::-1]
    of_edge = np.zeros((len(mesh.edges), 2), dtype=np.int64)
    of_edge[edges] = ends  # the rows at both ends of each edge, in one of its faces
    cut = np.zeros(len(mesh.edges), dtype=bool)
    cut[edges[(of_edge[edges] != ends).any(axis=1)]] = True
    n_faces = np.bincount(edges, minlength=len(cut))
    own = n_faces > 0
    cut |= own & (np.bincount(read(mesh.loops, "edge_index", np.int32), minlength=len(cut)) > n_faces)
    marked = read(mesh.edges, "use_seam", bool)
    mesh.edges.foreach_set("use_seam", cut | (marked & (keep | ~own)))
    mesh.update()


def select_faces(mesh: bpy.types.Mesh, faces: object) -> None:
    """Select the given faces of a mesh with their vertices and edges, and deselect everything else."""
    chosen = np.zeros(len(mesh.polygons), dtype=bool)
    chosen[faces] = True
    loops = np.repeat(chosen, read(mesh.polygons, "loop_total", np.int32))  # loops are sorted by face
    for domain, collection, name in (
        ("vert", mesh.vertices, "vertex_index"),
        ("edge", mesh.edges, "edge_index"),
    ):
        picked = np.zeros(len(collection), dtype=bool)
        picked[read(mesh.loops, name, np.int32)[loops]] = True
        _select(mesh, domain, picked)
    _select(mesh, "poly", chosen)
    mesh.update()


def _select(mesh: bpy.types.Mesh, domain: str, chosen: np.ndarray) -> None:
    """Set the attribute that stores a selection; Blender 5.0's `from_pydata` creates it with a wrong type."""
    name = f".select_{domain}"
    attribute = mesh.attributes.get(name)
    if attribute is not None and attribute.data_type != "BOOLEAN":
        mesh.attributes.remove(attribute)
        attribute = None
    kind = {"vert": "POINT", "edge": "EDGE", "poly": "FACE"}[domain]
    attribute = attribute or mesh.attributes.new(name, "BOOLEAN", kind)
    attribute.data.foreach_set("value", chosen)
