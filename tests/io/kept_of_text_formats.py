"""Checks of what remains of the contents of OBJ, PLY, OFF and STL files in each format."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
from kept import Cell, round_trip

from igl_linabf import Packing, unwrap
from igl_linabf.io import MeshFile, image_maps, read_file, write_file, write_image
from igl_linabf.textures import bake_texture

TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
MAPPED = "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 2/2 3/3 4/1\nf 1/1 4/2 3/3\n"
FACES = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
LATIN = b"\272\354", b"\302\314"  # two names that are not valid UTF-8


def assert_same_corners(before: MeshFile, after: MeshFile) -> None:
    """Assert that two meshes have the same positions and texture coordinates at their corners."""
    assert after.polygons.sizes.tolist() == before.polygons.sizes.tolist()
    np.testing.assert_allclose(
        after.V[after.polygons.corners], before.V[before.polygons.corners], atol=1e-6, rtol=1e-6
    )
    np.testing.assert_allclose(after.TC[after.texture], before.TC[before.texture], atol=1e-6)


def check_obj(text: str | bytes, to: str = "out.obj", name: str = "a.obj") -> Callable[[Path], object]:
    """Return a check that the corners of an OBJ file with the given text do not change."""
    return lambda folder: assert_same_corners(*round_trip(folder, name, text, to))


def check_obj_lines(*lines: str) -> Callable[[Path], object]:
    """Return a check that an OBJ file keeps the given lines, in order, between its vertices and faces."""

    def act(folder: Path) -> None:
        text = TETRA + "\n".join(lines) + "\n" + FACES
        assert_same_corners(*round_trip(folder, "a.obj", text))
        there = (folder / "out" / "out.obj").read_text().splitlines()
        assert [line for line in there if line.split()[0] not in ("vt", "f")] == [
            line for line in text.splitlines() if line.split()[0] != "f"
        ]

    return act


def check_latin_names(to: str, *, image: bool = False) -> Callable[[Path], object]:
    """Return a check that two material names that are not UTF-8 remain distinct, each with its colour."""

    def act(folder: Path) -> None:
        (folder / "in").mkdir()
        (folder / "out").mkdir()
        library = b"".join(b"newmtl %b\nKd 0.%d 0 0\n" % (name, i) for i, name in enumerate(LATIN))
        (folder / "in" / "g.mtl").write_bytes(library)
        faces = FACES.encode().splitlines(keepends=True)
        text = b"usemtl %b\n%b%busemtl %b\n%b%b" % (LATIN[0], *faces[:2], LATIN[1], *faces[2:])
        (folder / "in" / "g.obj").write_bytes(b"mtllib g.mtl\n" + TETRA.encode() + text)
        mesh = read_file(folder / "in" / "g.obj")
        pixels = np.ones((4, 4, 3)) if image else None
        write_file(folder / "out" / to, mesh, mesh.V[:, :2], image=pixels)
        after = read_file(folder / "out" / to, allow_outside=True)
        names, of = after.extras.materials
        assert len(set(names)) == 2
        assert of.tolist() == [0, 0, 1, 1]
        reds = [look.colour.red for look in after.extras.looks]
        np.testing.assert_allclose(reds, [1, 1] if image else [0, 0.1], atol=1e-6)
        if to.endswith(".obj"):
            there = (folder / "out" / to).read_bytes()
            assert all(b"usemtl %b\n" % name in there for name in LATIN)
        if image:
            assert all(b"newmtl %b\n" % name in (folder / "out" / "out.mtl").read_bytes() for name in LATIN)

    return act


def check_obj_names(folder: Path) -> None:
    """Check that material names with spaces or # remain distinct."""
    names = ["a b", "a  b", "a#1", "a#2", "Größe 1", "a"]
    text = TETRA + "".join(f"usemtl {name}\no {name}\nf 1 2 3\n" for name in names)
    before, after = round_trip(folder, "a.obj", text)
    assert before.materials == after.materials == before.parts == after.parts == tuple(names)


def check_libraries(*lines: str) -> Callable[[Path], object]:
    """Return a check of material libraries in other folders; the first definition of a material counts."""

    def act(folder: Path) -> None:
        (folder / "in" / "sub").mkdir(parents=True)
        (folder / "in" / "sub" / "c.mtl").write_text("newmtl c\nKd 0.3 0 0\n")
        (folder / "in" / "a.mtl").write_text("newmtl a\nKd 0.1 0 0\n")
        (folder / "in" / "my b.mtl").write_text("newmtl b\nKd 0.2 0 0\nnewmtl a\nKd 0.9 0 0\n")
        text = "\n".join(lines) + "\n" + TETRA + "usemtl a\nf 1 3 2\nusemtl b\nf 1 2 4\nusemtl c\nf 2 3 4\n"
        before, after = round_trip(folder, "a.obj", text)
        for mesh in (before, after):
            assert [look.colour.red for look in mesh.extras.looks] == [0.1, 0.2, 0.3]

    return act


