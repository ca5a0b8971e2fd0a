"""Files from untrusted sources are refused or read correctly, with bounded memory and time."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest
from PIL import Image

from igl_linabf import MeshError, MeshWarning
from igl_linabf.cli import main
from igl_linabf.io import image_maps, read_file, write_file

pytest.importorskip("resource", reason="limits of a process are POSIX's")

import attacks
from fuzzing import run_all

PACKAGES = {
    "Draco": "DracoPy",
    "meshopt": "meshopt",
    "3MF": "lib3mf",
    "GIFTI": "nibabel",
    "FreeSurfer": "nibabel",
    "VTP": "pyvista",
}


def is_installed(name: str) -> bool:
    package = PACKAGES.get(name.partition(":")[0])
    return package is None or importlib.util.find_spec(package) is not None


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit the memory of a process")
def test_each_attack_ends_as_the_table_says() -> None:
    results = run_all([(name, 0) for name in attacks.ATTACKS if is_installed(name)], attacks.__file__, 600)
    wrong = []
    for name, (ends, broken) in results.items():
        wrong += broken
        wanted = attacks.ATTACKS[name][1]
        wrong += [f"{name}: {end}, not {wanted}" for end in ends if end != wanted]
    assert not wrong, "\n".join(wrong)


def test_references_outside_the_folder_are_followed_if_they_are_allowed(tmp_path: Path) -> None:
    folder, outside = tmp_path / "in", tmp_path / "textures"
    folder.mkdir()
    outside.mkdir()
    Image.new("RGB", (2, 2), (255, 0, 0)).save(outside / "red.png")
    (outside / "a.mtl").write_text("newmtl red\nKd 1 0 0\nmap_Kd red.png\n")
    obj = attacks.write_obj(folder, "mtllib ../textures/a.mtl\nusemtl red\n")
    with pytest.warns(MeshWarning, match=r"\.\./textures/a\.mtl are outside .* allow_outside=True"):
        assert read_file(obj).extras.looks is None
    (image,) = image_maps(read_file(obj, allow_outside=True))["baseColorTexture"]
    assert image.pixels[0, 0].tolist() == [1, 0, 0]
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    text = attacks.make_gltf_text(
        images=[{"uri": "../textures/red.png"}], textures=[{"source": 0}], materials=[material]
    )
    text["meshes"][0]["primitives"][0]["material"] = 0
    gltf = attacks.write_gltf(folder, text)
    with pytest.raises(MeshError, match=r"\.\./textures/red\.png leads out of .* allow_outside=True"):
        read_file(gltf)
    command = ["unwrap", str(gltf), "-o", str(tmp_path / "out.glb"), "--quiet"]
    assert main(command) == 2
    assert main([*command, "--allow-outside"]) == 0
    (image,) = image_maps(read_file(tmp_path / "out.glb"))["baseColorTexture"]
    assert image.pixels[0, 0].tolist() == [1, 0, 0]


def test_arrays_in_files_beside_a_gifti_file_are_read_and_written_into_the_new_file(tmp_path: Path) -> None:
    pytest.importorskip("nibabel")
    (tmp_path / "data").mkdir()
    vertices = attacks.V32.tobytes()
    faces = attacks.F.astype("<i4").tobytes()
    (tmp_path / "data" / "a.dat").write_bytes(vertices + faces)
    text = attacks.gifti("", "ExternalFileBinary", name="data/a.dat").decode()
    points, triangles = text.split("</DataArray>")[:2]
    triangles = triangles.replace('Dim0="12"', 'Dim0="20"').replace('Offset=""', f'Offset="{len(vertices)}"')
    triangles = triangles.replace("</Data>", "</Data></DataArray>")
    further = points[points.index("<DataArray") :].replace("POINTSET", "SHAPE") + "</DataArray>"
    path = tmp_path / "a.surf.gii"
    path.write_text(f"{points}</DataArray>{triangles}{further}</GIFTI>")
    mesh = read_file(path)
    assert (mesh.V == attacks.V32).all()
    assert (mesh.triangles == attacks.F).all()
    (tmp_path / "new").mkdir()
    with pytest.warns(MeshWarning, match="does not keep the positions"):
        write_file(tmp_path / "new" / "out.surf.gii", mesh, mesh.V[:, :2])
    shape = importlib.import_module("nibabel").load(tmp_path / "new" / "out.surf.gii").darrays[2]
    assert (shape.data == attacks.V32).all()


def test_images_that_pillow_decodes_by_another_program_are_not_decoded(tmp_path: Path, monkeypatch) -> None:
    path = attacks.write_textured_gltf(tmp_path, attacks.POSTSCRIPT)
    opened = importlib.import_module("PIL.EpsImagePlugin").EpsImageFile
    monkeypatch.setattr(opened, "load", lambda _: pytest.fail("Pillow would run Ghostscript"))
    with pytest.raises(MeshError, match="cannot be read as an image"):
        image_maps(read_file(path))


def test_links_between_folders_inside_are_followed(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "a.mtl").write_text("newmtl red\nKd 1 0 0\n")
    (tmp_path / "link.mtl").symlink_to(tmp_path / "data" / "a.mtl")
    (tmp_path / "here").symlink_to(tmp_path)
    attacks.write_obj(tmp_path, "mtllib data/../link.mtl\nusemtl red\n")
    assert read_file(tmp_path / "here" / "a.obj").extras.looks[0].colour == (1, 0, 0)
