"""Files of many primitives take time and memory in proportion to their size."""

from __future__ import annotations

import tracemalloc
import warnings
from pathlib import Path

import igl
import numpy as np
import pytest
from gltf_files import write_glb

from igl_linabf import MeshWarning, unwrap
from igl_linabf.io import read_file, write_file, write_mesh

V, F = igl.upsample(*igl.icosahedron(), 4)


def write_shared_buffer(path: Path, primitives: int) -> None:
    """Write a sphere whose primitives share one vertex buffer, like the files of CAD exporters."""
    parts = np.array_split(F.astype("<u4"), primitives)
    accessors = [{"bufferView": 0, "componentType": 5126, "count": len(V), "type": "VEC3"}]
    accessors += [
        {"bufferView": i, "componentType": 5125, "count": part.size, "type": "SCALAR"}
        for i, part in enumerate(parts, 1)
    ]
    entries = [{"attributes": {"POSITION": 0}, "indices": i} for i in range(1, primitives + 1)]
    text = {"asset": {"version": "2.0"}, "meshes": [{"primitives": entries}], "accessors": accessors}
    write_glb(path, text, [V.astype("<f4").tobytes(), *(part.tobytes() for part in parts)])


def test_primitives_of_a_shared_buffer_have_their_own_vertices(tmp_path: Path) -> None:
    write_shared_buffer(tmp_path / "in.glb", 320)
    tracemalloc.start()
    mesh = read_file(tmp_path / "in.glb")
    write_file(tmp_path / "out.glb", mesh, mesh.V[:, :2])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    size = (tmp_path / "in.glb").stat().st_size
    assert peak < 50 * size  # 360 * size if each primitive had all vertices
    assert mesh.V.shape == V.shape and (mesh.V[mesh.triangles] == V.astype("f4")[F]).all()
    text = read_file(tmp_path / "out.glb").extras.source.gltf.text
    counts = [
        text["accessors"][primitive["attributes"]["POSITION"]]["count"]
        for primitive in text["meshes"][0]["primitives"]
    ]
    assert len(counts) == 320 and max(counts) <= 3 * 16


@pytest.mark.parametrize("faces", [100, 1000])
def test_materials_that_look_the_same_share_a_primitive_if_there_are_many(faces: int, tmp_path: Path) -> None:
    lines = [f"v {x} {y} {z}" for x, y, z in V.tolist()]
    for i, (a, b, c) in enumerate((F[:faces] + 1).tolist()):
        lines += [f"usemtl m{i}", f"f {a} {b} {c}"]
    (tmp_path / "in.obj").write_text("mtllib in.mtl\n" + "\n".join(lines))
    library = "".join(f"newmtl m{i}\nKd {i % 3 / 2} 1 1\n" for i in range(faces))
    (tmp_path / "in.mtl").write_text(library)
    mesh = read_file(tmp_path / "in.obj")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        write_file(tmp_path / "out.glb", mesh, mesh.V[:, :2])
    text = read_file(tmp_path / "out.glb").extras.source.gltf.text
    says = [str(warning.message) for warning in caught if "3 different appearances" in str(warning.message)]
    assert len(text["meshes"][0]["primitives"]) == (faces if faces < 256 else 3)
    assert len(says) == (faces > 256)


def test_rounding_is_reported_once_where_a_texel_could_move(tmp_path: Path) -> None:
    """Small parts of a large map do not cause warnings of their own; they are rounded like the whole map."""
    write_shared_buffer(tmp_path / "in.glb", 100)
    mesh = read_file(tmp_path / "in.glb")
    atlas = unwrap(mesh.V, mesh.F)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_file(tmp_path / "out.glb", mesh, atlas.TC, atlas.FTC)
        write_mesh(tmp_path / "new.glb", mesh.V, mesh.F, atlas.TC + 9, atlas.FTC)
    with pytest.warns(MeshWarning, match="TC is rounded") as caught:
        write_file(tmp_path / "out.glb", mesh, atlas.TC + 3e3, atlas.FTC)
    assert len(caught) == 1
