"""Errors and warnings of the package, how their texts list indices, and what they take for a number."""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import ArrayLike


class MeshError(ValueError):
    """The mesh, the pins or the angles cannot be used; the text says why, where and what to do."""


class SingularSystemError(MeshError):
    """A linear system is singular in double precision; the text names the thinnest faces."""


class MemoryLimitError(MeshError):
    """There is not enough free memory; the text says how much is needed."""


class MeshWarning(UserWarning):
    """The input was accepted, but part of it was left out; the text says which."""


class FallbackWarning(UserWarning):
    """Something other than what was asked for was done; the text says what and why."""


class OutcomeWarning(UserWarning):
    """The returned map is not valid or not converged; the text says what is wrong and what helps."""


# Indices that a message lists before it says how many there are. Fewer hide a pattern; more fill the line.
# tests/test_bad_input.py shows the messages.
LISTED = 5


def some(indices: ArrayLike, limit: int = LISTED) -> str:
    """Write the first few of `indices`, and how many there are if that is more.

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
    """Whether an option is one real number from `low` to `high`, or with `above` beyond `low`; a whole one.

    Text, lists and complex numbers are none: the error of the option can then name them.

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
    """Depth of the first frame outside this package, so that a warning points at the caller."""
    level, frame = 1, sys._getframe(1)
    inside = ("igl_linabf", "contextlib")  # whose frames are between those of context managers
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(inside):
        level, frame = level + 1, frame.f_back
    return level
