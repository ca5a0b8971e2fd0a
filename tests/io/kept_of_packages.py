"""Checks of what remains of the contents of 3MF, GIFTI, FreeSurfer and VTP files in each format."""

from __future__ import annotations

import gzip
import struct
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import igl
import numpy as np
import pytest
from kept import Cell, round_trip

from igl_linabf.io import read_file, write_file

P = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
F = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
OPEN = igl.icosahedron()[0], igl.icosahedron()[1][1:]

SCHEMA = "http://schemas.microsoft.com/3dmanufacturing"
SPACES = f'xmlns="{SCHEMA}/core/2015/02" xmlns:m="{SCHEMA}/material/2015/02" xmlns:a="http://acme.com/cut"'
TYPES = (
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
    "</Types>"
)
RELATIONS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    f'<Relationship Id="r" Target="/3D/{{}}.model" Type="{SCHEMA}/2013/01/3dmodel"/></Relationships>'
)
COLOURS = '<m:colorgroup id="8"><m:color color="#FF0000"/><m:color color="#0000FF80"/></m:colorgroup>'
BASES = '<basematerials id="9"><base name="PLA" displaycolor="#00FF00"/></basematerials>'


def make_tetrahedron(each: tuple[str, ...] = ("",) * 4, of_object: str = "") -> str:
    """Return the XML of a 3MF object with attributes of its triangles."""
    points = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in P)
    faces = "".join(
        f'<triangle v1="{i}" v2="{j}" v3="{k}" {more}/>' for (i, j, k), more in zip(F, each, strict=True)
    )
    mesh = f"<mesh><vertices>{points}</vertices><triangles>{faces}</triangles></mesh>"
    return f'<object id="1" name="tetra" {of_object}>{mesh}</object>'


def make_package(
    resources: str, item: str = "", of_model: str = "", head: str = "", parts: dict[str, str] | None = None
) -> bytes:
    """Return a 3MF file whose build item refers to object 1."""
    pytest.importorskip("lib3mf")
    data = BytesIO()
    build = f'<build><item objectid="1" {item}/></build>'
    with ZipFile(data, "w") as file:
        file.writestr("[Content_Types].xml", TYPES)
        file.writestr("_rels/.rels", RELATIONS.format("3dmodel"))
        text = f"<model {SPACES} {of_model}>{head}<resources>{resources}</resources>{build}</model>"
        file.writestr("3D/3dmodel.model", text)
        for name, text in (parts or {}).items():
            file.writestr(name, text)
    return data.getvalue()


def check_units_and_names(folder: Path) -> None:
    data = make_package(make_tetrahedron(), 'transform="0 1 0 -1 0 0 0 0 1 5 0 0"', 'unit="inch"')
    before, after = round_trip(folder, "a.3mf", data, "out.3mf")
    assert before.units == after.units == "in"
    assert before.parts == after.parts == ("tetra",)
    assert np.allclose(before.V, np.array(P) @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] + [5, 0, 0])
    assert np.allclose(after.V[after.triangles], before.V[before.triangles])


def check_metadata(folder: Path) -> None:
    head = '<metadata name="Title">A tetrahedron</metadata>'
    data = make_package(make_tetrahedron(of_object='type="support"'), 'partnumber="7"', head=head)
    before, after = round_trip(folder, "a.3mf", data, "out.3mf")
    assert before.extras.source == after.extras.source
    assert after.extras.source.metadata[0][1:3] == ("Title", "A tetrahedron")
    assert after.extras.source.numbers == ("7",)


def check_colours(folder: Path) -> None:
    each = ('pid="8" p1="0" p2="1" p3="0"', 'pid="8" p1="1"', 'pid="9" p1="0"', "")
    before, after = round_trip(
        folder, "a.3mf", make_package(COLOURS + BASES + make_tetrahedron(each)), "out.glb"
    )
    red, blue, white = [1, 0, 0, 1], [0, 0, 1, 128 / 255], [1, 1, 1, 1]
    assert np.allclose(before.extras.corner_colours, [red, blue, red, *[blue] * 3, *[white] * 6])
    assert before.materials == after.materials == ("PLA",)
    _, (*of, last) = before.extras.materials
    assert (of, last) == ([-1, -1, 0], -1)
    assert np.allclose(after.extras.looks[0].colour, [0, 1, 0])
    places = {tuple(np.round(row, 6)) for row in zip(*after.V[after.polygons.corners].T, strict=True)}
    assert len(places) == 4
    colours = after.extras.source.gltf
    shades = np.concatenate(
        [
            colours.read_numbers(of["attributes"]["COLOR_0"])[colours.read_array(of["indices"])]
            for of in colours.text["meshes"][0]["primitives"]
        ]
    )
    assert sorted(np.round(shades, 3).tolist()) == sorted(
        np.round([red] * 2 + [blue] * 4 + [white] * 6, 3).tolist()
    )


