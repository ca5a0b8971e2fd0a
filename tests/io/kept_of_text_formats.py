"""What OBJ, PLY, OFF and STL files have, and what becomes of it."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
from kept import Cell, carried

from igl_linabf import Packing, bake_texture, unwrap
from igl_linabf.io import MeshFile, image_maps, read_file, write_file, write_image

TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
MAPPED = "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 2/2 3/3 4/1\nf 1/1 4/2 3/3\n"
FACES = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
LATIN = b"\272\354", b"\302\314"  # two names that are not UTF-8


def same_corners(before: MeshFile, after: MeshFile) -> None:
    """Positions and texture coordinates at the corners."""
    assert after.polygons.sizes.tolist() == before.polygons.sizes.tolist()
    np.testing.assert_allclose(
        after.V[after.polygons.corners], before.V[before.polygons.corners], atol=1e-6, rtol=1e-6
    )
    np.testing.assert_allclose(after.TC[after.texture], before.TC[before.texture], atol=1e-6)


def obj(text: str | bytes, to: str = "out.obj", name: str = "a.obj") -> Callable[[Path], object]:
    """An OBJ file with this text comes back with the same corners."""
    return lambda folder: same_corners(*carried(folder, name, text, to))


def lines_of_obj(*lines: str) -> Callable[[Path], object]:
    """An OBJ file comes back with these lines, in their order, between its vertices and its faces."""

    def act(folder: Path) -> None:
        text = TETRA + "\n".join(lines) + "\n" + FACES
        same_corners(*carried(folder, "a.obj", text))
        there = (folder / "out" / "out.obj").read_text().splitlines()
        assert [line for line in there if line.split()[0] not in ("vt", "f")] == [
            line for line in text.splitlines() if line.split()[0] != "f"
        ]

    return act


def two_names(to: str, *, image: bool = False) -> Callable[[Path], object]:
    """Two materials whose names are not UTF-8, in OBJ and MTL, stay two, with the colours of each."""

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
        after = read_file(folder / "out" / to)
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


def names_of_obj(folder: Path) -> None:
    """Names with blanks, several of them, and # are told apart."""
    names = ["a b", "a  b", "a#1", "a#2", "Größe 1", "a"]
    text = TETRA + "".join(f"usemtl {name}\no {name}\nf 1 2 3\n" for name in names)
    before, after = carried(folder, "a.obj", text)
    assert before.materials == after.materials == before.parts == after.parts == tuple(names)


def libraries(*lines: str) -> Callable[[Path], object]:
    """The libraries of an OBJ file are found from another folder; the first that has a material counts."""

    def act(folder: Path) -> None:
        (folder / "in" / "sub").mkdir(parents=True)
        (folder / "in" / "sub" / "c.mtl").write_text("newmtl c\nKd 0.3 0 0\n")
        (folder / "in" / "a.mtl").write_text("newmtl a\nKd 0.1 0 0\n")
        (folder / "in" / "my b.mtl").write_text("newmtl b\nKd 0.2 0 0\nnewmtl a\nKd 0.9 0 0\n")
        text = "\n".join(lines) + "\n" + TETRA + "usemtl a\nf 1 3 2\nusemtl b\nf 1 2 4\nusemtl c\nf 2 3 4\n"
        before, after = carried(folder, "a.obj", text)
        for mesh in (before, after):
            assert [look.colour.red for look in mesh.extras.looks] == [0.1, 0.2, 0.3]

    return act


def other_files(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "out").mkdir()
    for name in ("s.obj", "t.obj", "m.map", "m n.map", "c.mod"):
        (folder / "in" / name).write_text("")
    lines = "shadow_obj s.obj\ntrace_obj t.obj\nmaplib m.map m n.map\ncall c.mod 1 2\nshadow_obj none.obj\n"
    carried(folder, "a.obj", lines + TETRA + FACES)
    there = (folder / "out" / "out.obj").read_text().splitlines()
    assert there[:6] == [
        "shadow_obj ../in/s.obj",
        "trace_obj ../in/t.obj",
        "maplib ../in/m.map",
        "maplib ../in/m n.map",
        "call ../in/c.mod 1 2",
        "shadow_obj none.obj",
    ]


