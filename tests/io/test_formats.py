"""OBJ, OFF, PLY and STL readers agree with igl's readers, and errors name the damaged line."""

from __future__ import annotations

import struct
from itertools import product
from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import DISKS, FOLDER, HOLES, STRESS
from hostile_files import good_files, list_files

from igl_linabf import MeshError, MeshWarning, unwrap
from igl_linabf.io import as_mesh_file, read_file, read_mesh, write_file, write_mesh
from igl_linabf.io.formats import detect_suffix, parse_bytes


@pytest.mark.skipif(FOLDER is None, reason="IGL_LINABF_MESHES is not set")
@pytest.mark.parametrize("name", [*DISKS, *HOLES, *STRESS])
def test_readers_agree_with_igl_to_the_last_bit(name: str) -> None:
    path = Path(FOLDER) / name
    V, F = igl.read_triangle_mesh(str(path))
    positions, faces = read_mesh(path)
    assert (positions == V).all()
    assert (faces == F).all()


def test_every_variant_of_each_format_has_the_same_surface() -> None:
    files = good_files(np.random.default_rng(0))
    first = parse_bytes(files["obj"][0], ".obj", "mesh")
    for suffix, forms in files.items():
        for data in forms:
            mesh = parse_bytes(data, f".{suffix}", "mesh")
            assert np.allclose(mesh.V[mesh.triangles], first.V[first.triangles], rtol=1e-6, atol=1e-7)
    with_texture = parse_bytes(files["obj"][1], ".obj", "mesh")
    assert (first.V[:, :2] == with_texture.TC).all()
    assert (with_texture.texture == first.polygons.corners).all()
    assert (first.texture == -1).all()


V = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n-1 0.5 1e-3\n"
POLYGONS = {
    "off": f"OFF\n5 2 0\n{V}5 0 1 2 3 4\n3 0 1 2\n",
    "obj": "".join(f"v {line}\n" for line in V.splitlines()) + "f 1 2 3 4 5\nf -5 -4// -3\n",
    "ply": "ply\r\nformat ascii 1.0\r\nelement vertex 5\r\nproperty float x\r\nproperty float y\r\n"
    "property float z\r\nelement face 2\r\nproperty uchar red\r\nproperty list uchar int vertex_index\r\n"
    f"end_header\r\n{V}7 5 0 1 2 3 4\n7 3 0 1 2\n",
}


def test_polygons_are_triangulated_like_igl(tmp_path: Path) -> None:
    # choose another triangle beside the pentagon, because a diagonal must not coincide with an edge
    swaps = ("3 0 1 2", "3 4 3 2"), ("-5 -4// -3", "-1 -2// -3")
    other = dict(POLYGONS)
    for suffix, (old, new) in product(POLYGONS, swaps):
        other[suffix] = other[suffix].replace(old, new)
    path = tmp_path / "polygons.off"
    path.write_text(other["off"])
    positions, faces = igl.read_triangle_mesh(str(path))
    assert len(faces) == 4
    lists = struct.pack("<B5iB3i", 5, 0, 1, 2, 3, 4, 3, 4, 3, 2)  # two face lists of different lengths
    head = other["ply"].replace("ascii", "binary_little_endian").replace("property uchar red\r\n", "")
    head, body = head[: head.index("end_header")].encode(), positions.astype("<f4").tobytes() + lists
    binary = head + b"end_header\n" + body
    binary_of_rhino = head.replace(b"\r\n", b"\r") + b"end_header\r" + body
    texts = [(f".{suffix}", text.encode()) for suffix, text in other.items()]
    for suffix, data in (*texts, (".ply", binary), (".ply", binary_of_rhino)):
        mesh = parse_bytes(data, suffix, "mesh")
        assert np.allclose(mesh.V, positions, rtol=1e-7)
        assert (faces == mesh.triangles).all()


@pytest.mark.parametrize("title", [b"", b"COLOR=\x00\x00\x00\xff"])
def test_stl_colours_match_their_attribute_bits(title: bytes) -> None:
    """Colours have five bits per component; the highest bit marks a colour, or none in Magics files."""
    shades = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    bits = (1 << 0, 1 << 5, 1 << 10) if title else (1 << 10, 1 << 5, 1 << 0)
    corners = np.arange(9.0).reshape(3, 3) ** 2
    rows = [
        struct.pack("<12fH", 0, 0, 0, *(corners + k).ravel(), 31 * bit | (0 if title else 0x8000))
        for k, bit in enumerate(bits)
    ]
    mesh = parse_bytes(title.ljust(80, b"\0") + struct.pack("<I", 3) + b"".join(rows), ".stl", "mesh")
    assert (mesh.extras.face_colours == shades).all()


