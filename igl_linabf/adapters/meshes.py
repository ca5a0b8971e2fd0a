"""Convert meshes of trimesh, pyvista, meshio and Open3D from and to arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .._types import FloatArray, IntArray
from ..errors import MeshError
from ..io import as_mesh_file, copy_polydata_arrays, split_at_seams
from ..surface import face_array
from .data import (
    NON_SURFACE_CELLS,
    check_sizes,
    copy_meshio_sets,
    copy_open3d_data,
    copy_trimesh_data,
    triangulate_polydata,
)

if TYPE_CHECKING:
    import meshio
    import open3d
    import pyvista
    import trimesh


def from_trimesh(mesh: trimesh.Trimesh) -> tuple[FloatArray, IntArray]:
    """Return the vertices and triangles of a `trimesh.Trimesh`.

    Parameters
    ----------
    mesh : trimesh.Trimesh

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        The mesh is not a `Trimesh` but, for example, a scene or a point cloud.

    Examples
    --------
    >>> import trimesh, igl_linabf
    >>> V, F = from_trimesh(trimesh.creation.box())
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> textured = to_trimesh(V, F, atlas.TC, atlas.FTC)
    >>> len(textured.visual.uv) == len(textured.vertices)
    True
    """
    import trimesh

    if not isinstance(mesh, trimesh.Trimesh):
        raise MeshError(
            f"this is a {type(mesh).__name__}, not a trimesh.Trimesh: pass one of scene.geometry.values(), "
            "or scene.to_mesh() for the whole scene"
        )
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)


def to_trimesh(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    *,
    like: trimesh.Trimesh | None = None,
) -> trimesh.Trimesh:
    """Return a `trimesh.Trimesh` with the texture coordinates in `mesh.visual.uv`.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
        Texture coordinates, or a map from `flatten`.
    FTC : (#F, 3) int, optional
        Rows of `TC` at the corners of the faces, such as the `FTC` of an atlas; `F` by default.
    like : trimesh.Trimesh, optional
        The mesh that V and F come from; its vertex normals, materials, colours, attributes and metadata are
        copied. Images of its materials are copied only if the texture coordinates are the same.

    Returns
    -------
    trimesh.Trimesh
        trimesh stores one texture coordinate per vertex, so vertices are duplicated along the seams. The
        faces keep their order.

    Raises
    ------
    MeshError
        The arrays do not match each other or `like`, or are not finite.

    Examples
    --------
    See `from_trimesh`.
    """
    import trimesh

    split = split_at_seams(as_mesh_file(V, face_array(F)).with_texture(TC, FTC))
    visual = trimesh.visual.TextureVisuals(uv=split.TC)
    mesh = trimesh.Trimesh(split.V, split.F, visual=visual, process=False)
    if like is not None:
        check_sizes(V, F, len(like.vertices), len(like.faces))
        copy_trimesh_data(mesh, like, split.vertex)
    return mesh


def from_pyvista(mesh: pyvista.PolyData) -> tuple[FloatArray, IntArray]:
    """Return the vertices and triangles of a `pyvista.PolyData`; polygons are triangulated.

    Parameters
    ----------
    mesh : pyvista.PolyData
        Lines and single points are ignored.

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        The mesh is not a `PolyData` but, for example, a volume grid.

    Examples
    --------
    >>> import pyvista, igl_linabf
    >>> mesh = pyvista.Icosphere(nsub=2)
    >>> V, F = from_pyvista(mesh)
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> textured = to_pyvista(V, F, atlas.TC, atlas.FTC)
    >>> len(textured.active_texture_coordinates) == textured.n_points
    True
    """
    import pyvista

    if not isinstance(mesh, pyvista.PolyData):
        raise MeshError(
            f"this is a {type(mesh).__name__}, not a pyvista.PolyData: pass mesh.extract_surface()"
        )
    faces = triangulate_polydata(mesh)
    F = np.asarray(faces.faces, dtype=np.int64).reshape(-1, 4)[:, 1:]
    return np.array(faces.points, dtype=np.float64), np.ascontiguousarray(F)


def to_pyvista(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    *,
    like: pyvista.PolyData | None = None,
) -> pyvista.PolyData:
    """Return a `pyvista.PolyData` with the texture coordinates in `mesh.active_texture_coordinates`.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
        Texture coordinates, or a map from `flatten`.
    FTC : (#F, 3) int, optional
        Rows of `TC` at the corners of the faces, such as the `FTC` of an atlas; `F` by default.
    like : pyvista.PolyData, optional
        The mesh that V and F come from; its point, cell and field arrays are copied.

    Returns
    -------
    pyvista.PolyData
        VTK stores one texture coordinate per point, so points are duplicated along the seams. The faces keep
        their order. `plotter.add_mesh(mesh, texture=...)` displays the mesh with a texture.

    Raises
    ------
    MeshError
        The arrays do not match each other or `like`, or are not finite.

    Examples
    --------
    See `from_pyvista`.
    """
    import pyvista

    split = split_at_seams(as_mesh_file(V, face_array(F)).with_texture(TC, FTC))
    mesh = pyvista.PolyData.from_regular_faces(split.V, split.F)
    if like is not None:
        triangles = triangulate_polydata(like)
        check_sizes(V, F, triangles.n_points, triangles.GetNumberOfPolys())
        copy_polydata_arrays(mesh, triangles, split.vertex)
    mesh.active_texture_coordinates = split.TC
    return mesh


def from_meshio(mesh: meshio.Mesh) -> tuple[FloatArray, IntArray]:
    """Return the vertices and triangles of a `meshio.Mesh`.

    Parameters
    ----------
    mesh : meshio.Mesh
        Lines and vertex cells are ignored. Two-dimensional points get z = 0.

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64
        The triangles of all blocks, in order.

    Raises
    ------
    MeshError
        The mesh has cells other than triangles.

    Examples
    --------
    >>> import meshio, igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> V, F = from_meshio(meshio.Mesh(V, [("triangle", F)]))
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> textured = to_meshio(V, F, atlas.TC, atlas.FTC)
    >>> textured.point_data["obj:vt"].shape == (len(textured.points), 2)
    True
    """
    surface = [block for block in mesh.cells if block.type not in NON_SURFACE_CELLS]
    others = {block.type: len(block.data) for block in surface if block.type != "triangle"}
    if others:
        listed = ", ".join(f"{count} cells {kind!r}" for kind, count in others.items())
        raise MeshError(f"the mesh has {listed}: pass a surface mesh of triangles only")
    blocks = [np.asarray(block.data, dtype=np.int64) for block in surface]
    V = np.zeros((len(mesh.points), 3))
    V[:, : np.shape(mesh.points)[1]] = mesh.points
    return V, np.concatenate([np.zeros((0, 3), np.int64), *blocks])


def to_meshio(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    *,
    like: meshio.Mesh | None = None,
) -> meshio.Mesh:
    """Return a `meshio.Mesh` with the texture coordinates in `mesh.point_data["obj:vt"]`.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
        Texture coordinates, or a map from `flatten`.
    FTC : (#F, 3) int, optional
        Rows of `TC` at the corners of the faces, such as the `FTC` of an atlas; `F` by default.
    like : meshio.Mesh, optional
        The mesh that V and F come from; its data and sets of points and cells, and the data of fields, are
        copied.

    Returns
    -------
    meshio.Mesh
        Points are duplicated along the seams. meshio's OBJ writer and reader use `"obj:vt"` for `vt` lines.
        The faces keep their order.

    Raises
    ------
    MeshError
        The arrays do not match each other or `like`, or are not finite.

    Examples
    --------
    See `from_meshio`.
    """
    import meshio

    split = split_at_seams(as_mesh_file(V, face_array(F)).with_texture(TC, FTC))
    points, cells, others = {}, {}, {}
    if like is not None:
        surface = [i for i, block in enumerate(like.cells) if block.type not in NON_SURFACE_CELLS]
        check_sizes(V, F, len(like.points), sum(len(like.cells[i].data) for i in surface))
        points = {name: np.asarray(values)[split.vertex] for name, values in like.point_data.items()}
        cells = {
            name: [np.concatenate([values[i] for i in surface])] for name, values in like.cell_data.items()
        }
        point_sets, cell_sets = copy_meshio_sets(like, surface, split.vertex)
        others = {
            "field_data": like.field_data,
            "point_sets": point_sets,
            "cell_sets": cell_sets,
            "info": like.info,
        }
    points["obj:vt"] = split.TC
    return meshio.Mesh(split.V, [("triangle", split.F)], points, cells, **others)


def from_open3d(mesh: open3d.geometry.TriangleMesh) -> tuple[FloatArray, IntArray]:
    """Return the vertices and triangles of an Open3D mesh, `open3d.geometry.TriangleMesh`.

    Parameters
    ----------
    mesh : open3d.geometry.TriangleMesh
        For a mesh of the tensor API, pass `mesh.to_legacy()`.

    Returns
    -------
    V : (#V, 3) float64
    F : (#F, 3) int64

    Raises
    ------
    MeshError
        The mesh has no `triangles`, or belongs to the tensor API.

    Examples
    --------
    See the documentation page about other libraries.
    """
    if not hasattr(mesh, "triangles") or not hasattr(mesh, "triangle_uvs"):
        raise MeshError(
            f"this is a {type(mesh).__name__}, not an open3d.geometry.TriangleMesh: for a tensor mesh, pass "
            "mesh.to_legacy()"
        )
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.triangles, dtype=np.int64).reshape(-1, 3)


def to_open3d(
    V: ArrayLike,
    F: ArrayLike,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    *,
    like: open3d.geometry.TriangleMesh | None = None,
) -> open3d.geometry.TriangleMesh:
    """Return an Open3D mesh with the texture coordinates in `mesh.triangle_uvs`.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
        Texture coordinates, or a map from `flatten`.
    FTC : (#F, 3) int, optional
        Rows of `TC` at the corners of the faces, such as the `FTC` of an atlas; `F` by default.
    like : open3d.geometry.TriangleMesh, optional
        The mesh that V and F come from; its colours, normals and the materials of its triangles are copied.

    Returns
    -------
    open3d.geometry.TriangleMesh
        A mesh with three texture coordinates per triangle and the material 0, which Open3D needs to draw
        textures. No vertex is duplicated.

    Raises
    ------
    MeshError
        The arrays do not match each other or `like`, or are not finite.

    Examples
    --------
    See the documentation page about other libraries.
    """
    import open3d

    mapped = as_mesh_file(V, face_array(F)).with_texture(TC, FTC)
    assert mapped.TC is not None
    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(mapped.V),
        open3d.utility.Vector3iVector(mapped.triangles.astype(np.int32)),
    )
    mesh.triangle_uvs = open3d.utility.Vector2dVector(mapped.TC[mapped.texture])
    mesh.triangle_material_ids = open3d.utility.IntVector(np.zeros(len(mapped.polygons), dtype=np.int32))
    if like is not None:
        check_sizes(V, F, len(like.vertices), len(like.triangles))
        copy_open3d_data(mesh, like)
    return mesh


def vertex_map(V: ArrayLike, F: ArrayLike, TC: ArrayLike, FTC: ArrayLike | None = None) -> IntArray:
    """Return the row of V for each vertex of the meshes from `to_trimesh`, `to_pyvista` and `to_meshio`.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
    TC : (#TC, 2) float
    FTC : (#F, 3) int, optional
        The arguments of these functions.

    Returns
    -------
    vertex : (#P,) int64
        `values[vertex]` are the values at the vertices of the new mesh for values at the vertices of V.

    Raises
    ------
    MeshError
        The arrays do not match, or are not finite.

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> mesh = to_trimesh(V, F, atlas.TC, atlas.FTC)
    >>> vertex = vertex_map(V, F, atlas.TC, atlas.FTC)
    >>> bool((mesh.vertices == V[vertex]).all())
    True
    """
    return split_at_seams(as_mesh_file(V, face_array(F)).with_texture(TC, FTC)).vertex
