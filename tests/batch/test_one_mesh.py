"""The table row of a mesh has its outcome and its warnings; the whole batch ends if the storage is full."""

from __future__ import annotations

import errno
import os
import sys
from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
import pytest
from conftest import load
from overlapping_surfaces import spiral

from igl_linabf import ChartOptions, unwrap
from igl_linabf.batch import BakedPacking, flatten_files, one_mesh, places
from igl_linabf.batch.one_mesh import Settings, Task, run_task
from igl_linabf.batch.table import Row
from igl_linabf.charts import AtlasBounds
from igl_linabf.cli import main
from igl_linabf.flattening import resolve_method
from igl_linabf.io import read_file, write_textured


def read_mesh_charts(path: Path) -> np.ndarray:
    """Return the chart of each face of a mesh file."""
    mesh = read_file(path)
    return igl.facet_components(mesh.FTC)[1]


def process_mesh(folder: Path, V: np.ndarray, F: np.ndarray, how: str = "unwrap") -> Row:
    """Process a mesh, and return its row of the table."""
    (folder / "out").mkdir(exist_ok=True)
    igl.write_triangle_mesh(str(folder / "in.off"), V, F)
    settings = Settings(how, resolve_method("linabf"), "obj")
    row = Row(str(folder / "in.off"), "a.obj")
    return run_task(Task(str(folder / "in.off"), row, str(folder / "out"), settings))


def test_a_row_has_the_outcome_and_the_warnings(tmp_path: Path) -> None:
    V, F = load("bumps")
    row = process_mesh(tmp_path, np.vstack((V, [9, 9, 9])), F, "flatten")
    assert (row.outcome, row.triangles, row.charts, row.flips) == ("valid", len(F), 1, 0)
    assert row.message == f"vertices {len(V)} belong to no face: they are left out and their uv is NaN"
    row = process_mesh(tmp_path, *spiral(), "flatten")
    assert row.outcome == "overlapping" and "the map overlaps itself" in row.message and not row.good
    row = process_mesh(tmp_path, *igl.icosahedron(), "flatten")
    assert row.outcome == "refused"
    assert "the mesh is closed" in row.message
    assert row.charts is None


def test_pipes_and_dangling_links_are_failed_rows_and_other_meshes_are_processed(tmp_path: Path) -> None:
    if sys.platform == "win32":
        pytest.skip("Windows has no named pipes in folders")
    folder = tmp_path / "in"
    folder.mkdir()
    igl.write_triangle_mesh(str(folder / "good.obj"), *load("bumps"))
    os.mkfifo(folder / "pipe.obj")
    (folder / "link.obj").symlink_to("nowhere")
    (folder / "loop.obj").symlink_to("loop.obj")
    settings, outcomes = Settings("flatten", resolve_method("linabf"), "obj"), {}
    for file in places.find_inputs([folder, folder / "pipe.obj"], str(tmp_path / "out")):
        row = run_task(Task(file.place, Row(file.place, file.name), str(tmp_path / "out"), settings))
        outcomes[file.name] = row.outcome, row.message
    assert outcomes.pop("good.obj") == ("valid", "")
    assert outcomes.pop("link.obj") == ("unreadable", os.strerror(errno.ENOENT))
    assert outcomes.pop("loop.obj") == ("unreadable", os.strerror(errno.ELOOP))
    ((outcome, message),) = outcomes.values()
    assert outcome == "refused"
    assert "pipe.obj is a folder, a pipe or a device" in message


def test_seams_and_materials_of_a_file_are_those_of_its_map(tmp_path: Path) -> None:
    V, F = igl.upsample(*igl.icosahedron(), 1)
    old = unwrap(V, F, charts=ChartOptions(labels=np.arange(len(F)) % 4))
    names = [f"usemtl {'red' if k else 'blue'}" for k in V[F].mean(axis=1)[:, 2] > 0]
    lines = [f"v {x} {y} {z}" for x, y, z in V] + [f"vt {u} {v}" for u, v in old.TC]
    corners = np.stack((F, old.FTC), axis=-1) + 1
    faces = [" ".join(("f", *(f"{v}/{vt}" for v, vt in row))) for row in corners.tolist()]
    lines += [line for pair in zip(names, faces, strict=True) for line in pair]
    (tmp_path / "in.obj").write_text("\n".join(lines))
    (tmp_path / "out").mkdir()
    plain = Settings("unwrap", resolve_method("isometric"), "obj", packing=BakedPacking(cut_below=0))
    charts = {}
    for name, options in {
        "found": {},
        "given": {"seams": "uv"},
        "materials": {"keep_materials": True},
    }.items():
        row = Row(str(tmp_path / "in.obj"), f"{name}.obj")
        done = run_task(Task(row.input, row, str(tmp_path / "out"), replace(plain, **options)))
        assert done.outcome == "valid", done.message
        charts[name] = read_mesh_charts(tmp_path / "out" / f"{name}.obj")
    assert len(np.unique(charts["found"])) == 1
    assert len(np.unique(charts["given"])) == len(old.charts)
    of = charts["materials"]
    assert len(np.unique(of)) == 2 and all(len(set(np.array(names)[of == k])) == 1 for k in np.unique(of))