def check_other_files(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "out").mkdir()
    for name in ("s.obj", "t.obj", "m.map", "m n.map", "c.mod"):
        (folder / "in" / name).write_text("")
    lines = "shadow_obj s.obj\ntrace_obj t.obj\nmaplib m.map m n.map\ncall c.mod 1 2\nshadow_obj none.obj\n"
    round_trip(folder, "a.obj", lines + TETRA + FACES)
    there = (folder / "out" / "out.obj").read_text().splitlines()
    assert there[:6] == [
        "shadow_obj ../in/s.obj",
        "trace_obj ../in/t.obj",
        "maplib ../in/m.map",
        "maplib ../in/m n.map",
        "call ../in/c.mod 1 2",
        "shadow_obj none.obj",
    ]


def check_old_texture_of_lines(folder: Path) -> None:
    round_trip(folder, "a.obj", TETRA + "vt 0 0\nvn 0 0 1\nl 1/1 2/1\nsurf 0 1 0 1 1/1/1 2/1 3\n" + FACES)
    there = (folder / "out" / "out.obj").read_text()
    assert "\nl 1 2\nsurf 0 1 0 1 1//1 2 3\n" in there


def check_foreign_line(folder: Path) -> None:
    (folder / "a.obj").write_text(TETRA + "hello\n" + FACES)
    mesh = read_file(folder / "a.obj")
    write_file(folder / "b.obj", mesh, mesh.V[:, :2])
    assert "\nhello\n" in (folder / "b.obj").read_text()


def check_vertex_and_face_colours(folder: Path) -> None:
    text = "COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2 0 255 0\n"
    _, after = round_trip(folder, "a.off", text, "out.glb")
    np.testing.assert_allclose(after.colours, [[0, 1, 0]] * 3)


def check_unsupported_material_keys(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "a.mtl").write_text("newmtl a\nKd 1 0 0\nKs 1 1 1\nNs 200\nd 0.5\n")
    _, after = round_trip(folder, "a.obj", "mtllib a.mtl\nusemtl a\n" + TETRA + FACES, "out.glb")
    np.testing.assert_allclose(after.extras.looks[0].colour, [1, 0, 0], atol=1e-6)
    assert after.extras.looks[0].alpha == 0.5


def check_images(to: str, *, image: bool = False) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        (folder / "in").mkdir()
        (folder / "out").mkdir()
        (folder / "in" / "a.mtl").write_text("newmtl a\nmap_Kd old.png\n")
        (folder / "in" / "a.obj").write_text("mtllib a.mtl\nusemtl a\n" + TETRA + FACES)
        mesh = read_file(folder / "in" / "a.obj")
        write_file(folder / "out" / to, mesh, mesh.V[:, :2], image=np.ones((2, 2, 3)) if image else None)

    return act


def check_moved_images(to: str) -> Callable[[Path], object]:
    """Return a check that moved images and the other lines of their materials are kept."""

    def act(folder: Path) -> None:
        (folder / "in").mkdir()
        (folder / "out").mkdir()
        write_image(folder / "in" / "old.png", np.full((4, 4, 3), 0.2))
        of_obj = "Ns 7\n" * to.endswith(".obj")  # glTF cannot store Ns
        (folder / "in" / "a.mtl").write_text(f"newmtl a\nKd 0.5 1 1\n{of_obj}map_Kd -s 2 2 old.png\n")
        (folder / "in" / "a.obj").write_text(
            "mtllib a.mtl\nusemtl a\nvt 0 0\nvt 1 0\nvt 0 1\n" + TETRA + MAPPED
        )
        mesh = read_file(folder / "in" / "a.obj")
        atlas = unwrap(mesh.V, mesh.F, packing=Packing(resolution=32))
        moved = {
            kind: bake_texture(
                mesh.V, mesh.F, atlas, mesh.TC, mesh.FTC, own, 32, labels=mesh.extras.materials[1]
            )
            for kind, own in image_maps(mesh).items()
        }
        write_file(folder / "out" / to, mesh, atlas.TC, atlas.FTC, moved)
        after = read_file(folder / "out" / to)
        (image,) = image_maps(after)["baseColorTexture"]
        corner = after.TC[after.texture] @ [[32, 0], [0, -32]] + [0, 32]
        x, y = corner.reshape(-1, 3, 2).mean(axis=1).astype(int).T
        assert np.allclose(image.pixels[y, x], 0.2, atol=0.003)
        assert np.allclose(after.extras.looks[0].colour, (0.5, 1, 1))
        if to.endswith(".obj"):
            assert "Ns 7" in after.extras.looks[0].lines

    return act


