"""Which form of a kernel runs: NumPy's, or the same as loops that numba compiles."""

import importlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache, wraps
from hashlib import sha256
from itertools import pairwise
from types import FunctionType
from typing import Any, ParamSpec, TypeVar

import numpy as np

from .._runtime import at_once

P = ParamSpec("P")
T = TypeVar("T")

Number = (int, float, complex, np.generic)
OPTIONS = {"nogil": True, "error_model": "numpy"}
FASTMATH = ("contract", "reassoc", "nsz")  # sums may be added up in the order that is fastest

DIVIDED_FROM = 250_000  # columns from which threads save more time than they take to begin
PIECES = 16  # for any number of threads, so that the result is the same to the bit

_parts: set[Callable[..., Any]] = set()
_numpy_only: ContextVar[bool] = ContextVar("numpy_only", default=False)


@cache
def _numba() -> Any:
    """The module numba; None where it is switched off, not installed, or does not fit NumPy."""
    if os.environ.get("IGL_LINABF_FAST", "1") == "0":
        return None
    try:
        return importlib.import_module("numba")
    except ImportError:
        return None


def is_fast() -> bool:
    """Whether the compiled loops run."""
    return not _numpy_only.get() and _numba() is not None


def fast_by() -> str:
    """What runs the kernels, in words."""
    if os.environ.get("IGL_LINABF_FAST", "1") == "0":
        return "NumPy; IGL_LINABF_FAST=0 switches the compiled loops off"
    if (numba := _numba()) is None:
        return "NumPy; pip install 'igl-linabf[fast]' makes them faster"
    return f"compiled by numba {numba.__version__}"


def only_loops(loops: Callable[P, T]) -> Callable[P, T]:
    """A kernel without a form in NumPy: `loops` compiled, for where `is_fast`."""
    _parts.add(loops)

    def by_loops(*args: P.args, **kwargs: P.kwargs) -> T:
        return run(loops, *args, **kwargs)

    return by_loops


@contextmanager
def numpy_only() -> Iterator[None]:
    """Run NumPy's forms in the block, in this thread."""
    token = _numpy_only.set(True)
    try:
        yield
    finally:
        _numpy_only.reset(token)


def with_loops(loops: Callable[..., T]) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a kernel in NumPy, which defines it; the same as `loops` runs where numba is there.

    The loops may be a part of others, as those of `inlined`.
    """
    _parts.add(loops)

    def decorate(in_numpy: Callable[P, T]) -> Callable[P, T]:
        @wraps(in_numpy)
        def either(*args: P.args, **kwargs: P.kwargs) -> T:
            return run(loops, *args, **kwargs) if is_fast() else in_numpy(*args, **kwargs)

        return either

    return decorate


def instead(
    by_loops: Callable[..., T], *loops: Callable[..., Any]
) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """As `with_loops`, for loops that Python runs, and `loops` that are a part of others."""
    _parts.update(loops)

    def decorate(in_numpy: Callable[P, T]) -> Callable[P, T]:
        @wraps(in_numpy)
        def either(*args: P.args, **kwargs: P.kwargs) -> T:
            return (by_loops if is_fast() else in_numpy)(*args, **kwargs)

        return either

    return decorate


def filled_by(
    loops: Callable[..., None], make: Callable[..., T], *, in_pieces: bool = True
) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """As `with_loops`, for loops that fill the columns `first` up to `last` of what `make` returns.

    They are `loops(*args, first, last, *arrays)`, and threads run them on pieces of large arrays. NumPy makes
    these in large pages, of which the system clears far fewer than of those that loops get for themselves.
    If not `in_pieces`, the loops are `loops(*args, *arrays)`.
    """

    def by_loops(*args: Any) -> T:
        made: Any = make(*args)
        arrays = made if isinstance(made, tuple) else (made,)
        if not in_pieces:
            run(loops, *args, *arrays)
        elif len(pieces := pieces_of(arrays[0].shape[-1])) == 1:
            run(loops, *args, *pieces[0], *arrays)
        else:
            at_once(lambda piece: run(loops, *args, *piece, *arrays), pieces)
        filled: T = made
        return filled

    return instead(by_loops, loops)


def pieces_of(size: int, most: int = PIECES) -> list[tuple[int, int]]:
    """First and last of the pieces of 0 .. size for threads; one piece where they would not pay."""
    if size < DIVIDED_FROM:
        return [(0, size)]
    return list(pairwise(size * k // most for k in range(most + 1)))


def inlined(part: Callable[P, T]) -> Callable[P, T]:
    """Mark a part of loops, which is compiled with them."""
    _parts.add(part)
    return part


def run(loops: Callable[..., T], *args: Any, **kwargs: Any) -> T:
    """Call the loops compiled.

    Where the disk is full, numba compiles, cannot keep the code, and raises before anything has run. The
    next call finds the code in memory; so it does for each part that is compiled with the loops.
    """
    made: Callable[..., T] = compiled(loops)
    for _ in _parts:
        try:
            return made(*args, **kwargs)
        except OSError:
            continue
    return made(*args, **kwargs)


@cache
def compiled(loops: Callable[..., Any]) -> Callable[..., Any]:
    """The loops compiled: once for a machine, as the code is kept on disk; other threads run meanwhile."""
    # a part that is called would be linked to its own code in the process that compiles both, and to a copy
    # beside the loops in later ones: the two may round differently
    options = {**OPTIONS, "fastmath": set(FASTMATH), "forceinline": loops in _parts}
    parts = {name: compiled(part) for name, part in _parts_of(loops).items()}
    name = f"{loops.__name__}_{_digest(loops)}"
    own = FunctionType(loops.__code__, {**loops.__globals__, **parts}, name, loops.__defaults__)
    own.__qualname__ = name  # numba's own key leaves out parts, constants of other files, and options
    made: Any = _numba().njit(**options)(own)
    with suppress(RuntimeError):  # there is no folder where the code could be kept
        from .kept import Kept

        made._cache = Kept(own)
    by_machine: Callable[..., Any] = made
    return by_machine


def _parts_of(loops: Callable[..., Any]) -> dict[str, Callable[..., Any]]:
    """The parts that loops call, by their names."""
    named = {name: loops.__globals__.get(name) for name in loops.__code__.co_names}
    return {
        name: value for name, value in named.items() if isinstance(value, FunctionType) and value in _parts
    }


@cache
def _digest(loops: Callable[..., Any]) -> str:
    """Of all that code follows from: that of loops and of their parts, the constants named, the options."""
    code, known = loops.__code__, loops.__globals__
    numbers = [(name, known[name]) for name in code.co_names if isinstance(known.get(name), Number)]
    parts = [(name, _digest(part)) for name, part in _parts_of(loops).items()]
    made_of = (
        code.co_code,
        code.co_names,
        code.co_consts,
        numbers,
        parts,
        OPTIONS,
        FASTMATH,
        loops in _parts,
    )
    return sha256(repr(made_of).encode()).hexdigest()[:8]
