"""Meshes of other libraries keep their triangles, and their corners get the atlas's texture coordinates."""

from __future__ import annotations

import re
from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import load, read_pixels

from igl_linabf import MeshError, MeshWarning, adapters, flatten, unwrap
from igl_linabf.plot import checker_texture

PAGE = Path(__file__).parents[2] / "docs" / "libraries.md"


@pytest.fixture(scope="module")
def unwrapped():
    V, F = load("ant")
    return V, F, unwrap(V, F)


def get_corner_coordinates(library: str, mesh: object) -> np.ndarray:
    """Return the texture coordinates (#F, 3, 2) that a library stores in its mesh."""
    _, F = getattr(adapters, f"from_{library}")(mesh)
    if library == "open3d":
        return np.asarray(mesh.triangle_uvs).reshape(-1, 3, 2)
    rows = {
        "trimesh": lambda: mesh.visual.uv,
        "pyvista": lambda: mesh.active_texture_coordinates,
        "meshio": lambda: mesh.point_data["obj:vt"],
    }
    return np.asarray(rows[library]())[F]


@pytest.mark.parametrize("library", ["trimesh", "pyvista", "meshio", "open3d"])
def test_a_round_trip_preserves_positions_and_texture_coordinates(library: str, unwrapped) -> None:
    pytest.importorskip(library)
    V, F, atlas = unwrapped
    to, back = getattr(adapters, f"to_{library}"), getattr(adapters, f"from_{library}")
    mesh = to(V, F, atlas.TC, atlas.FTC)
    W, G = back(mesh)
    assert W.dtype == np.float64
    assert G.dtype == np.int64
    assert np.array_equal(W[G], V[F])
    assert np.allclose(get_corner_coordinates(library, mesh), atlas.TC[atlas.FTC], rtol=0, atol=1e-7)


@pytest.mark.parametrize("library", ["trimesh", "pyvista", "meshio", "open3d"])
def test_a_disk_map_duplicates_no_vertices(library: str) -> None:
    pytest.importorskip(library)
    V, F = load("bumps")
    result = flatten(V, F)
    W, G = getattr(adapters, f"from_{library}")(getattr(adapters, f"to_{library}")(V, F, result.uv))
    assert np.array_equal(W, V)
    assert np.array_equal(G, F)


@pytest.mark.parametrize("library", ["trimesh", "pyvista", "meshio", "open3d"])
def test_coincident_vertices_are_not_merged(library: str) -> None:
    """Two identical copies of a disk, in space and in the map, stay separate."""
    pytest.importorskip(library)
    V, F = load("bumps")
    uv = np.tile(flatten(V, F).uv, (2, 1))
    V, F = np.tile(V, (2, 1)), np.vstack([F, F + len(V)])
    W, G = getattr(adapters, f"from_{library}")(getattr(adapters, f"to_{library}")(V, F, uv))
    assert np.array_equal(W, V)
    assert np.array_equal(G, F)


def make_shades(count: int, columns: int = 4) -> np.ndarray:
    return np.random.default_rng(count).integers(0, 256, (count, columns), dtype=np.uint8)


def test_trimesh_colours_and_attributes_are_copied(tmp_path, unwrapped) -> None:
    trimesh = pytest.importorskip("trimesh")
    V, F, atlas = unwrapped
    maps = atlas.TC, atlas.FTC
    vertex = adapters.vertex_map(V, F, *maps)
    given = trimesh.Trimesh(V, F, vertex_colors=make_shades(len(V)), process=False, metadata={"scan": 7})
    given.vertex_attributes["height"], given.face_attributes["label"] = V[:, 2], np.arange(len(F))
    mesh = adapters.to_trimesh(V, F, *maps, like=given)
    assert (np.asarray(mesh.vertices) == V[vertex]).all()
    assert (mesh.vertex_attributes["height"] == V[vertex, 2]).all()
    assert (mesh.face_attributes["label"] == np.arange(len(F))).all()
    assert mesh.metadata["scan"] == 7
    mesh.export(tmp_path / "ant.glb")
    (read,) = trimesh.load(tmp_path / "ant.glb", process=False).geometry.values()
    assert (
        np.asarray(read.visual.vertex_attributes["color"])[:, :3] == make_shades(len(V))[vertex, :3]
    ).all()
    of_faces = trimesh.Trimesh(V, F, face_colors=make_shades(len(F)), process=False)
    again = adapters.to_trimesh(V, F, *maps, like=of_faces)
    assert (again.face_attributes["color"] == make_shades(len(F))).all()
    with pytest.raises(MeshError, match=r"like has .* pass the mesh that they come from"):
        adapters.to_trimesh(V, F, *maps, like=trimesh.creation.box())
    W, G = adapters.from_trimesh(mesh)
    second = adapters.vertex_map(W, G, mesh.visual.uv)
    twice = adapters.to_trimesh(W, G, mesh.visual.uv, like=mesh)
    assert (twice.visual.vertex_attributes["color"] == make_shades(len(V))[vertex][second]).all()