def check_components(folder: Path) -> None:
    """Check a component that places an object of another part of the package, which defines the colours."""
    space = f'xmlns:p="{SCHEMA}/production/2015/06"'
    uuid = 'p:UUID="00000000-0000-0000-0000-00000000000{}"'.format
    inner = make_tetrahedron(of_object=f'pid="8" pindex="0" {uuid(1)}')
    part = f'<model {SPACES} {space} unit="inch"><resources>{COLOURS}{inner}</resources><build/></model>'
    move = 'transform="2 0 0 0 2 0 0 0 2 10 0 0"'
    component = f'<component objectid="1" p:path="/3D/other.model" {uuid(2)} {move}/>'
    outer = f'<object id="1" {uuid(3)}><components>{component}</components></object>'
    parts = {"3D/other.model": part, "3D/_rels/3dmodel.model.rels": RELATIONS.format("other")}
    of_model = f'{space} requiredextensions="p m" unit="inch"'
    mesh, after = round_trip(folder, "a.3mf", make_package(outer, uuid(4), of_model, parts=parts), "out.glb")
    assert np.allclose(mesh.V, 2 * np.array(P) + [10, 0, 0])
    assert np.allclose(mesh.colours, [1, 0, 0])
    assert np.allclose(np.ptp(after.V, axis=0), 2 * 0.0254)


def check_3mf(resources: str, folder: Path, to: str = "out.3mf", **more: Any) -> None:
    round_trip(folder, "a.3mf", make_package(resources, **more), to)


def check_strips(folder: Path) -> None:
    """Check that the triangles of a strip get the data of the strip."""
    pyvista = pytest.importorskip("pyvista")
    import vtk

    mesh = pyvista.PolyData(
        np.array([*P, (2, 0, 0), (3, 0, 0), (2, 1, 0), (3, 1, 0)], dtype=float), [3, *F[0]]
    )
    strips = vtk.vtkCellArray()
    for strip in ([4, 5, 6, 7], [0, 1, 3]):
        strips.InsertNextCell(len(strip), strip)
    mesh.SetStrips(strips)
    mesh.cell_data["label"] = [10, 20, 30]
    mesh.save(folder / "a.vtp")
    before, after = round_trip(folder, "a.vtp", (folder / "a.vtp").read_bytes(), "out.vtp")
    assert before.F.tolist() == [list(F[0]), [4, 5, 6], [6, 5, 7], [0, 1, 3]]
    assert after.extras.source.mesh.cell_data["label"].tolist() == [10, 20, 20, 30]


def make_gifti(extra: bool = True) -> bytes:
    """Return the bytes of a GIFTI surface, with more contents than points and triangles if `extra`."""
    pytest.importorskip("nibabel")
    from nibabel import gifti as g

    V, faces = OPEN
    meta = g.GiftiMetaData({"AnatomicalStructurePrimary": "CortexLeft", "GeometricType": "Pial", "Name": "p"})
    points = g.GiftiDataArray(V.astype("f4"), intent="NIFTI_INTENT_POINTSET", meta=meta)
    triangles = g.GiftiDataArray(
        faces.astype("i4"), intent="NIFTI_INTENT_TRIANGLE", meta=g.GiftiMetaData({"TopologicalType": "Open"})
    )
    image = g.GiftiImage(meta=g.GiftiMetaData({"UserName": "me"}), darrays=[points, triangles])
    if extra:
        label = g.GiftiLabel(key=3, red=1.0, green=0.0, blue=0.0, alpha=1.0)
        label.label = "V1"
        image.labeltable.labels.append(label)
        shape = np.arange(len(V), dtype="f4")
        image.add_gifti_data_array(g.GiftiDataArray(shape, intent="NIFTI_INTENT_SHAPE"))
    return bytes(image.to_bytes())


def write_flat(folder: Path, name: str, data: bytes, to: str) -> tuple[Any, Any]:
    """Read a disk, and write it with a map without seams; return the mesh and the new file."""
    source, out = folder / name, folder / to
    source.write_bytes(data)
    mesh = read_file(source)
    write_file(out, mesh, mesh.V[:, :2])
    return mesh, out


def check_gifti(folder: Path) -> None:
    import nibabel

    _, out = write_flat(folder, "a.surf.gii", make_gifti(), "out.surf.gii")
    image = nibabel.load(out)
    points, triangles, shape = image.darrays
    assert dict(image.meta) == {"UserName": "me"}
    assert [(of.key, of.label) for of in image.labeltable.labels] == [(3, "V1")]
    expected = {"AnatomicalStructurePrimary": "CortexLeft", "GeometricType": "Flat", "Name": "p"}
    assert dict(points.meta) == expected
    assert dict(triangles.meta) == {"TopologicalType": "Open"}
    assert (shape.data == np.arange(len(points.data))).all()


