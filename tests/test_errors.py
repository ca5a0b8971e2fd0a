"""Tests of messages: lists of indices, checks of numbers, and the line that a warning names."""

from __future__ import annotations

import inspect
import pickle
import warnings
from contextlib import contextmanager

import igl
import numpy as np
import pytest
import trimesh

import igl_linabf
from igl_linabf import MeshError, MeshWarning
from igl_linabf._notebook import format_html_table
from igl_linabf.cli import main
from igl_linabf.errors import first_few, is_number, stack_level


def test_the_first_few_are_listed_and_all_are_counted() -> None:
    assert first_few(np.arange(5)) == "0, 1, 2, 3, 4"
    assert first_few(np.arange(6)) == "0, 1, 2, 3, 4, ... (6 in all)"
    assert first_few([[1, 2], [3, 4]], limit=1) == "[1, 2], ... (2 in all)"


def test_numbers_are_checked_against_their_bounds() -> None:
    for good in (0, 1, 0.5, np.float32(0.25), np.int8(1), np.array(1)):
        assert is_number(good, 0, 1)
    for bad in (True, np.True_, "1", b"1", None, [1], np.array([1]), np.nan, 1j, -1e-9, 1 + 1e-9, 10**400):
        assert not is_number(bad, 0, 1)
    assert is_number(np.inf) and not is_number(np.inf, 0, np.finfo(float).max)
    assert is_number(0, 0) and not is_number(0, 0, above=True)
    assert is_number(2.0, whole=True) and not is_number(2.5, whole=True)


def test_a_warning_names_the_line_that_called_the_library() -> None:
    """Neither the depth of the call nor a context manager changes the reported line."""
    inside: dict[str, object] = {
        "__name__": "igl_linabf.somewhere",
        "contextmanager": contextmanager,
        "warn": lambda level: warnings.warn("told", MeshWarning, stacklevel=level + 1),
        "stack_level": stack_level,
    }
    exec(
        "@contextmanager\ndef managed():\n    warn(stack_level())\n    yield\n"
        "def public():\n    with managed():\n        pass\n",
        inside,
    )
    with pytest.warns(MeshWarning) as told:
        inside["public"]()  # type: ignore[operator]
    assert told[0].filename == __file__


def test_control_characters_of_names_are_printed_as_codes(capsys) -> None:
    name = "a\x1b]0;pwned\x07\n\u202e.obj"
    for error in (MeshError(name), MeshWarning(name)):
        assert str(error) == "a\\x1b]0;pwned\\x07\\n\\u202e.obj"
        assert str(pickle.loads(pickle.dumps(error))) == str(error)
    assert "\x1b" not in format_html_table([[name], ["<b>" + name]])
    for command in (["check", name], ["unwrap", name, "-o", "out.obj"], ["flatten", "--" + name]):
        try:
            assert main(command) == 2
        except SystemExit as end:  # the parser exits on an invalid argument
            assert end.code == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.isprintable()


FUNCTIONS_OF_A_MESH = [
    name
    for name in igl_linabf.__all__
    if inspect.isfunction(thing := getattr(igl_linabf, name))
    and list(inspect.signature(thing).parameters)[:2] == ["V", "F"]
    and name != "write_mesh"  # begins with a path
]


@pytest.mark.parametrize("name", FUNCTIONS_OF_A_MESH)
def test_a_mesh_or_a_file_in_place_of_arrays_raises_an_error_that_says_what_to_pass(name, tmp_path) -> None:
    box = trimesh.creation.box()
    path = tmp_path / "box.obj"
    box.export(path)
    mesh = igl_linabf.io.read_file(path)
    scope = {"mesh": box, "igl_linabf": igl_linabf}
    for given, scope["mesh"] in ((box, box), (str(path), None), (path, None), (mesh, mesh)):
        with pytest.raises(ValueError, match=f"{name} takes vertices V and faces F: pass ") as error:
            getattr(igl_linabf, name)(given)
        V, F = eval(f"[{str(error.value).partition(': pass ')[2]}]", scope)
        assert np.shape(V) == (8, 3) and np.shape(F) == (12, 3)
    with pytest.raises(TypeError):
        getattr(igl_linabf, name)()
    assert len(FUNCTIONS_OF_A_MESH) > 10


def test_an_option_of_another_class_raises_an_error_that_says_where_it_belongs() -> None:
    V, F = igl.icosahedron()
    scope = vars(igl_linabf) | {name: getattr(igl_linabf, name) for name in igl_linabf.__all__}
    for name, value in (("resolution", 64), ("max_charts", 3), ("trade", 3.0), ("period", None)):
        with pytest.raises(ValueError, match=f"{name} is an option of .*: pass ") as error:
            igl_linabf.unwrap(V, F, **{name: value})
        home = eval(str(error.value).partition("=")[2], scope)
        assert getattr(home, name) == value
    for call, faces, own in (
        (igl_linabf.flatten, F[1:], "LinABF has no option 'wieght': its options are iterations, "),
        (igl_linabf.unwrap, F, "Isometric has no option 'wieght': its options are weight, "),
    ):
        with pytest.raises(ValueError, match=own):
            call(V, faces, wieght=3)


def test_a_name_of_a_subpackage_or_of_an_old_version_raises_an_error_that_says_where_it_is() -> None:
    homes = {"bake": "textures", "pack": "uv", "find_cones": "charts", "Outcome": "flattening"}
    for name, home in homes.items():
        with pytest.raises(AttributeError, match=rf"it is igl_linabf\.{home}\.{name}$"):
            getattr(igl_linabf, name)
    with pytest.raises(AttributeError, match=r"Seams': pass edges as seams=.*ChartOptions"):
        igl_linabf.Seams  # noqa: B018
    assert not [name for name in dir(igl_linabf) if name.startswith("_") and name != "__version__"]


def test_a_result_in_place_of_a_map_raises_an_error_that_says_what_to_pass() -> None:
    V, F = igl.icosahedron()
    atlas, result = igl_linabf.unwrap(V, F), igl_linabf.flatten(V, F[1:])
    with pytest.raises(MeshError, match="pass its attribute uv"):
        igl_linabf.quality(V, F[1:], result)
    with pytest.raises(MeshError, match=r"V\[atlas.origin\], its triangles atlas.triangles, .* atlas.flat"):
        igl_linabf.quality(V, F, atlas)
    measured = igl_linabf.quality(V[atlas.origin], atlas.triangles, atlas.flat)
    assert measured.stretch_l2 == pytest.approx(atlas.quality.stretch_l2)
