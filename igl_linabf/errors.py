"""Define the errors and warnings of the package, and helpers for their messages."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

P = ParamSpec("P")
T = TypeVar("T")


def escape_control_characters(text: object) -> str:
    """Return a text on one line, with escape codes for control characters.

    Names in a file may contain characters that control a terminal, such as escape sequences, line breaks and
    marks that reverse the order of letters.

    Examples
    --------
    >>> escape_control_characters("caf\\u00e9 \\x1b[2J")
    'café \\\\x1b[2J'
    """
    found = str(text)
    if found.isprintable():
        return found
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in found)


class _Printable:
    """A base class that makes the text of errors and warnings printable."""

    def __str__(self) -> str:
        return escape_control_characters(super().__str__())


class MeshError(_Printable, ValueError):
    """An input, such as the mesh, cannot be used; the message states the reason, the place and a remedy."""


class SingularSystemError(MeshError):
    """A linear system is singular in double precision; the message names the thinnest faces."""


class MemoryLimitError(MeshError):
    """There is not enough free memory; the message includes the required amount."""


class MeshWarning(_Printable, UserWarning):
    """The input was accepted, but a part of it was left out or repaired; the message identifies the part."""


class FallbackWarning(_Printable, UserWarning):
    """A fallback replaced the requested computation; the message names the fallback and the reason."""


class OutcomeWarning(_Printable, UserWarning):
    """The returned map is not valid or has not converged; the message names the problem and a remedy."""


MAX_LISTED = 5  # number of indices that a message lists before it states their total number


def first_few(indices: ArrayLike, limit: int = MAX_LISTED) -> str:
    """Format the first few of `indices`, and their number if there are more.

    Examples
    --------
    >>> first_few([3, 1, 2])
    '3, 1, 2'
    >>> first_few(range(100), limit=3)
    '0, 1, 2, ... (100 in all)'
    """
    values = np.asarray(indices)
    head = ", ".join(str(v.tolist()) for v in values[:limit])
    return head if len(values) <= limit else f"{head}, ... ({len(values)} in all)"


PLURALS = {"vertex": "vertices", "mesh": "meshes"}  # nouns whose plural is not formed by "s"


def format_count(number: int, noun: str) -> str:
    """Format a number of things with the noun in the singular or plural.

    Examples
    --------
    >>> format_count(1, "image"), format_count(0, "image"), format_count(2000, "vertex")
    ('1 image', '0 images', '2,000 vertices')
    """
    return f"{number:,} {noun if number == 1 else PLURALS.get(noun, noun + 's')}"


def is_number(
    value: object, low: float = -np.inf, high: float = np.inf, *, above: bool = False, whole: bool = False
) -> bool:
    """Return True if `value` is a single real number from `low` to `high`.

    With `above`, `low` itself is excluded; with `whole`, the number must be an integer. Booleans, strings,
    lists and complex numbers are rejected.

    Examples
    --------
    >>> is_number(2, 0), is_number(0, 0, above=True), is_number("2", 0), is_number([2, 3], 0), is_number(None)
    (True, False, False, False, False)
    """
    if isinstance(value, bool | np.bool_ | str | bytes) or np.ndim(value) != 0:  # type: ignore[arg-type]
        return False
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return False
    return low <= number <= high and not (above and number == low) and not (whole and number % 1 != 0)


CONVERTERS = {
    "meshio": "igl_linabf.adapters.from_meshio",
    "open3d": "igl_linabf.adapters.from_open3d",
    "pyvista": "igl_linabf.adapters.from_pyvista",
    "trimesh": "igl_linabf.adapters.from_trimesh",
}


def takes_vertices_and_faces(function: Callable[P, T]) -> Callable[P, T]:
    """Make a function of (V, F, ...) explain how to pass a mesh or a file, if `F` is missing.

    Examples
    --------
    >>> import igl_linabf
    >>> igl_linabf.unwrap("bunny.obj")
    Traceback (most recent call last):
    ValueError: unwrap takes vertices V and faces F: pass *igl_linabf.read_mesh('bunny.obj')
    """

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> T:
        if len(args) == 1 and "F" not in kwargs:
            hint = _suggest_arrays(args[0])
            raise ValueError(f"{function.__name__} takes vertices V and faces F: pass {hint}")
        return function(*args, **kwargs)

    return checked


def _suggest_arrays(mesh: object) -> str:
    """Return the expression for the vertices and faces of an object that was passed alone."""
    library = type(mesh).__module__.partition(".")[0]
    if library in CONVERTERS:
        return f"*{CONVERTERS[library]}(mesh)"
    if isinstance(mesh, str | os.PathLike):
        return f"*igl_linabf.read_mesh({os.fspath(mesh)!r})"
    if hasattr(mesh, "V") and hasattr(mesh, "F"):
        return "mesh.V, mesh.F"
    return "the arrays (#V, 3) and (#F, 3)"


def stack_level() -> int:
    """Return the stack level of the first frame outside this package, for use in `warnings.warn`."""
    level, frame = 1, sys._getframe(1)
    inside = ("igl_linabf", "contextlib")  # contextlib calls context managers of this package
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(inside):
        level, frame = level + 1, frame.f_back
    return level
