"""Tests of messages: lists of indices, checks of numbers, and the line that a warning names."""

from __future__ import annotations

import pickle
import warnings
from contextlib import contextmanager

import numpy as np
import pytest

from igl_linabf import MeshError, MeshWarning
from igl_linabf._notebook import html_table
from igl_linabf.cli import main
from igl_linabf.errors import is_number, some, stack_level


def test_the_first_few_are_listed_and_all_are_counted() -> None:
    assert some(np.arange(5)) == "0, 1, 2, 3, 4"
    assert some(np.arange(6)) == "0, 1, 2, 3, 4, ... (6 in all)"
    assert some([[1, 2], [3, 4]], limit=1) == "[1, 2], ... (2 in all)"


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
    assert "\x1b" not in html_table([[name], ["<b>" + name]])
    for command in (["check", name], ["unwrap", name, "-o", "out.obj"], ["flatten", "--" + name]):
        try:
            assert main(command) == 2
        except SystemExit as end:  # the parser exits on an invalid argument
            assert end.code == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.isprintable()