def check_gifti_with_seams(folder: Path) -> None:
    import nibabel

    before, _ = round_trip(folder, "a.surf.gii", make_gifti(), "out.surf.gii")
    points, triangles, shape = nibabel.load(folder / "out" / "out.surf.gii").darrays
    assert len(points.data) == before.triangles.size
    # data at vertices refer to the original vertices
    assert (shape.data[triangles.data] == before.triangles).all()
    assert triangles.meta["TopologicalType"] == "Cut"


def check_compressed_gifti(folder: Path) -> None:
    mesh, out = write_flat(folder, "a.surf.gii.gz", gzip.compress(make_gifti()), "out.surf.gii.gz")
    assert np.allclose(mesh.V, OPEN[0])
    again = read_file(out)
    assert np.allclose(again.V[:, :2], mesh.V[:, :2])
    assert (again.F == mesh.F).all()
    assert again.units == "mm"


def _flat(data: bytes, name: str, to: str, folder: Path) -> None:
    write_flat(folder, name, data, to)


def check_gifti_to_obj(folder: Path) -> None:
    round_trip(folder, "a.surf.gii", make_gifti())


def check_coordinate_systems(folder: Path) -> None:
    round_trip(
        folder,
        "a.surf.gii",
        make_gifti(extra=False).replace(b"NIFTI_XFORM_UNKNOWN", b"NIFTI_XFORM_TALAIRACH"),
    )


VOLUME = struct.pack(">3i", 2, 0, 20) + b"valid = 1\nfilename = orig.mgz\nvolume = 256 256 256\n"


def make_freesurfer() -> bytes:
    pytest.importorskip("nibabel")
    V, faces = OPEN
    head = b"\xff\xff\xfecreated by me\n\n" + struct.pack(">2i", len(V), len(faces))
    return head + V.astype(">f4").tobytes() + faces.astype(">i4").tobytes() + VOLUME


def check_surface(folder: Path) -> None:
    mesh, out = write_flat(folder, "lh.white", make_freesurfer(), "lh.surf")
    assert out.read_bytes().endswith(VOLUME)
    again = read_file(out)
    assert (again.F == mesh.F).all()
    assert np.allclose(again.V[:, :2], mesh.V[:, :2], atol=1e-6)


def check_freesurfer(to: str, folder: Path) -> None:
    write_flat(folder, "lh.white", make_freesurfer(), to)


def make_polydata(folder: Path, lines: bool = False, tangents: bool = False) -> bytes:
    pyvista = pytest.importorskip("pyvista")
    V, faces = OPEN
    mesh = pyvista.PolyData(V, np.insert(faces, 0, 3, axis=1).ravel())
    if lines:
        mesh.lines = [2, 0, 1]
    mesh.point_data["height"] = V[:, 2]
    mesh.point_data["Normals"] = V / np.linalg.norm(V, axis=1)[:, None]
    mesh.GetPointData().SetActiveAttribute("Normals", 2)
    mesh.cell_data["label"] = np.arange(mesh.n_cells)
    mesh.cell_data["shade"] = np.full((mesh.n_cells, 3), 128, np.uint8)
    mesh.field_data["scanner"] = ["A"]
    mesh.set_active_scalars("label", preference="cell")
    if tangents:
        mesh.point_data["Tangents"] = np.ones_like(V)
        mesh.GetPointData().SetActiveAttribute("Tangents", 10)
    mesh.save(folder / "source.vtp")
    return (folder / "source.vtp").read_bytes()


def check_polydata(folder: Path) -> None:
    import pyvista

    before, after = round_trip(folder, "a.vtp", make_polydata(folder), "out.vtp")
    mesh = pyvista.read(folder / "out" / "out.vtp")
    assert np.allclose(mesh.point_data["height"], mesh.points[:, 2])
    assert (mesh.cell_data["label"] == np.arange(mesh.n_cells)).all()
    assert mesh.cell_data.active_scalars_name == "label"
    assert list(mesh.field_data["scanner"]) == ["A"]
    normals = after.extras.normals[after.extras.normal]
    assert np.allclose(normals, before.extras.normals[before.extras.normal])
    assert np.allclose(after.extras.face_colours, 128 / 255)
    assert mesh.points.dtype == np.float64


def check_vtp(to: str, folder: Path, **more: bool) -> None:
    round_trip(folder, "a.vtp", make_polydata(folder, **more), to)