def test_trimesh_normals_and_materials_are_copied(unwrapped) -> None:
    trimesh = pytest.importorskip("trimesh")
    from PIL import Image

    V, F, atlas = unwrapped
    vertex = adapters.vertex_map(V, F, atlas.TC, atlas.FTC)
    normals = V / np.linalg.norm(V, axis=1, keepdims=True)
    look = {
        "name": "gold",
        "baseColorFactor": [200, 150, 20, 255],
        "metallicFactor": 0.9,
        "doubleSided": True,
    }
    material = trimesh.visual.material.PBRMaterial(**look, baseColorTexture=Image.new("RGB", (2, 2)))
    visual = trimesh.visual.TextureVisuals(uv=V[:, :2], material=material)
    given = trimesh.Trimesh(V, F, vertex_normals=normals, visual=visual, process=False)
    with pytest.warns(MeshWarning, match="like has 1 image for its old texture coordinates"):
        mesh = adapters.to_trimesh(V, F, atlas.TC, atlas.FTC, like=given)
    assert np.array_equal(mesh.vertex_normals, normals[vertex])
    kept = mesh.visual.material
    assert (kept.name, kept.metallicFactor, kept.doubleSided) == ("gold", 0.9, True)
    assert list(kept.baseColorFactor) == look["baseColorFactor"] and kept.baseColorTexture is None
    assert material.baseColorTexture is not None
    same = adapters.to_trimesh(V, F, V[:, :2], like=given)
    assert same.visual.material.baseColorTexture is not None
    several = trimesh.visual.material.MultiMaterial([kept, kept])
    given.visual = trimesh.visual.TextureVisuals(uv=V[:, :2], material=several, face_materials=[1] * len(F))
    again = adapters.to_trimesh(V, F, atlas.TC, atlas.FTC, like=given).visual
    assert [look.name for look in again.material] == ["gold", "gold"] and set(again.face_materials) == {1}
    plain = adapters.to_trimesh(V, F, atlas.TC, atlas.FTC, like=trimesh.Trimesh(V, F, process=False))
    at_corners = plain.vertex_normals[plain.faces]
    assert np.allclose(at_corners, trimesh.Trimesh(V, F, process=False).vertex_normals[F])  # no visible seam


def test_pyvista_arrays_are_copied_except_for_old_texture_coordinates() -> None:
    pyvista = pytest.importorskip("pyvista")
    given = pyvista.Cylinder(resolution=12).triangulate().clean()
    given.point_data["colours"] = make_shades(given.n_points, 3)
    given.cell_data["label"] = np.arange(given.n_cells)
    given.field_data["scan"] = [7]
    given.point_data["old uv"] = np.zeros((given.n_points, 2))
    given.GetPointData().SetActiveAttribute("old uv", 3)
    given.set_active_scalars("colours")
    V, F = adapters.from_pyvista(given)
    atlas = unwrap(V, F)
    mesh = adapters.to_pyvista(V, F, atlas.TC, atlas.FTC, like=given)
    vertex = adapters.vertex_map(V, F, atlas.TC, atlas.FTC)
    assert (mesh.point_data["colours"] == make_shades(given.n_points, 3)[vertex]).all()
    assert (mesh.cell_data["label"] == np.arange(given.n_cells)).all()
    assert list(mesh.field_data["scan"]) == [7]
    assert mesh.point_data.active_scalars_name == "colours"
    assert "old uv" not in mesh.point_data
    assert np.allclose(get_corner_coordinates("pyvista", mesh), atlas.TC[atlas.FTC], atol=1e-7)