def old_texture_of_lines(folder: Path) -> None:
    carried(folder, "a.obj", TETRA + "vt 0 0\nvn 0 0 1\nl 1/1 2/1\nsurf 0 1 0 1 1/1/1 2/1 3\n" + FACES)
    there = (folder / "out" / "out.obj").read_text()
    assert "\nl 1 2\nsurf 0 1 0 1 1//1 2 3\n" in there


def foreign_line(folder: Path) -> None:
    (folder / "a.obj").write_text(TETRA + "hello\n" + FACES)
    mesh = read_file(folder / "a.obj")
    write_file(folder / "b.obj", mesh, mesh.V[:, :2])
    assert "\nhello\n" in (folder / "b.obj").read_text()


def painted_twice(folder: Path) -> None:
    text = "COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2 0 255 0\n"
    _, after = carried(folder, "a.off", text, "out.glb")
    np.testing.assert_allclose(after.colours, [[0, 1, 0]] * 3)


def shiny(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "a.mtl").write_text("newmtl a\nKd 1 0 0\nKs 1 1 1\nNs 200\nd 0.5\n")
    _, after = carried(folder, "a.obj", "mtllib a.mtl\nusemtl a\n" + TETRA + FACES, "out.glb")
    np.testing.assert_allclose(after.extras.looks[0].colour, [1, 0, 0], atol=1e-6)
    assert after.extras.looks[0].alpha == 0.5


def painted_images(to: str, *, image: bool = False) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        (folder / "in").mkdir()
        (folder / "out").mkdir()
        (folder / "in" / "a.mtl").write_text("newmtl a\nmap_Kd old.png\n")
        (folder / "in" / "a.obj").write_text("mtllib a.mtl\nusemtl a\n" + TETRA + FACES)
        mesh = read_file(folder / "in" / "a.obj")
        write_file(folder / "out" / to, mesh, mesh.V[:, :2], image=np.ones((2, 2, 3)) if image else None)

    return act


def moved_images(to: str) -> Callable[[Path], object]:
    """Images and the other lines of their materials, where they are moved."""

    def act(folder: Path) -> None:
        (folder / "in").mkdir()
        (folder / "out").mkdir()
        write_image(folder / "in" / "old.png", np.full((4, 4, 3), 0.2))
        of_obj = "Ns 7\n" * to.endswith(".obj")  # glTF has no word for it
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