CELLS = [
    Cell("3MF", "3MF", "unit of length; names and build positions of objects", "kept", check_units_and_names),
    Cell("3MF", "3MF", "metadata, part numbers, object types", "kept", check_metadata),
    Cell("3MF", "GLB", "colour groups, materials and their names", "kept", check_colours),
    Cell("3MF", "GLB", "components that other parts of the 3MF package define", "kept", check_components),
    Cell(
        "3MF",
        "3MF",
        "colour groups (`--bake colors` preserves them)",
        "warning",
        partial(check_3mf, COLOURS + make_tetrahedron(of_object='pid="8" pindex="0"')),
        "3MF does not keep colours",
    ),
    Cell(
        "3MF",
        "3MF",
        "materials (`--bake colors` preserves their colours)",
        "warning",
        partial(check_3mf, BASES + make_tetrahedron(of_object='pid="9" pindex="0"')),
        "3MF does not keep its materials",
    ),
    Cell(
        "3MF",
        "GLB",
        "metadata",
        "warning",
        partial(check_3mf, make_tetrahedron(), to="out.glb", head='<metadata name="Title">A</metadata>'),
        "GLB does not keep its metadata",
    ),
    Cell(
        "3MF",
        "OBJ",
        "unit of length",
        "warning",
        partial(check_3mf, make_tetrahedron(), to="out.obj", of_model='unit="inch"'),
        "OBJ does not keep the unit of length (inch)",
    ),
    Cell(
        "3MF",
        "3MF",
        "parts of the 3MF package that other programs added",
        "warning",
        partial(check_3mf, make_tetrahedron(), parts={"Metadata/Slicer.config": "; layers"}),
        "the parts Metadata/Slicer.config of its package",
    ),
    Cell(
        "3MF",
        "3MF",
        "contents of the model in the XML namespaces of other programs",
        "warning",
        partial(check_3mf, make_tetrahedron(('a:paint="4"', "", "", ""))),
        "the contents of the namespaces a",
    ),
    Cell(
        "3MF",
        "GLB",
        "attributes of triangles that other programs added",
        "warning",
        partial(check_3mf, make_tetrahedron(("", 'paint_color="8"', "", "")), to="out.glb"),
        "the attributes paint_color of triangles",
    ),
    Cell(
        "3MF",
        "any",
        "unknown extensions that are required",
        "error",
        partial(check_3mf, make_tetrahedron(), of_model='requiredextensions="a"'),
        "it requires an extension that lib3mf does not support (http://acme.com/cut)",
    ),
    Cell(
        "GIFTI",
        "GIFTI",
        "positions in space (replaced by the flat map; metadata, labels and data arrays are preserved)",
        "warning",
        check_gifti,
        "GII does not keep the positions in space",
    ),
    Cell(
        "GIFTI",
        "GIFTI",
        "vertex numbers at seams (data arrays follow the new numbers)",
        "warning",
        check_gifti_with_seams,
        "the vertex numbers (each vertex is written once for each of its texture coordinates)",
    ),
    Cell(
        "GIFTI",
        "GIFTI",
        "positions in space, in `.gii.gz` (replaced by the flat map)",
        "warning",
        check_compressed_gifti,
        "GII.GZ does not keep the positions in space",
    ),
    Cell(
        "GIFTI",
        "OBJ",
        "metadata, labels, further data arrays",
        "warning",
        check_gifti_to_obj,
        "its metadata, its labels, its other data arrays",
    ),
    Cell("GIFTI", "OBJ", "coordinate systems", "warning", check_coordinate_systems, "its coordinate systems"),
    Cell(
        "FreeSurfer",
        ".surf",
        "positions in space (replaced by the flat map; vertex numbers and volume geometry are preserved)",
        "warning",
        check_surface,
        "SURF does not keep the positions in space",
    ),
    Cell(
        "FreeSurfer",
        ".flat",
        "geometry of the volume that the surface was made from",
        "warning",
        partial(check_freesurfer, "lh.flat"),
        "FLAT does not keep the positions in space, the volume that it was made from",
    ),
    Cell(
        "FreeSurfer",
        "OBJ",
        "geometry of the volume that the surface was made from",
        "warning",
        partial(check_freesurfer, "lh.obj"),
        "OBJ does not keep the unit of length (millimeter), the volume that it was made from",
    ),
    Cell("VTP", "VTP", "data of triangle strips (copied to their triangles)", "kept", check_strips),
    Cell(
        "VTP",
        "VTP",
        "data arrays, normals, colours, active attributes, double precision",
        "kept",
        check_polydata,
    ),
    Cell(
        "VTP",
        "VTP",
        "lines and points",
        "warning",
        partial(check_vtp, "out.vtp", lines=True),
        "VTP does not keep its lines and points",
    ),
    Cell(
        "VTP",
        "VTP",
        "tangents",
        "warning",
        partial(check_vtp, "out.vtp", tangents=True),
        "VTP does not keep its tangents",
    ),
    Cell(
        "VTP",
        "GLB",
        "data arrays",
        "warning",
        partial(check_vtp, "out.glb"),
        "GLB does not keep the arrays height, label, scanner",
    ),
]
