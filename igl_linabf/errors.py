"""Define the errors and warnings of the package, and helpers for their messages."""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import ArrayLike


def printable(text: object) -> str:
    """Return a text on one line, with escape codes for control characters.

    Names in a file may contain characters that control a terminal, such as escape sequences, line breaks and
    marks that reverse the order of letters.

    Examples
    --------
    >>> printable("caf\\u00e9 \\x1b[2J")
    'café \\\\x1b[2J'
    """
    found = str(text)
    if found.isprintable():
        return found
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in found)


class _Printable:
    """A base class that makes the text of errors and warnings printable."""

    def __str__(self) -> str:
        return printable(super().__str__())


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


def some(indices: ArrayLike, limit: int = MAX_LISTED) -> str:
    """Format the first few of `indices`, and their number if there are more.

    Examples
    --------
    >>> some([3, 1, 2])
    '3, 1, 2'
    >>> some(range(100), limit=3)
    '0, 1, 2, ... (100 in all)'
    """
    values = np.asarray(indices)
    head = ", ".join(str(v.tolist()) for v in values[:limit])
    return head if len(values) <= limit else f"{head}, ... ({len(values)} in all)"


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


def stack_level() -> int:
    """Return the stack level of the first frame outside this package, for use in `warnings.warn`."""
    level, frame = 1, sys._getframe(1)
    inside = ("igl_linabf", "contextlib")  # contextlib calls context managers of this package
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(inside):
        level, frame = level + 1, frame.f_back
    return level