def second_set(to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        (folder / "a.obj").write_text("vt 0 0\nvt 1 0\nvt 0 1\n" + TETRA + MAPPED)
        mesh = read_file(folder / "a.obj")
        write_file(folder / to, mesh, mesh.V[:, :2], texcoord=1)
        after = read_file(folder / to)
        assert np.allclose(after.TC[after.texture], mesh.TC[mesh.texture])

    return act


def colours_of_obj(lines: str, colours: list[list[float]], to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        before, after = carried(folder, "a.obj", lines + FACES, to)
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


def normals_of_obj(to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        normals = "".join(f"vn {v.removeprefix('v ')}\n" for v in TETRA.splitlines()[1:])
        faces = "f 1//1 3//2 2//3\nf 1//2 2//3 4//1\nf 2//2 3//2 4//2\n"
        before, after = carried(folder, "a.obj", TETRA + normals + faces, to)
        np.testing.assert_allclose(
            after.extras.normals[after.extras.normal], before.extras.normals[before.extras.normal]
        )
        same_corners(before, after)

    return act


def comments(name: str, data: str | bytes, to: str, wanted: list[str]) -> Callable[[Path], object]:
    """The comments are in the new file."""

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


def parts_in(to: str) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        before, after = carried(folder, "a.obj", TETRA + "g a\nf 1 3 2\nf 1 2 4\ng b\nf 2 3 4\n", to)
        assert before.parts == after.parts == ("a", "b")
        assert after.extras.parts[1].tolist() == [0, 0, 1]

    return act


def numbers_of_vertices(folder: Path) -> None:
    """Vertices of an OBJ file, one of which no face has, are those of the PLY file, in their order."""
    before, after = carried(folder, "a.obj", TETRA + "v 9 9 9\n" + FACES, "out.ply")
    assert (after.V == before.V).all()
    assert (after.polygons.corners == before.polygons.corners).all()
    same_corners(before, after)


def ply(
    vertex: str = "",
    face: str = "",
    more: str = "",
    comments: str = "",
    rows: tuple[str, str, str] = ("", "", ""),
    quads: bool = False,
) -> bytes:
    """A tetrahedron, or a box of quadrangles, with more properties, their numbers in rows, and elements."""
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


def tables_of_ply(quads: bool) -> Callable[[Path], object]:
    """All elements and properties, lists too; numbers of vertices name the same places."""

    def act(folder: Path) -> None:
        before, after = carried(folder, "a.ply", ply(**TABLE, rows=ROWS, quads=quads), "out.ply")
        same_corners(before, after)
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
            assert lists.take(np.arange(n)).values.tolist() == old["vertex"]["seen_by"].values.tolist()
        ends = [np.concatenate([t["edge"][k].values for k in ("vertex1", "vertex2")]) for t in (old, new)]
        assert (after.V[ends[1].astype(int)] == before.V[ends[0].astype(int)]).all()
        assert "texcoord" in new["face"] or quads

    return act


def comments_of_ply(folder: Path) -> None:
    lines = "comment  two  blanks\nobj_info num_cols 5\ncomment caf\xe9\n"
    carried(folder, "a.ply", ply(comments=lines), "out.ply")
    assert lines.encode("latin-1") in (folder / "out" / "out.ply").read_bytes()


def images_of_ply(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "my skin.png").write_text("")
    carried(folder, "a.ply", ply(comments="comment TextureFile my skin.png\n"), "out.ply")
    assert b"\ncomment TextureFile ../in/my skin.png\n" in (folder / "out" / "out.ply").read_bytes()


def lists_of_ply(folder: Path) -> None:
    """Texture coordinates of lists at faces come in, and go out where there are seams."""
    data = ply(
        face="property list uchar float texcoord\nproperty int texnumber\n", rows=("", "6 0 0 1 0 1 # 3", "")
    )
    (folder / "read.ply").write_bytes(data)
    read = read_file(folder / "read.ply")
    assert read.TC[read.texture].reshape(-1, 3, 2)[2].tolist() == [[0, 0], [1, 0], [1, 2]]
    before, after = carried(folder, "a.ply", data, "out.ply")
    same_corners(before, after)
    assert len(after.V) == 4
    assert after.extras.source.tables["face"]["texnumber"].values.tolist() == [3] * 4


def colours_of_ply(to: str, names: tuple[str, ...] = ("red", "green", "blue")) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        vertex = "".join(f"property uchar {name}\n" for name in names)
        before, after = carried(folder, "a.ply", ply(vertex=vertex, rows=("25# 0 51", "", "")), to)
        wanted = np.array([[250 + i, 0, 51] for i in range(4)]) / 255
        np.testing.assert_allclose(before.colours, wanted)
        np.testing.assert_allclose(
            after.colours[after.polygons.corners][:, :3], wanted[before.polygons.corners], atol=1e-6
        )

    return act


def strips_of_ply(folder: Path) -> None:
    data = (
        ply()
        .replace(b"element face 4", b"element tristrips 1")
        .replace(b"3 0 2 1 \n3 0 1 3 \n3 1 2 3 \n3 0 3 2 \n", b"7 0 1 2 3 -1 0 1\n")
    )
    before, after = carried(folder, "a.ply", data.replace(b"list uchar", b"list int"), "out.ply")
    assert before.triangles.tolist() == [[0, 1, 2], [2, 1, 3]]
    same_corners(before, after)


def labelled_strips_of_ply(folder: Path) -> None:
    data = ply().replace(b"face 4", b"tristrips 1").replace(b"indices\n", b"indices\nproperty int label\n")
    carried(folder, "a.ply", data.partition(b"3 0 2 1")[0] + b"4 0 1 2 3 7\n", "out.ply")


def carry(name: str, data: bytes | str, to: str) -> Callable[[Path], object]:
    return lambda folder: same_corners(*carried(folder, name, data, to))


SHADES = "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))


def colours_of_faces_in_glb(folder: Path) -> None:
    """Its vertices are doubled where faces differ."""
    data = off("OFF", face="25# 0 51")
    before, after = carried(folder, "a.off", data, "out.glb")
    at = after.extras.corner_colours[::3]
    np.testing.assert_allclose(at[:, :3], before.extras.face_colours, atol=1e-6)
    np.testing.assert_allclose(at[:, 0] * 255, [250, 251, 252, 253], atol=1e-4)


def off(head: str, vertex: str = "", face: str = "", comment: str = "") -> str:
    V, F = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"], ["3 0 2 1", "3 0 1 3", "3 1 2 3", "3 0 3 2"]
    rows = [f"{row} {vertex.replace('#', str(i))}" for i, row in enumerate(V)]
    rows += [f"{row} {face.replace('#', str(i))}" for i, row in enumerate(F)]
    return "\n".join([head, *[comment] * bool(comment), "4 4 0", *rows, ""])


def at_vertices_of_off(folder: Path) -> None:
    """All three after the positions; whole numbers are colours to 255."""
    data = off("STCNOFF", "0 0.6 0.8 25# 0 51 255 0.# 0.5")
    before, after = carried(folder, "a.off", data)
    np.testing.assert_allclose(before.extras.normals, [[0, 0.6, 0.8]] * 4)
    np.testing.assert_allclose(before.colours * 255, [[250 + i, 0, 51, 255] for i in range(4)])
    np.testing.assert_allclose(after.colours, before.colours[:, :3])
    np.testing.assert_allclose(after.extras.normals[after.extras.normal], [[0, 0.6, 0.8]] * 12)
    mesh = read_file(folder / "in" / "a.off")
    assert mesh.TC[mesh.texture][:3].tolist() == [[0, 0.5], [0.2, 0.5], [0.1, 0.5]]
    (folder / "f.off").write_text(off("COFF", "0.# 0 1"))
    np.testing.assert_allclose(read_file(folder / "f.off").colours[:, 0], [0, 0.1, 0.2, 0.3])


def face_colours(name: str, data: str | bytes, wanted: list[list[float]]) -> Callable[[Path], object]:
    def act(folder: Path) -> None:
        before, after = carried(folder, name, data, "out.ply")
        np.testing.assert_allclose(before.extras.face_colours, wanted)
        np.testing.assert_allclose(after.extras.face_colours, wanted, atol=0.003)

    return act


SOLIDS = "".join(
    f"solid {name}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {z}\nvertex 1 0 {z}\nvertex 0 1 {z}\nendloop\n"
    f"endfacet\nendsolid {name}\n"
    for z, name in enumerate(("left wheel", "", "right wheel"))
)


def solids(folder: Path) -> None:
    before, after = carried(folder, "a.stl", SOLIDS.replace("solid \n", "solid axle\n"))
    assert before.parts == after.parts == ("left wheel", "axle", "right wheel")
    assert after.extras.parts[1].tolist() == [0, 1, 2]


def stl(title: bytes, more: list[int], rest: bytes = b"") -> bytes:
    faces = [((0, 0, 0), (0, 1, 0), (1, 0, 0)), ((0, 0, 0), (1, 0, 0), (0, 0, 1))]
    rows = [struct.pack("<12fH", 0, 0, 0, *sum(face, ()), own) for face, own in zip(faces, more, strict=True)]
    return title.ljust(80, b"\0") + struct.pack("<I", 2) + b"".join(rows) + rest


MAGICS = b"made COLOR=" + bytes([255, 0, 51, 255])
OBJ_CELLS = [
    ("polygons in their order, negative indices", obj(TETRA + "v 1 1 0\nf 1 3 5 2\nf -5 -4 -2\n")),
    (
        "vertex colours, weights and further values of vertices",
        lines_of_obj("v 1 2 3 0.5", "v 1 2 3 0.1 0.2 0.3"),
    ),
    ("unreferenced vertices", lines_of_obj("v 9 9 9")),
    ("normals", normals_of_obj("out.obj")),
    (
        "objects, groups within objects, several groups on a line, smoothing and merging groups",
        lines_of_obj("o a", "g b c", "g", "s 1", "mg 1 0.5", "o d", "g e", "s off"),
    ),
    ("points and polylines", lines_of_obj("p 1 2", "l 1 2 -1")),
    (
        "free-form curves and surfaces",
        lines_of_obj(
            "vp 0.1 0.2", "cstype rat bspline", "deg 3", "curv 0 1 1 2 3 4", "surf 0 1 0 1 1//1 2", "end"
        ),
    ),
    ("display attributes", lines_of_obj("bevel on", "c_interp on", "lod 2", "ctech cparm 1", "usemap skin")),
    ("comments, including those on face lines", lambda folder: _comments_at_faces(folder)),
    ("names with spaces, with #, in any script", names_of_obj),
    ("names that are not UTF-8, byte for byte", two_names("out.obj")),
    (
        "names that are not UTF-8, with a baked image: the new library has the same bytes",
        two_names("out.obj", image=True),
    ),
    ("several material libraries on a line", libraries("mtllib a.mtl my b.mtl sub/c.mtl")),
    ("quoted library names", libraries('mtllib "a.mtl" "my b.mtl"', 'mtllib "sub/c.mtl"')),
    (
        "library names with spaces or backslashes",
        libraries("mtllib a.mtl", "mtllib my b.mtl", r"mtllib .\sub\c.mtl"),
    ),
    ("references to other files: maps, shadows, calls", other_files),
]


def _comments_at_faces(folder: Path) -> None:
    carried(folder, "a.obj", "# first\n" + TETRA + "f 1 2 3 # a/b\n#last\n")
    there = (folder / "out" / "out.obj").read_text()
    assert there.startswith("# first\n") and there.endswith("f 1/1 2/2 3/3 # a/b\n#last\n")


CELLS = [
    *(Cell("OBJ", "OBJ", what, "kept", act) for what, act in OBJ_CELLS),
    Cell(
        "OBJ",
        "OBJ",
        "texture coordinates of polylines and free-form surfaces",
        "warning",
        old_texture_of_lines,
        "the texture coordinates of free-form surfaces (surf) and polylines (l)",
    ),
    Cell(
        "OBJ",
        "OBJ",
        "material images, with the original library",
        "warning",
        painted_images("out.obj"),
        "1 images of its materials were made for the old texture coordinates",
    ),
    Cell("OBJ", "OBJ", "material images, with `--bake texture`", "kept", moved_images("out.obj")),
    Cell("OBJ", "GLB", "material images, with `--bake texture`", "kept", moved_images("out.glb")),
    Cell("OBJ", "GLB", "first texture coordinates, with `--texcoord 1`", "kept", second_set("out.glb")),
    Cell("OBJ", "PLY", "first texture coordinates, with `--texcoord 1`", "kept", second_set("out.ply")),
    Cell(
        "OBJ",
        "OBJ",
        "first texture coordinates, with `--texcoord 1` (kept; the second set is in another file)",
        "warning",
        second_set("out.obj"),
        "OBJ holds one set of texture coordinates: the second set is in out_texcoord1.obj",
    ),
    Cell(
        "OBJ",
        "OBJ",
        "material images, with a baked image",
        "warning",
        painted_images("out.obj", image=True),
        "the new library leaves them out",
    ),
    Cell(
        "OBJ",
        "OBJ",
        "lines that are not OBJ statements (copied unchanged)",
        "warning",
        foreign_line,
        "are not OBJ statements",
    ),
    Cell("OBJ", "PLY", "vertex numbers, including unreferenced vertices", "kept", numbers_of_vertices),
    Cell("OBJ", "PLY", "vertex colours", "kept", colours_of_obj(COLOURED, RGBY, "out.ply")),
    Cell("OBJ", "PLY", "vertex colours from 0 to 255", "kept", colours_of_obj(BYTES, RGBY, "out.ply")),
    Cell(
        "OBJ",
        "PLY",
        "vertex colours at some vertices; the remaining vertices become white",
        "kept",
        colours_of_obj(SOME, [*RGBY[:3], [1, 1, 1]], "out.ply"),
    ),
    Cell(
        "OBJ", "PLY", "vertex colours from ZBrush (#MRGB)", "kept", colours_of_obj(PAINTED, RGBY, "out.ply")
    ),
    Cell("OBJ", "PLY", "normals, including several per vertex", "kept", normals_of_obj("out.ply")),
    Cell(
        "OBJ", "PLY", "comments", "kept", comments("a.obj", "# Größe\n" + TETRA + FACES, "out.ply", ["Größe"])
    ),
    Cell(
        "OBJ",
        "PLY",
        "objects or groups",
        "warning",
        obj(TETRA + "g a\n" + FACES, "out.ply"),
        "the names of its parts",
    ),
    Cell("OBJ", "PLY", "materials", "warning", obj(TETRA + "usemtl a\n" + FACES, "out.ply"), "its materials"),
    Cell("OBJ", "GLB", "objects, or groups", "kept", parts_in("out.glb")),
    Cell("OBJ", "GLB", "normals", "kept", obj(TETRA + "vn 0 0 1\nf 1//1 2//1 3//1\n", "out.glb")),
    Cell("OBJ", "GLB", "vertex colours", "kept", colours_of_obj(COLOURED, RGBY, "out.glb")),
    Cell(
        "OBJ",
        "GLB",
        "comments, in the extras of the asset",
        "kept",
        comments("a.obj", "# Größe\n" + TETRA + FACES, "out.gltf", ["Größe"]),
    ),
    Cell(
        "OBJ",
        "GLB",
        "names that are not UTF-8 (replaced by distinct escape codes)",
        "warning",
        two_names("out.glb"),
        "the exact names (\\xba\\xec, \\xc2\\xcc)",
    ),
    Cell(
        "OBJ", "GLB", "material images", "warning", painted_images("out.glb"), "the images of its materials"
    ),
    Cell(
        "OBJ",
        "GLB",
        "material properties that glTF does not have",
        "warning",
        shiny,
        "Ks, Ns of its materials",
    ),
    *(
        Cell("OBJ", "others", what, "warning", obj(TETRA + text + FACES, "out.glb"), says)
        for what, text, says in (
            ("groups within objects", "o a\ng b\n", "groups (g) within its objects"),
            ("smoothing groups, without normals", "s 1\n", "smoothing groups (s)"),
            ("polylines", "l 1 2\n", "polylines (l)"),
            ("points", "p 1\n", "points (p)"),
            ("free-form curves and surfaces", "vp 1 1\ncurv 0 1 1 2\n", "free-form curves and surfaces"),
            ("display attributes", "bevel on\n", "display attributes"),
            ("texture maps", "usemap a\n", "texture maps (usemap)"),
            ("calls of other files", "call a.mod\n", "calls of other files"),
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
        tables_of_ply(False),
    ),
    Cell(
        "PLY",
        "PLY",
        "the same with polygons; copies of seam vertices follow all original vertices",
        "kept",
        tables_of_ply(True),
    ),
    Cell(
        "PLY", "PLY", "texture coordinates at faces (texcoord) and their image numbers", "kept", lists_of_ply
    ),
    Cell("PLY", "PLY", "triangle strips, as faces", "kept", strips_of_ply),
    Cell("PLY", "PLY", "comments and obj_info, byte for byte", "kept", comments_of_ply),
    Cell(
        "PLY",
        "PLY",
        "other properties of triangle strips",
        "warning",
        labelled_strips_of_ply,
        "without their properties label",
    ),
    Cell(
        "PLY",
        "PLY",
        "images (TextureFile), with paths relative to the new folder",
        "warning",
        images_of_ply,
        "1 images of its materials were made for the old texture coordinates",
    ),
    Cell("PLY", "OBJ", "vertex colours", "kept", colours_of_ply("out.obj")),
    Cell(
        "PLY",
        "OBJ",
        "vertex colours under other names: r, g, b and diffuse_red, ...",
        "kept",
        colours_of_ply("out.obj", ("r", "g", "b")),
    ),
    Cell(
        "PLY",
        "OBJ",
        "comments",
        "kept",
        comments("a.ply", ply(comments="comment a scan\n"), "out.obj", ["a scan"]),
    ),
    Cell(
        "PLY",
        "OBJ",
        "alpha of vertex colours",
        "warning",
        carry(
            "a.ply",
            ply(
                vertex="".join(f"property uchar {c}\n" for c in ("red", "green", "blue", "alpha")),
                rows=("1 2 3 4", "", ""),
            ),
            "out.obj",
        ),
        "the alpha of its colours",
    ),
    Cell("PLY", "GLB", "vertex colours", "kept", colours_of_ply("out.glb")),
    Cell("PLY", "GLB", "face colours", "kept", colours_of_faces_in_glb),
    Cell(
        "PLY",
        "OBJ",
        "face colours",
        "warning",
        carry("a.ply", ply(face=SHADES, rows=("", "1 2 3", "")), "out.obj"),
        "the colours of its faces",
    ),
    *(
        Cell("PLY", "others", what, "warning", carry("a.ply", ply(**given, rows=rows), "out.glb"), says)
        for what, given, rows, says in (
            (
                "other properties of vertices",
                {"vertex": "property float quality\n"},
                ("0.5", "", ""),
                "the properties quality of its vertex element",
            ),
            (
                "other properties of faces",
                {"face": "property int label\n"},
                ("", "7", ""),
                "the properties label of its face element",
            ),
            (
                "other elements",
                {"more": "element camera 1\nproperty float focus\n"},
                ("", "", "0.5\n"),
                "the elements camera",
            ),
            ("images (TextureFile)", {"comments": "comment TextureFile a.png\n"}, ("", "", ""), "its images"),
        )
    ),
    Cell("OFF", "OBJ", "normals, colours and texture coordinates of vertices", "kept", at_vertices_of_off),
    Cell(
        "OFF",
        "OBJ",
        "comments",
        "kept",
        comments("a.off", off("OFF", comment="# by hand"), "out.obj", ["by hand"]),
    ),
    Cell(
        "OFF",
        "PLY",
        "face colours",
        "kept",
        face_colours("a.off", off("OFF", face="25# 0 51"), [[(250 + i) / 255, 0, 0.2] for i in range(4)]),
    ),
    Cell(
        "OFF",
        "PLY",
        "face colours at some faces; the remaining faces get Geomview's grey",
        "kept",
        face_colours(
            "a.off",
            off("OFF").replace("3 0 2 1", "3 0 2 1 1 0 0 0.5"),
            [[1, 0, 0, 0.5], *[[170 / 255] * 3 + [1]] * 3],
        ),
    ),
    Cell(
        "OFF",
        "others",
        "face colours",
        "warning",
        carry("a.off", off("OFF", face="255 0 0"), "out.obj"),
        "the colours of its faces",
    ),
    Cell(
        "OFF",
        "others",
        "colour map indices after faces",
        "warning",
        carry("a.off", off("OFF", face="7"), "out.obj"),
        "numbers after the corners of its faces",
    ),
    Cell(
        "OFF",
        "others",
        "numbers that the header does not declare",
        "warning",
        carry("a.off", off("OFF", "1 2"), "out.obj"),
        "numbers after the positions of its vertices",
    ),
    Cell(
        "OFF",
        "GLB",
        "vertex colours, if faces have colours, too",
        "warning",
        painted_twice,
        "the colours of its vertices",
    ),
    Cell(
        "OFF", "any", "binary files", "error", carry("a.off", "OFF BINARY\n", "out.obj"), "export it as text"
    ),
    Cell(
        "OFF",
        "any",
        "dimensions other than three (4OFF, nOFF)",
        "error",
        carry("a.off", "4OFF\n", "out.obj"),
        "in three dimensions",
    ),
    Cell("STL", "OBJ", "names of solids, in text files", "kept", solids),
    Cell(
        "STL",
        "OBJ",
        "header of a binary file, as a comment",
        "kept",
        comments("a.stl", stl(b"by hand", [0, 0]), "out.obj", ["by hand"]),
    ),
    Cell(
        "STL",
        "PLY",
        "triangle colours (VisCAM, SolidView)",
        "kept",
        face_colours("a.stl", stl(b"", [0x8000 | 31 << 10 | 31, 0]), [[1, 0, 1], [1, 1, 1]]),
    ),
    Cell(
        "STL",
        "PLY",
        "triangle colours (Magics)",
        "kept",
        face_colours("a.stl", stl(MAGICS, [31 << 5, 0x8000]), [[0, 1, 0], [1, 0, 0.2]]),
    ),
    Cell(
        "STL",
        "OBJ",
        "triangle colours",
        "warning",
        carry("a.stl", stl(b"", [0x8001, 0]), "out.obj"),
        "the colours of its faces",
    ),
    Cell(
        "STL",
        "others",
        "Magics materials",
        "warning",
        carry("a.stl", stl(MAGICS + b",MATERIAL=" + bytes(12), [0, 0]), "out.ply"),
        "MATERIAL= of its title",
    ),
    Cell(
        "STL",
        "others",
        "attribute bytes that are not colours",
        "warning",
        carry("a.stl", stl(b"", [7, 0]), "out.ply"),
        "attribute bytes of its triangles",
    ),
    Cell(
        "STL",
        "others",
        "bytes after the last triangle",
        "warning",
        carry("a.stl", stl(b"", [0, 0], b"end"), "out.ply"),
        "3 bytes follow face 1",
    ),
]
