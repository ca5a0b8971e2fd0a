"""Other programs read the written files, and a file is written completely or not at all."""

from __future__ import annotations

import json
import struct
import warnings
from pathlib import Path

import igl
import numpy as np
import pytest

from igl_linabf import MeshError, MeshWarning, unwrap
from igl_linabf.io import read_file, read_texture, write_file, write_image, write_mesh
from igl_linabf.patterns import write_pattern

V, F = igl.icosahedron()
V = V + np.pi
# each corner has its own texture coordinates, except at the edge that the first two faces share
TC = np.vstack((np.random.default_rng(0).random((60, 2)), [np.nan, np.nan]))
FTC = np.arange(60).reshape(20, 3)
SHARED = [(k, j) for k in range(3) for j in range(3) if F[0, k] == F[1, j]]
for k_, j_ in SHARED:
    FTC[1, j_] = FTC[0, k_]
VERTICES = 60 - len(SHARED)


def stack_corners(positions: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return position and texture coordinates of each corner of the faces, (#F, 3, 5)."""
    return np.concatenate((positions, uv), axis=-1)


WANTED = stack_corners(V[F], TC[FTC])


@pytest.fixture(params=["obj", "ply", "glb"])
def path(request, tmp_path: Path) -> Path:
    path = tmp_path / f"atlas.{request.param}"
    write_mesh(path, V, F, TC, FTC)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    return path


def test_trimesh_reads_written_files(path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.load(path, process=False, force="mesh")
    assert len(mesh.vertices) == VERTICES  # vertices are duplicated only along seams
    assert np.allclose(stack_corners(mesh.vertices, mesh.visual.uv)[mesh.faces], WANTED, atol=1e-6)


def test_meshlab_reads_written_files(path: Path) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    faces = mesh.face_matrix()
    if mesh.has_wedge_tex_coord():
        uv = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)
    else:
        uv = mesh.vertex_tex_coord_matrix()[faces]
    assert np.allclose(stack_corners(mesh.vertex_matrix()[faces], uv), WANTED, atol=1e-6)


def test_vtk_reads_written_files(path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.read(path)
    if isinstance(mesh, pyvista.MultiBlock):
        mesh = mesh.combine().extract_surface(algorithm="dataset_surface")
    faces = mesh.faces.reshape(-1, 4)[:, 1:]
    uv = np.asarray(mesh.active_texture_coordinates)
    if path.suffix == ".glb":
        uv = uv * [1, -1] + [0, 1]  # VTK does not flip v when it reads GLB
    assert np.allclose(stack_corners(mesh.points, uv)[faces], WANTED, atol=1e-6)


def test_igl_reads_the_obj_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "atlas.obj"
    write_mesh(path, V, F, TC, FTC)
    positions, map_, _, faces, texture, _ = igl.readOBJ(str(path))
    assert (positions == V).all()
    assert (faces == F).all()
    assert (stack_corners(positions[faces], map_[texture][..., :2]) == WANTED).all()
    map_, texture = read_texture(path)
    assert (map_ == TC[:60]).all()
    assert (texture == FTC).all()
    write_mesh(path, V, F, V[:, :2])  # texture coordinates at vertices: FTC equals F
    assert (read_texture(path)[1] == F).all()


def test_glb_follows_its_specification(tmp_path: Path) -> None:
    path = tmp_path / "atlas.glb"
    write_mesh(path, V, F, TC, FTC)
    data = path.read_bytes()
    assert struct.unpack("<4sII", data[:12]) == (b"glTF", 2, len(data))
    length, kind = struct.unpack("<I4s", data[12:20])
    text = json.loads(data[20 : 20 + length])
    size, binary = struct.unpack("<I4s", data[20 + length : 28 + length])
    assert (kind, binary, length % 4, size % 4) == (b"JSON", b"BIN\0", 0, 0)
    body = data[28 + length :]
    assert len(body) == size == text["buffers"][0]["byteLength"]
    rows = []
    for accessor, (dtype, n) in zip(text["accessors"], (("<f4", 3), ("<f4", 2), ("<u4", 3)), strict=True):
        view = text["bufferViews"][accessor["bufferView"]]
        start = view["byteOffset"]
        assert start % 4 == 0
        rows.append(np.frombuffer(body[start : start + view["byteLength"]], dtype).reshape(-1, n))
    positions, uv, faces = rows
    assert text["accessors"][0]["min"] == positions.min(axis=0).tolist()
    assert np.allclose(stack_corners(positions[faces], (uv * [1, -1] + [0, 1])[faces]), WANTED, atol=1e-6)


@pytest.mark.parametrize("suffix", ["ply", "glb"])  # not OBJ, which keeps the old lines
def test_colours_that_are_not_finite_are_read_as_white_with_a_warning(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0 inf 0 0\nv 1 0 0 1 nan 0\nv 0 1 0 0 0 1\nf 1 2 3\n")
    with pytest.warns(MeshWarning, match=r"colours of vertices 0, 1 of a\.obj are not finite"):
        mesh = read_file(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        write_file(tmp_path / f"b.{suffix}", mesh, mesh.V[:, :2])
    colours = read_file(tmp_path / f"b.{suffix}").extras.colours
    assert colours is not None and colours[:, :3].tolist() == [[1, 1, 1], [1, 1, 1], [0, 0, 1]]


@pytest.mark.parametrize("number", ["1e400", "nan", "1e300"])
def test_normals_that_are_not_finite_are_read_as_zero(tmp_path: Path, number: str) -> None:
    path = tmp_path / "a.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 {number} 1\nvn 0 0 1\nf 1//1 2//2 3//2\n")
    with pytest.warns(MeshWarning, match=r"the normals 0 of a\.obj are not finite"):
        mesh = read_file(path)
    assert mesh.extras.normals.tolist() == [[0, 0, 0], [0, 0, 1]]
    write_file(tmp_path / "a.glb", mesh, mesh.V[:, :2])
    assert np.isfinite(read_file(tmp_path / "a.glb").extras.normals).all()


# FreeSurfer and GIFTI surfaces lose vertex numbers at seams
@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning")
@pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "gltf", "3mf", "vtp", "surf.gii", "surf"])
def test_mesh_files_are_written_whole_or_not_at_all(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs = {"3mf": "lib3mf", "vtp": "pyvista", "surf.gii": "nibabel", "surf": "nibabel"}
    pytest.importorskip(needs.get(suffix, "numpy"))
    path = tmp_path / f"atlas.{suffix}"
    path.write_text("old")
    with pytest.raises(MeshError, match=r"faces 7 have corners .* in TC are NaN"):
        write_mesh(path, V, F, TC, np.where(np.arange(20)[:, None] == 7, 60, FTC))
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        write_mesh(path, V, F, TC, FTC)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("suffix", ["svg", "dxf", "pdf", "png"])
def test_drawings_and_pictures_are_whole_or_not_at_all(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip({"svg": "svgwrite", "dxf": "ezdxf", "pdf": "matplotlib"}.get(suffix, "PIL"))
    path, atlas = tmp_path / f"a.{suffix}", unwrap(V, F)
    path.write_text("old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        if suffix == "png":
            write_image(path, np.zeros((4, 4, 3)))
        else:
            write_pattern(path, V, F, atlas)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_invalid_output_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"use \.obj, \.ply, \.glb"):
        write_mesh(tmp_path / "atlas.fbx", V, F, TC, FTC)
    with pytest.raises(MeshError, match=r"faces 19 refer in FTC to rows outside 0\.\.9 of TC"):
        write_mesh(tmp_path / "atlas.obj", V, F, TC[:10], np.vstack((FTC[:1].repeat(19, 0), [[0, 1, 10]])))
    with pytest.raises(MeshError, match="FTC has 3 rows for 20 faces"):
        write_mesh(tmp_path / "atlas.obj", V, F, TC, FTC[:3])
    with pytest.raises(MeshError, match=r"beyond 3\.4e38"):
        write_mesh(tmp_path / "atlas.glb", V * 1e39, F, TC, FTC)
    with pytest.raises(OSError):
        write_mesh(tmp_path / "nowhere" / "atlas.glb", V, F, TC, FTC)
    assert not list(tmp_path.iterdir())


QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "no texture coordinates"),
        (QUAD + "f 1 2 3\n", "no texture coordinates"),
        (QUAD + "f 1/1 2/2 3/3\nf 1 3 4\n", "no texture coordinates at corners of the faces 1"),
        (QUAD + "f 1/1 2/2 3/4\n", "rows outside 0..2 of vt"),
        (QUAD + "f 1/1 2/2 3/x\n", "line 8, .* is not a face"),
        ("", "no faces"),
    ],
)
def test_missing_texture_coordinates_are_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "mesh.obj"
    path.write_text(text)
    with pytest.raises(MeshError, match=said):
        read_texture(path)
    with pytest.raises(FileNotFoundError):
        read_texture(tmp_path / "nothing.obj")
