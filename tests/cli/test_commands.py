"""The command writes files and prints tables, and reports each error in one sentence."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from argparse import ArgumentTypeError
from importlib import metadata
from itertools import chain

import igl
import numpy as np
import pytest
from commands import run, run_in_new_process
from conftest import load, read_pixels
from gltf_files import write_scene

from igl_linabf import linabf, quality
from igl_linabf.cli import main
from igl_linabf.cli.arguments import parse_axis
from igl_linabf.cli.doctor import EXTRAS
from igl_linabf.cli.parser import COMMANDS, make_command_parser, read_docstring
from igl_linabf.io import unit_square, write_mesh


@pytest.fixture
def mesh(tmp_path):
    path = tmp_path / "bumps.obj"
    igl.write_triangle_mesh(str(path), *load("bumps"))
    return path


def test_flatten_writes_the_map_and_prints_its_quality(mesh, tmp_path) -> None:
    out, picture = tmp_path / "flat.obj", tmp_path / "flat.png"
    process = run_in_new_process("flatten", mesh, "-o", out, "--picture", picture)
    assert process.returncode == 0, process.stderr
    assert process.stderr == ""
    V, F = igl.read_triangle_mesh(str(mesh))
    _, coordinates, _, faces, corners, _ = igl.readOBJ(str(out))
    uv = np.empty((len(V), 2))
    uv[faces] = coordinates[corners][..., :2]
    assert uv.min() == 0
    assert uv.max() == 1
    expected = linabf(V, F)
    scale = 1 / np.ptp(expected, axis=0).max()
    assert np.allclose(uv, (expected - expected.min(axis=0)) * scale)
    measured = quality(V, F, uv)
    assert measured.flips == 0
    assert f"{measured.angle_distortion:.4g}" in process.stdout
    assert read_pixels(picture).shape[:2] == (700, 1400)


def test_units_methods_and_options_are_applied(mesh, tmp_path, capsys) -> None:
    out = tmp_path / "flat.obj"
    V, F = igl.read_triangle_mesh(str(mesh))
    for options in (
        ["--iterations", "2"],
        ["--method", "lscm"],
        ["--layout", "greedy", "--solver", "direct"],
    ):
        assert main(["flatten", str(mesh), "-o", str(out), "--units", "mesh", *options]) == 0
        _, coordinates, _, _, corners, _ = igl.readOBJ(str(out))
        areas = igl.doublearea(np.ascontiguousarray(coordinates[:, :2]), corners)
        assert np.isclose(areas.sum(), igl.doublearea(V, F).sum())
    assert "greedy" in capsys.readouterr().out


ERRORS = {
    "missing file": (["flatten", "nothing.obj", "-o", "{tmp}/x.obj"], "nothing.obj: No such file"),
    "not a mesh": (["flatten", "{tmp}/text.obj", "-o", "{tmp}/x.obj"], "text.obj holds 0 vertices"),
    "closed": (["flatten", "{tmp}/closed.off", "-o", "{tmp}/x.obj"], "the mesh is closed"),
    "folder": (["flatten", "{mesh}", "-o", "{tmp}/none/x.obj"], "folder is missing"),
    "output format": (["flatten", "{mesh}", "-o", "{tmp}/x.fbx"], "does not end in .obj"),
    "picture format": (
        ["flatten", "{mesh}", "-o", "{tmp}/x.obj", "--picture", "a.bmp"],
        "does not end in .png",
    ),
    "no output": (["flatten", "{mesh}"], "required: -o"),
    "iterations": (["flatten", "{mesh}", "-o", "{tmp}/x.obj", "--iterations", "0"], "iterations is 0"),
    "iterations text": (
        ["flatten", "{mesh}", "-o", "{tmp}/x.obj", "--iterations", "x"],
        "--iterations is 'x'",
    ),
    "method": (["flatten", "{mesh}", "-o", "{tmp}/x.obj", "--method", "magic"], "invalid choice"),
    "meaningless": (
        ["flatten", "{mesh}", "-o", "{tmp}/x.obj", "--method", "lscm", "--iterations", "2"],
        "--iterations is not an option of the method lscm",
    ),
    "compare methods": (["compare", "{mesh}", "--methods", "lscm,magic"], "method is 'magic'"),
    "compare picture": (["compare", "{mesh}", "--picture", "x.gif"], "does not end in .png"),
    "compare repeat": (["compare", "{mesh}", "--repeat", "0"], "repeat is 0"),
    "compare closed": (["compare", "{tmp}/closed.off"], "the mesh is closed"),
    "no command": ([], "required: COMMAND"),
}


@pytest.mark.parametrize("name", ERRORS)
def test_errors_are_one_sentence_with_exit_code_2(name: str, mesh, tmp_path) -> None:
    (tmp_path / "text.obj").write_text("hello world\n")
    igl.write_triangle_mesh(str(tmp_path / "closed.off"), *igl.icosahedron())
    arguments, message = ERRORS[name]
    before = sorted(tmp_path.iterdir())
    call = run_in_new_process if name == "missing file" else run
    process = call(*(a.format(tmp=tmp_path, mesh=mesh) for a in arguments))
    assert process.returncode == 2
    assert process.stdout == ""
    assert len(process.stderr.splitlines()) == 1
    assert process.stderr.startswith("igl-linabf: ")
    assert message in process.stderr
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere, and on Windows anyone"
)
def test_an_unwritable_folder_is_one_sentence(mesh, tmp_path) -> None:
    folder = tmp_path / "locked"
    folder.mkdir(mode=0o500)
    process = run("flatten", mesh, "-o", folder / "x.obj")
    assert process.returncode == 2
    assert len(process.stderr.splitlines()) == 1


def test_a_picture_that_fails_leaves_nothing(mesh, tmp_path, monkeypatch, capsys) -> None:
    from igl_linabf import plot

    def broken(*_: object, **__: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(plot, "plot_compare", broken)
    out, picture = tmp_path / "x.obj", tmp_path / "x.png"
    assert main(["flatten", str(mesh), "-o", str(out), "--picture", str(picture)]) == 2
    assert capsys.readouterr().err == "igl-linabf: no space left on device\n"
    assert not picture.exists()


@pytest.mark.parametrize("name", ["stress__flipfree_deer.obj", "limb"])
def test_a_map_with_flips_is_written_and_reported(tmp_path, name: str) -> None:
    V, F = load(name)
    mesh, out = tmp_path / "deer.obj", tmp_path / "flat.obj"
    igl.write_triangle_mesh(str(mesh), V, F)
    process = run("flatten", mesh, "-o", out)
    assert process.returncode == 1
    assert "flipped or collapsed" in process.stderr
    assert process.stderr.splitlines()[-1].startswith("igl-linabf: faces")
    assert out.exists()


def test_each_warning_is_one_line(tmp_path) -> None:
    V, F = load("bumps")
    mesh = tmp_path / "loose.off"
    igl.write_triangle_mesh(str(mesh), np.vstack((V, [9, 9, 9])), F)
    process = run("flatten", mesh, "-o", tmp_path / "flat.obj")
    assert process.returncode == 0
    assert process.stderr == (
        f"igl-linabf: warning: vertices {len(V)} belong to no face: they are left out and their uv is NaN\n"
    )


def test_doctor_lists_installed_packages() -> None:
    process = run("doctor")
    assert process.returncode == 0
    assert f"  numpy {np.__version__}\n" in process.stdout
    assert "CHOLMOD: " in process.stdout
    extras = re.search(r"^Extras.*:\n((?:  .*\n)+)", process.stdout, re.MULTILINE)[1]
    assert [line.partition(":")[0].strip() for line in extras.splitlines()] == sorted(EXTRAS)
    for name in chain.from_iterable(EXTRAS.values()):
        try:
            found = metadata.version(name)
        except metadata.PackageNotFoundError:
            found = "not installed"
        assert f" {name} {found}" in extras


def list_options(command: str) -> set[str]:
    """Return the long options that the help of a command lists."""
    described = run(command, "--help").stdout.split("options:")[1].split("examples:")[0]
    return set(re.findall(r"--[a-z][a-z-]*", described))


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_has_an_example_and_every_example_is_valid(command: str) -> None:
    shown: set[str] = set()
    _, _, examples = read_docstring(COMMANDS[command])
    for example in examples:
        words = shlex.split(re.split(r" +[#<>]", example)[0])
        make_command_parser().parse_args([command, *words])  # exits the process on an error
        shown.update(word for word in words if word.startswith("-"))
    shown = {"--output" if word == "-o" else word for word in shown}
    missing = list_options(command) - shown - {"--help"}
    assert not missing, f"{command} --help has no example of {missing}"


def test_several_meshes_are_written_to_a_folder_and_a_bad_one_is_reported(mesh, tmp_path) -> None:
    igl.write_triangle_mesh(str(tmp_path / "ball.off"), *igl.icosahedron())
    (tmp_path / "bad.off").write_text("OFF\n1 1 0\n")
    (tmp_path / "maps").mkdir()
    process = run("unwrap", tmp_path / "b*.o*", "-o", tmp_path / "maps", "--format", "ply", "--json")
    assert process.returncode == 2
    (line,) = (line for line in process.stderr.splitlines() if "warning" not in line)
    assert line.count("bad.off") == 1
    assert sorted(path.name for path in (tmp_path / "maps").iterdir()) == ["ball.ply", "bumps.ply"]
    ball, bumps = (json.loads(line) for line in process.stdout.splitlines())
    assert ball["mesh"].endswith("ball.off")
    assert ball["good"] is True
    assert ball["atlas"]["quality"]["faces"] == 20
    assert bumps["atlas"]["charts"][0]["result"]["outcome"] == "valid"


def test_two_meshes_with_the_same_output_are_refused_before_the_computation(mesh, tmp_path) -> None:
    (tmp_path / "other").mkdir()
    shutil.copy(mesh, tmp_path / "other" / mesh.name)
    process = run("flatten", mesh, tmp_path / "other" / mesh.name, "-o", tmp_path)
    assert process.returncode == 2
    assert "would both be written to" in process.stderr
    assert process.stdout == ""


@pytest.mark.parametrize("suffix", [".obj", ".off", ".ply", ".stl"])
def test_a_mesh_in_a_pipe_gives_the_map_of_the_file(suffix: str, tmp_path) -> None:
    path = tmp_path / f"piped{suffix}"
    igl.write_triangle_mesh(str(path), *load("bumps"))
    command = [sys.executable, "-m", "igl_linabf", "unwrap", "-", "-o", "-", "--quiet", "--method", "lscm"]
    process = subprocess.run(command, input=path.read_bytes(), capture_output=True, timeout=500)
    assert process.returncode == 0, process.stderr
    expected = tmp_path / "expected.obj"
    assert run("unwrap", path, "-o", expected, "--method", "lscm").returncode == 0
    assert process.stdout == expected.read_bytes()


def test_quiet_prints_nothing_and_json_and_a_map_do_not_share_stdout(mesh, tmp_path) -> None:
    assert run("flatten", mesh, "-o", tmp_path / "x.obj", "--quiet").stdout == ""
    process = run("flatten", mesh, "-o", "-", "--json")
    assert process.returncode == 2
    assert "leave one out" in process.stderr


def test_json_has_the_figures_of_the_api(mesh, tmp_path) -> None:
    process = run("flatten", mesh, "-o", tmp_path / "x.obj", "--json", "--units", "mesh")
    output = json.loads(process.stdout)
    V, F = igl.read_triangle_mesh(str(mesh))
    figures = dataclasses.asdict(quality(V, F, linabf(V, F)))
    figures |= figures.pop("report")
    assert output["quality"] == pytest.approx(figures)
    assert output["result"]["attempts"][0]["name"] == "linear step"
    assert "uv" not in output["result"]


def test_axes_and_directions_are_parsed() -> None:
    given = {"y": [0, 1, 0], "+x": [1, 0, 0], "-z": [0, 0, -1], "0,-1,0.5": [0, -1, 0.5]}
    assert {text: parse_axis(text) for text in given} == given
    for text in ("w", "--z", "1,2", "x,y,z"):
        with pytest.raises(ArgumentTypeError, match="is not a direction: give x, y, z"):
            parse_axis(text)


def test_figures_without_a_number_are_null(tmp_path, capsys) -> None:
    V, F = load("bumps")
    write_mesh(tmp_path / "one.obj", V, F, unit_square(linabf(V, F)))
    main(["check", str(tmp_path / "one.obj"), "--json"])
    assert (
        json.loads(capsys.readouterr().out)["check"]["margin"] is None
    )  # infinite, because there is only one chart


def test_tables_are_printed_on_stderr_if_the_map_is_on_stdout(mesh, tmp_path, capfdbinary) -> None:
    assert main(["flatten", str(mesh), "-o", str(tmp_path / "flat.obj")]) == 0
    table = capfdbinary.readouterr().out
    assert main(["flatten", str(mesh), "-o", "-"]) == 0
    streams = capfdbinary.readouterr()
    assert streams.out == (tmp_path / "flat.obj").read_bytes()
    # only the last line, which states the seconds, differs
    assert streams.err.splitlines()[:5] == table.splitlines()[:5]


def test_files_left_out_on_standard_output_are_reported(tmp_path, capfdbinary) -> None:
    write_scene(tmp_path / "in.glb")
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", "-", "--quiet"]) == 0
    assert b"standard output holds one file: map.mtl beside it are left out" in capfdbinary.readouterr().err


def test_pictures_ignore_faces_without_area(tmp_path, capsys) -> None:
    box = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    for text, code in ((f"{box}f 1 1 2\n", 0), (f"{box[:32]}f 1 1 2\n", 2)):
        (tmp_path / "in.obj").write_text(text)
        given = [
            str(tmp_path / "in.obj"),
            "-o",
            str(tmp_path / "out.obj"),
            "--picture",
            str(tmp_path / "p.png"),
        ]
        assert main(["unwrap", *given]) == code
        assert (tmp_path / "p.png").exists() == (tmp_path / "out.obj").exists() == (code == 0)
        for name in ("p.png", "out.obj"):
            (tmp_path / name).unlink(missing_ok=True)
    assert "has an area, and a picture would be empty: leave it out" in capsys.readouterr().err


def test_a_folder_is_not_a_mesh_and_patterns_skip_folders(mesh, tmp_path, capsys) -> None:
    (tmp_path / "in" / "more").mkdir(parents=True)
    shutil.copy(mesh, tmp_path / "in" / "one.obj")
    assert main(["unwrap", str(tmp_path / "in"), "-o", str(tmp_path / "one.obj")]) == 2
    assert "is a folder: give its files, or use igl-linabf batch" in capsys.readouterr().err
    assert main(["unwrap", str(tmp_path / "in" / "*"), "-o", str(tmp_path / "one.obj"), "--quiet"]) == 0
    assert (tmp_path / "one.obj").exists()
    assert "folder" not in capsys.readouterr().err