def test_meshio_data_are_copied() -> None:
    meshio = pytest.importorskip("meshio")
    V, F = igl.icosahedron()
    blocks = [("triangle", F[:8]), ("line", [[0, 1]]), ("line3", [[0, 1, 2]]), ("triangle", F[8:])]
    given = meshio.Mesh(
        V,
        blocks,
        {"height": V[:, 2], "obj:vt": V[:, :2]},
        {"label": [np.arange(8), [99], [98], np.arange(8, 20)]},
        {"scan": np.array([7])},
        point_sets={"tip": np.array([3])},
        cell_sets={"patch": [np.array([1]), None, None, np.array([0, 2])]},
    )
    assert (adapters.from_meshio(given)[1] == F).all()
    atlas = unwrap(V, F)
    mesh = adapters.to_meshio(V, F, atlas.TC, atlas.FTC, like=given)
    vertex = adapters.vertex_map(V, F, atlas.TC, atlas.FTC)
    assert (mesh.point_data["height"] == V[vertex, 2]).all()
    assert (mesh.cell_data["label"][0] == np.arange(20)).all()
    assert set(vertex[mesh.point_sets["tip"]].tolist()) == {3} and (vertex == 3).sum() == len(
        mesh.point_sets["tip"]
    )
    assert mesh.cell_sets["patch"][0].tolist() == [1, 8, 10]
    assert mesh.field_data == {"scan": np.array([7])}
    assert np.allclose(get_corner_coordinates("meshio", mesh), atlas.TC[atlas.FTC])


def test_open3d_colours_and_normals_are_copied(unwrapped) -> None:
    open3d = pytest.importorskip("open3d")
    V, F, atlas = unwrapped
    given = adapters.to_open3d(V, F, atlas.TC, atlas.FTC)
    given.vertex_colors = open3d.utility.Vector3dVector(make_shades(len(V), 3) / 255)
    given.compute_vertex_normals()
    given.triangle_material_ids = open3d.utility.IntVector(np.arange(len(F), dtype=np.int32) % 3)
    mesh = adapters.to_open3d(V, F, atlas.TC, atlas.FTC, like=given)
    for name in ("vertex_colors", "vertex_normals", "triangle_normals", "triangle_material_ids"):
        assert np.allclose(getattr(mesh, name), getattr(given, name))
        assert len(getattr(mesh, name))


@pytest.mark.parametrize("library", ["trimesh", "pyvista", "meshio", "open3d"])
def test_like_must_have_the_same_size(library: str) -> None:
    pytest.importorskip(library)
    V, F = igl.icosahedron()
    other = getattr(adapters, f"to_{library}")(V[:8], [[0, 1, 2], [5, 6, 7]], V[:8, :2])
    with pytest.raises(MeshError, match=r"like has 6 vertices and 2 triangles, V and F have 12 and 20"):
        getattr(adapters, f"to_{library}")(V, F, V[:, :2], like=other)


def test_trimesh_and_meshio_write_the_texture_coordinates(tmp_path, unwrapped) -> None:
    trimesh, meshio = pytest.importorskip("trimesh"), pytest.importorskip("meshio")
    V, F, atlas = unwrapped
    adapters.to_trimesh(V, F, atlas.TC, atlas.FTC).export(tmp_path / "ant.glb")
    (read,) = trimesh.load(tmp_path / "ant.glb", process=False).geometry.values()
    assert np.allclose(read.visual.uv[read.faces], atlas.TC[atlas.FTC], atol=1e-6)
    meshio.write(tmp_path / "ant.obj", adapters.to_meshio(V, F, atlas.TC, atlas.FTC))
    read = meshio.read(tmp_path / "ant.obj")
    assert np.allclose(get_corner_coordinates("meshio", read), atlas.TC[atlas.FTC], atol=1e-6)