def test_flips_overlaps_and_other_troubles_have_different_outcomes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    V, F = igl.loop(*igl.icosahedron(), 2)
    atlas = unwrap(V, F, progress=False)
    (chart, *others) = atlas.charts
    for outcome, made, message in (
        ("valid", atlas, ""),
        ("flipped", replace(atlas, quality=replace(atlas.quality, flips=1)), "so small"),
        (
            "overlapping",
            replace(atlas, charts=(replace(chart, overlapping=2), *others)),
            "lies over itself in 2",
        ),
        (
            "faulty",
            replace(atlas, report=replace(atlas.report, bounds=AtlasBounds(max_stretch=1.0))),
            "has an L2 stretch of",
        ),
    ):
        monkeypatch.setattr(one_mesh, "unwrap", lambda *_, made=made, **__: made)
        row = process_mesh(tmp_path, V, F)
        assert row.outcome == outcome
        assert message in row.message


def test_a_full_disk_is_raised_and_other_errors_are_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(one_mesh, "write_atomically", full)
    with pytest.raises(OSError, match="No space"):
        process_mesh(tmp_path, *igl.icosahedron())
    monkeypatch.setattr(one_mesh, "unwrap", lambda *_, **__: 1 / 0)
    row = process_mesh(tmp_path, *igl.icosahedron())
    assert (row.outcome, row.message) == ("failed", "ZeroDivisionError: division by zero")


@pytest.mark.parametrize(
    ("suffix", "options"),
    [
        ("obj", ["--bake", "colours", "--resolution", "64"]),
        ("glb", ["--bake", "texture", "--resolution", "64", "--seams", "uv"]),
        ("obj", ["--texcoord", "1"]),
    ],
)
def test_baked_and_second_coordinates_are_those_of_unwrap(
    suffix: str, options: list[str], tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    V, F = igl.icosahedron()
    atlas = unwrap(V, F)
    image = np.random.default_rng(0).random((8, 8, 3))
    write_textured(tmp_path / "in.glb", V, F, atlas.TC, atlas.FTC, image)
    words = [*options, "--format", suffix]
    (tmp_path / "one").mkdir()
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", str(tmp_path / "one"), *words, "--quiet"]) == 0
    out = tmp_path / "many"
    assert main(["batch", str(tmp_path / "in.glb"), "-o", str(out), "--workers", "1", *words]) == 0
    one = {path.name: path.read_bytes() for path in (tmp_path / "one").iterdir()}
    many = {path.name: path.read_bytes() for path in out.glob("in*")}
    assert many == one and (suffix == "glb") == (len(one) == 1)


def test_a_batch_refuses_what_it_cannot_bake(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    igl.write_triangle_mesh(str(tmp_path / "in.off"), *igl.icosahedron())
    for options, message in (
        ({"bake": "normals", "format": "ply"}, "which a baked texture needs"),
        ({"bake": "normals", "texcoord": 1}, "leave out texcoord=1"),
        ({"bake": "light"}, "bake is 'light'"),
        ({"texcoord": 1, "how": "flatten"}, "not options of flatten"),
    ):
        with pytest.raises(ValueError, match=message):
            flatten_files(tmp_path / "in.off", tmp_path / "out", **options)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "in.png").touch()
    with pytest.raises(FileExistsError, match=r"in\.png"):
        flatten_files(tmp_path / "in.off", tmp_path / "out", bake="normals")
    for packing, texcoord in ((BakedPacking(bake="texture"), 0), (BakedPacking(), 1)):
        settings = Settings("unwrap", resolve_method("lscm"), "obj", packing=packing, texcoord=texcoord)
        row = Row(str(tmp_path / "in.off"), "a.obj")
        row = run_task(Task(row.input, row, str(tmp_path / "out"), settings))
        assert row.outcome == "refused" and "has no texture coordinates" in row.message