def test_negative_obj_indices_are_relative_to_their_line() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf -3/-3 -2/-2 -1/-1\n"
    twice = parse_bytes((text + text.replace("v 0 0 0", "v 0 0 5")).encode(), ".obj", "mesh")
    assert twice.F.tolist() == twice.FTC.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_polygons_with_hundreds_of_corners_are_preserved(tmp_path: Path) -> None:
    for n in (255, 256, 300):
        around = 2 * np.pi * np.arange(n) / n
        rim = np.column_stack((np.cos(around), np.sin(around), 0 * around))
        mesh = as_mesh_file(rim, [[*range(n)], [1, 0, n // 2]])
        for suffix in (".ply", ".obj"):
            write_file(tmp_path / f"a{suffix}", mesh, rim[:, :2])
            again = read_file(tmp_path / f"a{suffix}")
            assert again.polygons.sizes.tolist() == [n, 3]
            assert (again.V[again.polygons.corners] == rim[mesh.polygons.corners]).all()


OFF, PLY, OBJ = POLYGONS["off"], POLYGONS["ply"], POLYGONS["obj"]
SOLID = """solid
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid
"""


@pytest.mark.parametrize(
    ("suffix", "text", "said"),
    [
        (".obj", OBJ.replace("1 1 0", "1 1"), "line 3, 'v 1 1', is not a vertex"),
        (".obj", OBJ.replace("1 1 0", "1 1 1_0"), "line 3, .* is not a vertex"),
        (
            ".obj",
            OBJ + "f 1 2 6\n",
            "line 8, 'f 1 2 6', refers to a vertex outside the 5 vertices of the file",
        ),
        (".obj", OBJ + "f -6 1 2\n", "line 8, .* refers to a vertex outside"),
        (".obj", OBJ + "f 0 1 2\n", "line 8, .* is not a face"),
        (".obj", OBJ + "f 1 2\n", "line 8, .* is not a face"),
        (".obj", OBJ + "f 1 2 3/1/1/1\n", "line 8, .* is not a face"),
        (".obj", OBJ + "vt x\n", "line 8, 'vt x', is not a texture coordinate"),
        (".off", OFF[3:], "it does not begin with OFF"),
        (".off", OFF.replace("OFF", "4OFF"), "it does not begin with OFF"),
        (".off", "OFF BINARY\n", "a binary OFF: export it as text"),
        (".off", "OFF\n", "numbers of vertices and faces are missing"),
        (".off", OFF.replace("5 2 0", "5 3 0"), "declares 5 vertices and 3 faces, but 7 lines follow"),
        (".off", OFF.replace("1 1 0", "1 one 0"), "line 5, '1 one 0', is not a vertex"),
        (".off", OFF.replace("3 0 1 2", "3 0 1"), "line 9, '3 0 1', is not a face"),
        (".off", OFF.replace("3 0 1 2", "3 0 1 5"), r"line 9, .* refers to a vertex outside 0\.\.4"),
        (".off", OFF.replace("3 0 1 2", "3 0 1 1.5"), "line 9, .* is not a face"),
        (".ply", PLY.replace("ascii", "text"), "line 2, 'format text 1.0.*', is not understood"),
        (".ply", PLY.replace("5 0 1", "6 0 1"), "line 16, .* is not a row of the element face"),
        (".ply", PLY.replace("3 0 1 2", "3 0 1 5"), r"faces 1 refer to vertices outside 0\.\.4"),
        (".ply", PLY.replace("3 0 1 2", "2 0 1"), "faces 1 have fewer than three vertices"),
        (".ply", PLY.replace("vertex 5", "vertex 6"), "declares 8 rows in total, but 7 lines follow"),
        (".ply", PLY.replace("float z", "float w"), "lacks the properties x, y and z"),
        (".ply", PLY.replace("int vertex_index", "float vertex_index"), "no list of integers vertex_indices"),
        (".ply", PLY.replace("ascii", "binary_big_endian"), "a list of|it ends in row|bytes follow"),
        (".ply", PLY.replace("3 0 1 2", "3 0 1 -"), "line 17, .* is not a row of the element face"),
        (".ply", PLY.replace("face", "tristrips").replace("3 0 1 2", "3 0 1 5"), r"outside 0\.\.4"),
        (
            ".ply",
            PLY.replace("face", "tristrips").replace("int vertex", "float vertex"),
            "element tristrips has no",
        ),
        (".ply", PLY.replace("face", "range_grid"), "range scan without faces: mesh it first"),
        (".stl", SOLID.replace("vertex 0 1 0\n", ""), "line 6, 'endloop', is out of place"),
        (".stl", SOLID.replace("0 1 0", "0 nan 0"), "triangles 0 have coordinates that are NaN"),
        (".stl", SOLID[:-10], "it ends in line 8, without endsolid"),
        (".stl", "x" * 100, "its header declares 2,021,161,080 triangles, but 0.32 follow"),
        (".stl", "", "its 0 bytes are neither"),
    ],
)
def test_damage_is_refused_with_its_place(suffix: str, text: str, said: str) -> None:
    with pytest.raises(MeshError, match=f"^mesh cannot be read as {suffix[1:].upper()}: .*{said}"):
        parse_bytes(text.encode(), suffix, "mesh")


@pytest.mark.parametrize("mark", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_encodings_and_line_endings_do_not_change_the_mesh(mark: str) -> None:
    # with a byte order mark, in UTF-16, in upper case, and with line endings of Windows
    texts = {"off": OFF, "ply": PLY, "obj": OBJ, "stl": SOLID}
    for suffix, text in texts.items():
        plain = parse_bytes(text.encode(), f".{suffix}", "mesh")
        for form in (text, text.replace("\n", "\r\n"), text.upper() if suffix == "stl" else text):
            data = ("\ufeff" * (mark[-2:] in ("le", "be")) + form).encode(mark)
            assert detect_suffix(data) == f".{suffix}"
            mesh = parse_bytes(data, f".{suffix}", "mesh")
            assert (mesh.V == plain.V).all()
            assert (mesh.polygons.corners == plain.polygons.corners).all()
            assert (mesh.polygons.sizes == plain.polygons.sizes).all()
        with pytest.raises(MeshError, match="begins as UTF-16 text, but continues"):
            parse_bytes(b"\xff\xfe" + f"{text} ".encode() + b"\x00\xd8", f".{suffix}", "mesh")


def test_bytes_after_the_triangles_of_an_stl_file_are_skipped_with_a_warning() -> None:
    data = list_files(np.eye(3), np.array([[0, 1, 2]]))["stl"][0]
    with pytest.warns(MeshWarning, match="3 bytes follow face 0"):
        mesh = parse_bytes(data + b"end", ".stl", "mesh")
    assert (mesh.V[mesh.triangles] == np.eye(3)).all()
    with pytest.raises(MeshError, match="declares 1 triangle, but 2 follow"):
        parse_bytes(data + data[-50:], ".stl", "mesh")


def test_unknown_obj_lines_are_skipped_with_a_warning() -> None:
    with pytest.warns(
        MeshWarning, match=r"lines 1, 9 of mesh are not OBJ statements \(the first: 'nanf 1 2'\)"
    ):
        mesh = parse_bytes(f"nanf 1 2\n{OBJ}?\n".encode(), ".obj", "mesh")
    assert len(mesh.triangles) == 4


def test_words_of_an_off_file_may_be_spread_over_lines(tmp_path) -> None:
    whole, spread = tmp_path / "whole.off", tmp_path / "spread.off"
    whole.write_text(OFF)
    head, counts, *rows = OFF.splitlines()
    spread.write_text("\n".join([head, counts, *(f"{word}\n" for row in rows for word in row.split())]))
    (V, F), (spread_V, spread_F) = read_mesh(whole), read_mesh(spread)
    np.testing.assert_array_equal(V, spread_V)
    np.testing.assert_array_equal(F, spread_F)
    spread.write_text(spread.read_text() + "7\n")
    with pytest.raises(MeshError, match="lines follow"):
        read_mesh(spread)


def test_obj_faces_may_span_lines_and_off_headers_need_no_space(tmp_path) -> None:
    plain = parse_bytes(POLYGONS["obj"].encode(), ".obj", "mesh")
    split = POLYGONS["obj"].replace("f 1 2 3", "f 1 2 \\\n3 \\\n", 1)
    mesh = parse_bytes(split.encode(), ".obj", "mesh")
    assert (mesh.triangles == plain.triangles).all()
    path = tmp_path / "again.obj"
    write_file(path, mesh, mesh.V[:, :2])
    assert (read_mesh(path)[1] == plain.triangles).all()
    with pytest.raises(MeshError, match="line 10, 'f 1 2'"):
        parse_bytes((split + "f 1 2\n").encode(), ".obj", "mesh")
    glued = parse_bytes(POLYGONS["off"].replace("OFF\n", "OFF").encode(), ".off", "mesh")
    assert (glued.triangles == plain.triangles).all()


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_triangle_strips_of_a_scan_become_faces(form: str, tmp_path: Path) -> None:
    n, m = 5, 7  # a grid of n x m points; its strips are joined by repeated vertices or by -1
    at = np.arange(n * m).reshape(n, m)
    first, second, third, last = (np.column_stack((at[i + 1], at[i])).ravel().tolist() for i in range(n - 1))
    joined = [*first, first[-1], second[0], *second, -1, *third, -1]
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel()
    F = np.stack((np.column_stack((c, a, d)), np.column_stack((d, a, b))), axis=1).reshape(-1, 3)
    F = np.vstack(([[30, 29, 28]], F))  # a face with a label precedes the triangles of the strips
    x, y = np.divmod(np.arange(n * m), m)
    V = np.column_stack((x, y, x * y)).astype(float)
    head = f"ply\nformat {form} 1.0\nelement vertex {n * m}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "element tristrips 2\n"
    head += "property list int int vertex_indices\nelement face 1\nproperty short label\n"
    head += "property list uchar int vertex_indices\nend_header\n"
    lists = (joined, last)
    if form == "ascii":
        rows = [*V.tolist(), *([len(row), *row] for row in lists), [7, 3, *F[0]]]
        data = "".join(" ".join(map(str, row)) + "\n" for row in rows).encode()
    else:
        order = "<" if "little" in form else ">"
        data = V.astype(f"{order}f8").tobytes() + b"".join(
            struct.pack(f"{order}{1 + len(row)}i", len(row), *row) for row in lists
        )
        data += struct.pack(f"{order}hB3i", 7, 3, *F[0])
    path = tmp_path / "scan.ply"
    path.write_bytes(head.encode() + data)
    mesh = read_file(path)
    assert (mesh.V == V).all()
    assert (mesh.F == F).all()
    write_file(tmp_path / "again.ply", mesh, V[:, :2])
    again = read_file(tmp_path / "again.ply")
    assert (again.V[again.F] == V[F]).all()
    assert again.extras.source.tables["face"]["label"].values.tolist() == [7] + [0] * (len(F) - 1)


def test_a_point_cloud_is_refused_with_a_remedy(tmp_path: Path) -> None:
    no_faces = PLY.replace("face 2", "face 0").partition("7 5 0")[0]
    for text in (PLY[: PLY.index("element face")] + f"end_header\n{V}", no_faces):
        (tmp_path / "points.ply").write_text(text)
        for read in (read_mesh, read_file):
            with pytest.raises(MeshError, match="5 vertices and no faces: make a surface of these points"):
                read(tmp_path / "points.ply")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("suffix", ["ply", "glb"])
def test_signalling_nan_is_read_without_a_warning_of_numpy(tmp_path: Path, suffix: str) -> None:
    V, F = igl.icosahedron()
    V = (V + np.array([0.1, 0.3, 0.7])).astype(np.float32)
    path = tmp_path / f"a.{suffix}"
    if suffix == "ply":
        header = (
            "ply\nformat binary_little_endian 1.0\nelement vertex 12\nproperty float x\nproperty float y\n"
        )
        header += "property float z\nelement face 20\nproperty list uchar int vertex_indices\nend_header\n"
        faces = np.zeros(20, [("size", "u1"), ("corners", "<i4", 3)])
        faces["size"], faces["corners"] = 3, F
        path.write_bytes(header.encode() + V.tobytes() + faces.tobytes())
    else:
        write_mesh(path, V, F, V[:, :2], F)
    path.write_bytes(path.read_bytes().replace(V[0, :1].tobytes(), np.uint32(0x7F800001).tobytes()))
    assert np.isnan(read_file(path).V).any()
    V.view(np.uint32)[0, 0] = 0x7F800001
    with pytest.raises(MeshError, match=r"vertices 0 .*NaN"):
        unwrap(V, F)