def test_pyvista_draws_the_texture(tmp_path) -> None:
    pyvista = pytest.importorskip("pyvista")
    V, F = load("bumps")
    mesh = adapters.to_pyvista(V, F, flatten(V, F).uv * 3)
    plotter = pyvista.Plotter(off_screen=True, lighting="none")
    plotter.add_mesh(mesh, texture=checker_texture())
    plotter.view_xy()
    plotter.screenshot(tmp_path / "checks.png")
    plotter.close()
    picture = read_pixels(tmp_path / "checks.png")
    inside = picture[250:500, 350:650, :3].astype(int).sum(axis=2)
    assert len(np.unique(inside // 100)) > 1  # the texture has two colours
    assert 0.2 < np.mean(inside > np.median(np.unique(inside))) < 0.8


def test_polygons_and_planar_points_are_converted() -> None:
    pyvista, meshio = pytest.importorskip("pyvista"), pytest.importorskip("meshio")
    V, F = adapters.from_pyvista(pyvista.Cylinder(resolution=12))
    assert np.isclose(igl.doublearea(V, F).sum() / 2, pyvista.Cylinder(resolution=12).area)
    V, F = adapters.from_meshio(
        meshio.Mesh([[0, 0], [1, 0], [0, 1]], [("line", [[0, 1]]), ("triangle", [[0, 1, 2]])])
    )
    assert V.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert F.tolist() == [[0, 1, 2]]


def test_other_objects_are_refused_with_a_remedy() -> None:
    trimesh, pyvista = pytest.importorskip("trimesh"), pytest.importorskip("pyvista")
    meshio = pytest.importorskip("meshio")
    with pytest.raises(MeshError, match=r"scene\.to_mesh"):
        adapters.from_trimesh(trimesh.Scene())
    with pytest.raises(MeshError, match="extract_surface"):
        adapters.from_pyvista(pyvista.ImageData(dimensions=(2, 2, 2)))
    with pytest.raises(MeshError, match="1 cells 'tetra'"):
        adapters.from_meshio(meshio.Mesh(np.eye(4, 3), [("tetra", [[0, 1, 2, 3]])]))
    with pytest.raises(MeshError, match=r"to_legacy"):
        adapters.from_open3d(object())
    V, F = load("bumps")
    for library in ("trimesh", "pyvista", "meshio"):
        with pytest.raises(MeshError, match="NaN or infinite"):
            getattr(adapters, f"to_{library}")(V, F, np.full((len(V), 2), np.nan))


def test_tensors_keep_device_and_dtype_but_no_gradient() -> None:
    torch = pytest.importorskip("torch")
    V, F = load("bumps")
    vertices = torch.tensor(V, dtype=torch.float32, requires_grad=True)
    faces = torch.tensor(F, dtype=torch.int32)
    W, G = adapters.from_torch(vertices, faces)
    assert np.array_equal(W, V.astype(np.float32))
    assert np.array_equal(G, F)
    result = flatten(W, G)
    uv, uv_idx = adapters.to_torch(vertices, faces, result.uv)
    assert (uv.dtype, uv.device, uv.requires_grad) == (torch.float32, vertices.device, False)
    assert uv_idx.dtype == torch.int32
    assert np.allclose(uv.numpy(), result.uv, atol=1e-6)


@pytest.mark.parametrize("library", ["open3d", "torch"])
def test_the_examples_of_the_page_run(library: str) -> None:
    pytest.importorskip(library)  # the examples of trimesh, pyvista and meshio are doctests
    (code,) = (
        block
        for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
        if block.startswith(f"import {library}")
    )
    V, F = igl.icosahedron()
    names = {"V": V, "F": F, "adapters": adapters, "checks": np.zeros((8, 8, 3), dtype=np.uint8)}
    exec("import igl_linabf\n" + code, names)
    assert len(names["atlas"].TC)


def test_triangles_get_the_data_of_their_strip() -> None:
    pyvista = pytest.importorskip("pyvista")
    points = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [5, 0, 0], [5, 1, 0], [6, 0, 0.0]])
    like = pyvista.PolyData(points, strips=[4, 0, 1, 2, 3, 3, 4, 5, 6])
    like.cell_data["label"] = [7, 9]
    V, F = adapters.from_pyvista(like)
    made = adapters.to_pyvista(V, F, V[:, :2], like=like)
    assert made.cell_data["label"].tolist() == [7, 7, 9]