def check_second_set(to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        (folder / "a.obj").write_text("vt 0 0\nvt 1 0\nvt 0 1\n" + TETRA + MAPPED)
        mesh = read_file(folder / "a.obj")
        write_file(folder / to, mesh, mesh.V[:, :2], texcoord=1)
        after = read_file(folder / to)
        assert np.allclose(after.TC[after.texture], mesh.TC[mesh.texture])

    return act


def check_obj_colours(lines: str, colours: list[list[float]], to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        before, after = round_trip(folder, "a.obj", lines + FACES, to)
        np.testing.assert_allclose(before.colours, colours)
        np.testing.assert_allclose(
            after.colours[after.polygons.corners][:, :3],
            np.array(colours)[before.polygons.corners][:, :3],
            atol=0.003,
        )

    return act


COLOURED = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 0\n"
BYTES = "v 0 0 0 255 0 0\nv 1 0 0 0 255 0\nv 0 1 0 0 0 255\nv 0 0 1 255 255 0\n"
SOME = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1\n"
PAINTED = TETRA + "#MRGB ffff0000ff00ff00\n#MRGB ff0000ffffffff00\n"
RGBY = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]]


def check_obj_normals(to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        normals = "".join(f"vn {v.removeprefix('v ')}\n" for v in TETRA.splitlines()[1:])
        faces = "f 1//1 3//2 2//3\nf 1//2 2//3 4//1\nf 2//2 3//2 4//2\n"
        before, after = round_trip(folder, "a.obj", TETRA + normals + faces, to)
        np.testing.assert_allclose(
            after.extras.normals[after.extras.normal], before.extras.normals[before.extras.normal]
        )
        assert_same_corners(before, after)

    return act


def check_comments(name: str, data: str | bytes, to: str, wanted: list[str]) -> Callable[[Path], object]:
    """Return a check that the new file contains the comments."""

    def act(folder: Path) -> None:
        source, out = folder / "in" / name, folder / "out" / to
        for path in (source, out):
            path.parent.mkdir()
        source.write_bytes(data if isinstance(data, bytes) else data.encode())
        mesh = read_file(source)
        write_file(out, mesh, np.random.default_rng(0).random((len(mesh.V), 2)))
        if to.endswith(".gltf"):
            assert json.loads(out.read_text())["asset"]["extras"]["comments"] == wanted
        else:
            mark = b"comment " if to.endswith(".ply") else b"# "
            assert all(mark + line.encode() + b"\n" in out.read_bytes() for line in wanted)

    return act


def check_parts(to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        before, after = round_trip(folder, "a.obj", TETRA + "g a\nf 1 3 2\nf 1 2 4\ng b\nf 2 3 4\n", to)
        assert before.parts == after.parts == ("a", "b")
        assert after.extras.parts[1].tolist() == [0, 0, 1]

    return act


def check_vertex_numbers(folder: Path) -> None:
    """Check that the PLY file keeps the vertex numbers of the OBJ file, including an unreferenced vertex."""
    before, after = round_trip(folder, "a.obj", TETRA + "v 9 9 9\n" + FACES, "out.ply")
    assert (after.V == before.V).all()
    assert (after.polygons.corners == before.polygons.corners).all()
    assert_same_corners(before, after)


def make_ply(
    vertex: str = "",
    face: str = "",
    more: str = "",
    comments: str = "",
    rows: tuple[str, str, str] = ("", "", ""),
    quads: bool = False,
) -> bytes:
    """Return a PLY file of a tetrahedron, or of a box of quadrangles, with additional contents."""
    if quads:
        V = [f"{x} {y} {z}" for z in (0, 1) for y in (0, 1) for x in (0, 1)]
        F = ["0 2 3 1", "4 5 7 6", "0 1 5 4", "2 6 7 3", "0 4 6 2", "1 3 7 5"]
    else:
        V, F = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"], ["0 2 1", "0 1 3", "1 2 3", "0 3 2"]
    head = f"ply\nformat ascii 1.0\n{comments}element vertex {len(V)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + vertex
    head += f"element face {len(F)}\nproperty list uchar int vertex_indices\n{face}{more}end_header\n"
    text = head + "".join(f"{row} {rows[0].replace('#', str(i))}\n" for i, row in enumerate(V))
    text += "".join(f"{len(row.split())} {row} {rows[1].replace('#', str(i))}\n" for i, row in enumerate(F))
    return (text + rows[2]).encode("latin-1")


TABLE = {
    "vertex": "property float quality\nproperty list uchar short seen_by\n",
    "face": "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int label\n"
    "property list uchar int neighbours\n",
    "more": "element edge 2\nproperty int vertex1\nproperty int vertex2\nproperty uchar crease\n"
    "element landmark 1\nproperty list uchar int vertex_indices\nelement camera 1\nproperty float focus\n",
}
ROWS = ("0.# 2 # 7", "# 20 30 # 1 #", "0 1 1\n3 2 0\n2 3 1\n0.5\n")


def check_ply_tables(quads: bool) -> Callable[[Path], object]:
    """Return a check that all elements and properties are kept, and that vertex numbers remain valid."""

    def act(folder: Path) -> None:
        before, after = round_trip(folder, "a.ply", make_ply(**TABLE, rows=ROWS, quads=quads), "out.ply")
        assert_same_corners(before, after)
        old, new = before.extras.source.tables, after.extras.source.tables
        for name in ("edge", "landmark", "camera"):
            assert new[name].keys() == old[name].keys()
            for key, column in new[name].items():
                assert column.values.tolist() == old[name][key].values.tolist()
        for key, column in old["face"].items():
            if key != "vertex_indices":
                assert new["face"][key].values.tolist() == column.values.tolist()
        n = len(before.V)
        assert (after.V[:n] == before.V).all()
        np.testing.assert_allclose(new["vertex"]["quality"].values[:n], old["vertex"]["quality"].values)
        for lists in (old["vertex"]["seen_by"], new["vertex"]["seen_by"]):
            assert lists.select_rows(np.arange(n)).values.tolist() == old["vertex"]["seen_by"].values.tolist()
        ends = [np.concatenate([t["edge"][k].values for k in ("vertex1", "vertex2")]) for t in (old, new)]
        assert (after.V[ends[1].astype(int)] == before.V[ends[0].astype(int)]).all()
        assert "texcoord" in new["face"] or quads

    return act


def check_ply_comments(folder: Path) -> None:
    lines = "comment  two  blanks\nobj_info num_cols 5\ncomment caf\xe9\n"
    round_trip(folder, "a.ply", make_ply(comments=lines), "out.ply")
    assert lines.encode("latin-1") in (folder / "out" / "out.ply").read_bytes()


def check_ply_images(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "my skin.png").write_text("")
    round_trip(folder, "a.ply", make_ply(comments="comment TextureFile my skin.png\n"), "out.ply")
    assert b"\ncomment TextureFile ../in/my skin.png\n" in (folder / "out" / "out.ply").read_bytes()


def check_ply_lists(folder: Path) -> None:
    """Check that texture coordinates in lists at faces are read, and are written if there are seams."""
    data = make_ply(
        face="property list uchar float texcoord\nproperty int texnumber\n", rows=("", "6 0 0 1 0 1 # 3", "")
    )
    (folder / "read.ply").write_bytes(data)
    read = read_file(folder / "read.ply")
    assert read.TC[read.texture].reshape(-1, 3, 2)[2].tolist() == [[0, 0], [1, 0], [1, 2]]
    before, after = round_trip(folder, "a.ply", data, "out.ply")
    assert_same_corners(before, after)
    assert len(after.V) == 4
    assert after.extras.source.tables["face"]["texnumber"].values.tolist() == [3] * 4


def check_ply_colours(to: str, names: tuple[str, ...] = ("red", "green", "blue")) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        vertex = "".join(f"property uchar {name}\n" for name in names)
        before, after = round_trip(folder, "a.ply", make_ply(vertex=vertex, rows=("25# 0 51", "", "")), to)
        wanted = np.array([[250 + i, 0, 51] for i in range(4)]) / 255
        np.testing.assert_allclose(before.colours, wanted)
        np.testing.assert_allclose(
            after.colours[after.polygons.corners][:, :3], wanted[before.polygons.corners], atol=1e-6
        )

    return act


def check_ply_strips(folder: Path) -> None:
    data = (
        make_ply()
        .replace(b"element face 4", b"element tristrips 1")
        .replace(b"3 0 2 1 \n3 0 1 3 \n3 1 2 3 \n3 0 3 2 \n", b"7 0 1 2 3 -1 0 1\n")
    )
    before, after = round_trip(folder, "a.ply", data.replace(b"list uchar", b"list int"), "out.ply")
    assert before.triangles.tolist() == [[0, 1, 2], [2, 1, 3]]
    assert_same_corners(before, after)


def check_labelled_ply_strips(folder: Path) -> None:
    data = (
        make_ply().replace(b"face 4", b"tristrips 1").replace(b"indices\n", b"indices\nproperty int label\n")
    )
    round_trip(folder, "a.ply", data.partition(b"3 0 2 1")[0] + b"4 0 1 2 3 7\n", "out.ply")


def check_round_trip(name: str, data: bytes | str, to: str) -> Callable[[Path], object]:
    return lambda folder: assert_same_corners(*round_trip(folder, name, data, to))


SHADES = "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))


def check_face_colours_in_glb(folder: Path) -> None:
    """Check that GLB duplicates vertices between faces with different colours."""
    data = make_off("OFF", face="25# 0 51")
    before, after = round_trip(folder, "a.off", data, "out.glb")
    at = after.extras.corner_colours[::3]
    np.testing.assert_allclose(at[:, :3], before.extras.face_colours, atol=1e-6)
    np.testing.assert_allclose(at[:, 0] * 255, [250, 251, 252, 253], atol=1e-4)


def make_off(head: str, vertex: str = "", face: str = "", comment: str = "") -> str:
    V, F = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"], ["3 0 2 1", "3 0 1 3", "3 1 2 3", "3 0 3 2"]
    rows = [f"{row} {vertex.replace('#', str(i))}" for i, row in enumerate(V)]
    rows += [f"{row} {face.replace('#', str(i))}" for i, row in enumerate(F)]
    return "\n".join([head, *[comment] * bool(comment), "4 4 0", *rows, ""])


def check_off_vertices(folder: Path) -> None:
    """Check that normals, colours and texture coordinates follow the vertices; integer colours end at 255."""
    data = make_off("STCNOFF", "0 0.6 0.8 25# 0 51 255 0.# 0.5")
    before, after = round_trip(folder, "a.off", data)
    np.testing.assert_allclose(before.extras.normals, [[0, 0.6, 0.8]] * 4)
    np.testing.assert_allclose(before.colours * 255, [[250 + i, 0, 51, 255] for i in range(4)])
    np.testing.assert_allclose(after.colours, before.colours[:, :3])
    np.testing.assert_allclose(after.extras.normals[after.extras.normal], [[0, 0.6, 0.8]] * 12)
    mesh = read_file(folder / "in" / "a.off")
    assert mesh.TC[mesh.texture][:3].tolist() == [[0, 0.5], [0.2, 0.5], [0.1, 0.5]]
    (folder / "f.off").write_text(make_off("COFF", "0.# 0 1"))
    np.testing.assert_allclose(read_file(folder / "f.off").colours[:, 0], [0, 0.1, 0.2, 0.3])


def check_face_colours(name: str, data: str | bytes, wanted: list[list[float]]) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        before, after = round_trip(folder, name, data, "out.ply")
        np.testing.assert_allclose(before.extras.face_colours, wanted)
        np.testing.assert_allclose(after.extras.face_colours, wanted, atol=0.003)

    return act


SOLIDS = "".join(
    f"solid {name}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {z}\nvertex 1 0 {z}\nvertex 0 1 {z}\nendloop\n"
    f"endfacet\nendsolid {name}\n"
    for z, name in enumerate(("left wheel", "", "right wheel"))
)


def check_solids(folder: Path) -> None:
    before, after = round_trip(folder, "a.stl", SOLIDS.replace("solid \n", "solid axle\n"))
    assert before.parts == after.parts == ("left wheel", "axle", "right wheel")
    assert after.extras.parts[1].tolist() == [0, 1, 2]


def make_stl(title: bytes, more: list[int], rest: bytes = b"") -> bytes:
    faces = [((0, 0, 0), (0, 1, 0), (1, 0, 0)), ((0, 0, 0), (1, 0, 0), (0, 0, 1))]
    rows = [struct.pack("<12fH", 0, 0, 0, *sum(face, ()), own) for face, own in zip(faces, more, strict=True)]
    return title.ljust(80, b"\0") + struct.pack("<I", 2) + b"".join(rows) + rest


MAGICS = b"made COLOR=" + bytes([255, 0, 51, 255])
OBJ_CELLS = [
    (
        "polygons in their order, also with negative vertex indices",
        check_obj(TETRA + "v 1 1 0\nf 1 3 5 2\nf -5 -4 -2\n"),
    ),
    (
        "vertex colours, vertex weights and further numbers after the positions",
        check_obj_lines("v 1 2 3 0.5", "v 1 2 3 0.1 0.2 0.3"),
    ),
    ("unreferenced vertices", check_obj_lines("v 9 9 9")),
    ("normals", check_obj_normals("out.obj")),
    (
        "objects, groups within objects, several groups on a line, smoothing and merging groups",
        check_obj_lines("o a", "g b c", "g", "s 1", "mg 1 0.5", "o d", "g e", "s off"),
    ),
    ("points and polylines", check_obj_lines("p 1 2", "l 1 2 -1")),
    (
        "free-form curves and surfaces",
        check_obj_lines(
            "vp 0.1 0.2", "cstype rat bspline", "deg 3", "curv 0 1 1 2 3 4", "surf 0 1 0 1 1//1 2", "end"
        ),
    ),
    (
        "display attributes",
        check_obj_lines("bevel on", "c_interp on", "lod 2", "ctech cparm 1", "usemap skin"),
    ),
    ("comments, including those on face lines", lambda folder: check_comments_at_faces(folder)),
    ("names with spaces, with #, or with letters of any script", check_obj_names),
    ("names that are not valid UTF-8, byte for byte", check_latin_names("out.obj")),
    (
        "names that are not valid UTF-8, with a baked image (the new material library has the same bytes)",
        check_latin_names("out.obj", image=True),
    ),
    ("several material libraries on one line", check_libraries("mtllib a.mtl my b.mtl sub/c.mtl")),
    (
        "quoted names of material libraries",
        check_libraries('mtllib "a.mtl" "my b.mtl"', 'mtllib "sub/c.mtl"'),
    ),
    (
        "names of material libraries with spaces or backslashes",
        check_libraries("mtllib a.mtl", "mtllib my b.mtl", r"mtllib .\sub\c.mtl"),
    ),
    ("references to other files: texture maps, shadow objects, called files", check_other_files),
]


def check_comments_at_faces(folder: Path) -> None:
    round_trip(folder, "a.obj", "# first\n" + TETRA + "f 1 2 3 # a/b\n#last\n")
    there = (folder / "out" / "out.obj").read_text()
    assert there.startswith("# first\n") and there.endswith("f 1/1 2/2 3/3 # a/b\n#last\n")


CELLS = [
    *(Cell("OBJ", "OBJ", what, "kept", act) for what, act in OBJ_CELLS),
    Cell(
        "OBJ",
        "OBJ",
        "texture coordinates of polylines and free-form surfaces",
        "warning",
        check_old_texture_of_lines,
        "the texture coordinates of free-form surfaces (surf) and polylines (l)",
    ),
    Cell(
        "OBJ",
        "OBJ",
        "images of materials, without a baked image",
        "warning",
        check_images("out.obj"),
        "its materials have 1 image for the old texture coordinates",
    ),
    Cell("OBJ", "OBJ", "images of materials, with `--bake texture`", "kept", check_moved_images("out.obj")),
    Cell("OBJ", "GLB", "images of materials, with `--bake texture`", "kept", check_moved_images("out.glb")),
    Cell(
        "OBJ",
        "GLB",
        "the old (first) texture coordinates, with `--texcoord 1`",
        "kept",
        check_second_set("out.glb"),
    ),
    Cell(
        "OBJ",
        "PLY",
        "the old (first) texture coordinates, with `--texcoord 1`",
        "kept",
        check_second_set("out.ply"),
    ),
    Cell(
        "OBJ",
        "OBJ",
        "the old (first) texture coordinates, with `--texcoord 1` (preserved; a second file has the new set)",
        "warning",
        check_second_set("out.obj"),
        "OBJ holds one set of texture coordinates: the second set is in out_texcoord1.obj",
    ),
    Cell(
        "OBJ",
        "OBJ",
        "images of materials, with a baked image",
        "warning",
        check_images("out.obj", image=True),
        "the new library leaves them out",
    ),
    Cell(
        "OBJ",
        "OBJ",
        "lines that are not OBJ statements (copied unchanged)",
        "warning",
        check_foreign_line,
        "are not OBJ statements",
    ),
    Cell("OBJ", "PLY", "vertex numbers, including unreferenced vertices", "kept", check_vertex_numbers),
    Cell("OBJ", "PLY", "vertex colours", "kept", check_obj_colours(COLOURED, RGBY, "out.ply")),
    Cell(
        "OBJ",
        "PLY",
        "vertex colours in the range from 0 to 255",
        "kept",
        check_obj_colours(BYTES, RGBY, "out.ply"),
    ),
    Cell(
        "OBJ",
        "PLY",
        "vertex colours at only some vertices (all other vertices become white)",
        "kept",
        check_obj_colours(SOME, [*RGBY[:3], [1, 1, 1]], "out.ply"),
    ),
    Cell(
        "OBJ",
        "PLY",
        "vertex colours from ZBrush (#MRGB)",
        "kept",
        check_obj_colours(PAINTED, RGBY, "out.ply"),
    ),
    Cell("OBJ", "PLY", "normals, including several per vertex", "kept", check_obj_normals("out.ply")),
    Cell(
        "OBJ",
        "PLY",
        "comments",
        "kept",
        check_comments("a.obj", "# Größe\n" + TETRA + FACES, "out.ply", ["Größe"]),
    ),
    Cell(
        "OBJ",
        "PLY",
        "names of objects or groups",
        "warning",
        check_obj(TETRA + "g a\n" + FACES, "out.ply"),
        "the names of its parts",
    ),
    Cell(
        "OBJ",
        "PLY",
        "materials",
        "warning",
        check_obj(TETRA + "usemtl a\n" + FACES, "out.ply"),
        "its materials",
    ),
    Cell("OBJ", "GLB", "names of objects or groups", "kept", check_parts("out.glb")),
    Cell("OBJ", "GLB", "normals", "kept", check_obj(TETRA + "vn 0 0 1\nf 1//1 2//1 3//1\n", "out.glb")),
    Cell("OBJ", "GLB", "vertex colours", "kept", check_obj_colours(COLOURED, RGBY, "out.glb")),
    Cell(
        "OBJ",
        "GLB",
        "comments (written to the extras of the glTF asset)",
        "kept",
        check_comments("a.obj", "# Größe\n" + TETRA + FACES, "out.gltf", ["Größe"]),
    ),
    Cell(
        "OBJ",
        "GLB",
        "names that are not valid UTF-8 (replaced by distinct escape codes)",
        "warning",
        check_latin_names("out.glb"),
        "the exact names (\\xba\\xec, \\xc2\\xcc)",
    ),
    Cell(
        "OBJ", "GLB", "images of materials", "warning", check_images("out.glb"), "the images of its materials"
    ),
    Cell(
        "OBJ",
        "GLB",
        "material properties that glTF does not have",
        "warning",
        check_unsupported_material_keys,
        "Ks, Ns of its materials",
    ),
    *(
        Cell("OBJ", "others", what, "warning", check_obj(TETRA + text + FACES, "out.glb"), says)
        for what, text, says in (
            ("groups within objects", "o a\ng b\n", "groups (g) within its objects"),
            ("smoothing groups of a mesh without normals", "s 1\n", "smoothing groups (s)"),
            ("polylines", "l 1 2\n", "polylines (l)"),
            ("points", "p 1\n", "points (p)"),
            ("free-form curves and surfaces", "vp 1 1\ncurv 0 1 1 2\n", "free-form curves and surfaces"),
            ("display attributes", "bevel on\n", "display attributes"),
            ("texture maps in `usemap` statements", "usemap a\n", "texture maps (usemap)"),
            ("other files that `call` statements include", "call a.mod\n", "calls of other files"),
            ("vertex weights", "v 0 0 0 0.5\n", "numbers after the positions of its vertices"),
            (
                "normals at some corners only",
                "vn 0 0 1\nf 1//1 2//1 3//1\n",
                "normals, which not all corners have",
            ),
        )
    ),
    Cell(
        "PLY",
        "PLY",
        "all elements and properties, including lists; references to vertex numbers",
        "kept",
        check_ply_tables(False),
    ),
    Cell(
        "PLY",
        "PLY",
        "all elements and properties of polygon meshes (copies of seam vertices follow the originals)",
        "kept",
        check_ply_tables(True),
    ),
    Cell(
        "PLY",
        "PLY",
        "texture coordinates at faces (`texcoord`), and their image numbers",
        "kept",
        check_ply_lists,
    ),
    Cell("PLY", "PLY", "triangle strips (written as faces)", "kept", check_ply_strips),
    Cell("PLY", "PLY", "comments and obj_info, byte for byte", "kept", check_ply_comments),
    Cell(
        "PLY",
        "PLY",
        "user-defined properties of triangle strips",
        "warning",
        check_labelled_ply_strips,
        "without their properties label",
    ),
    Cell(
        "PLY",
        "PLY",
        "image references (`TextureFile`), with paths relative to the new folder",
        "warning",
        check_ply_images,
        "its materials have 1 image for the old texture coordinates",
    ),
    Cell("PLY", "OBJ", "vertex colours", "kept", check_ply_colours("out.obj")),
    Cell(
        "PLY",
        "OBJ",
        "vertex colours in properties with other names, such as r, g, b or diffuse_red",
        "kept",
        check_ply_colours("out.obj", ("r", "g", "b")),
    ),
    Cell(
        "PLY",
        "OBJ",
        "comments",
        "kept",
        check_comments("a.ply", make_ply(comments="comment a scan\n"), "out.obj", ["a scan"]),
    ),
    Cell(
        "PLY",
        "OBJ",
        "alpha of vertex colours",
        "warning",
        check_round_trip(
            "a.ply",
            make_ply(
                vertex="".join(f"property uchar {c}\n" for c in ("red", "green", "blue", "alpha")),
                rows=("1 2 3 4", "", ""),
            ),
            "out.obj",
        ),
        "the alpha of its colours",
    ),
    Cell("PLY", "GLB", "vertex colours", "kept", check_ply_colours("out.glb")),
    Cell("PLY", "GLB", "face colours", "kept", check_face_colours_in_glb),
    Cell(
        "PLY",
        "OBJ",
        "face colours",
        "warning",
        check_round_trip("a.ply", make_ply(face=SHADES, rows=("", "1 2 3", "")), "out.obj"),
        "the colours of its faces",
    ),
    *(
        Cell(
            "PLY",
            "others",
            what,
            "warning",
            check_round_trip("a.ply", make_ply(**given, rows=rows), "out.glb"),
            says,
        )
        for what, given, rows, says in (
            (
                "user-defined properties of vertices",
                {"vertex": "property float quality\n"},
                ("0.5", "", ""),
                "the properties quality of its vertex element",
            ),
            (
                "user-defined properties of faces",
                {"face": "property int label\n"},
                ("", "7", ""),
                "the properties label of its face element",
            ),
            (
                "user-defined elements",
                {"more": "element camera 1\nproperty float focus\n"},
                ("", "", "0.5\n"),
                "the elements camera",
            ),
            (
                "image references (`TextureFile`)",
                {"comments": "comment TextureFile a.png\n"},
                ("", "", ""),
                "its images",
            ),
        )
    ),
    Cell("OFF", "OBJ", "normals, colours and texture coordinates of vertices", "kept", check_off_vertices),
    Cell(
        "OFF",
        "OBJ",
        "comments",
        "kept",
        check_comments("a.off", make_off("OFF", comment="# by hand"), "out.obj", ["by hand"]),
    ),
    Cell(
        "OFF",
        "PLY",
        "face colours",
        "kept",
        check_face_colours(
            "a.off", make_off("OFF", face="25# 0 51"), [[(250 + i) / 255, 0, 0.2] for i in range(4)]
        ),
    ),
    Cell(
        "OFF",
        "PLY",
        "face colours at only some faces (all other faces get the default grey of Geomview)",
        "kept",
        check_face_colours(
            "a.off",
            make_off("OFF").replace("3 0 2 1", "3 0 2 1 1 0 0 0.5"),
            [[1, 0, 0, 0.5], *[[170 / 255] * 3 + [1]] * 3],
        ),
    ),
    Cell(
        "OFF",
        "others",
        "face colours",
        "warning",
        check_round_trip("a.off", make_off("OFF", face="255 0 0"), "out.obj"),
        "the colours of its faces",
    ),
    Cell(
        "OFF",
        "others",
        "indices into a colour map, after the vertex indices of a face",
        "warning",
        check_round_trip("a.off", make_off("OFF", face="7"), "out.obj"),
        "numbers after the corners of its faces",
    ),
    Cell(
        "OFF",
        "others",
        "further numbers of vertices that the header does not declare",
        "warning",
        check_round_trip("a.off", make_off("OFF", "1 2"), "out.obj"),
        "numbers after the positions of its vertices",
    ),
    Cell(
        "OFF",
        "GLB",
        "vertex colours, if the faces also have colours",
        "warning",
        check_vertex_and_face_colours,
        "the colours of its vertices",
    ),
    Cell(
        "OFF",
        "any",
        "binary files",
        "error",
        check_round_trip("a.off", "OFF BINARY\n", "out.obj"),
        "export it as text",
    ),
    Cell(
        "OFF",
        "any",
        "vertex positions that are not three-dimensional (4OFF, nOFF)",
        "error",
        check_round_trip("a.off", "4OFF\n", "out.obj"),
        "in three dimensions",
    ),
    Cell("STL", "OBJ", "names of solids, in text files", "kept", check_solids),
    Cell(
        "STL",
        "OBJ",
        "header of a binary file (written as a comment)",
        "kept",
        check_comments("a.stl", make_stl(b"by hand", [0, 0]), "out.obj", ["by hand"]),
    ),
    Cell(
        "STL",
        "PLY",
        "triangle colours (VisCAM, SolidView)",
        "kept",
        check_face_colours("a.stl", make_stl(b"", [0x8000 | 31 << 10 | 31, 0]), [[1, 0, 1], [1, 1, 1]]),
    ),
    Cell(
        "STL",
        "PLY",
        "triangle colours (Magics)",
        "kept",
        check_face_colours("a.stl", make_stl(MAGICS, [31 << 5, 0x8000]), [[0, 1, 0], [1, 0, 0.2]]),
    ),
    Cell(
        "STL",
        "OBJ",
        "triangle colours",
        "warning",
        check_round_trip("a.stl", make_stl(b"", [0x8001, 0]), "out.obj"),
        "the colours of its faces",
    ),
    Cell(
        "STL",
        "others",
        "Magics materials",
        "warning",
        check_round_trip("a.stl", make_stl(MAGICS + b",MATERIAL=" + bytes(12), [0, 0]), "out.ply"),
        "MATERIAL= of its title",
    ),
    Cell(
        "STL",
        "others",
        "attribute bytes that are not colours",
        "warning",
        check_round_trip("a.stl", make_stl(b"", [7, 0]), "out.ply"),
        "attribute bytes of its triangles",
    ),
    Cell(
        "STL",
        "others",
        "bytes after the last triangle",
        "warning",
        check_round_trip("a.stl", make_stl(b"", [0, 0], b"end"), "out.ply"),
        "3 bytes follow face 1",
    ),
]
