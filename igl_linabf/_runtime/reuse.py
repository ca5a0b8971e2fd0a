"""Memory of large arrays that is used again: that of new ones is cleared by the system, page by page.

A mesh of millions of triangles goes through dozens of arrays of a hundred megabytes each. The C library
returns these to the system one by one, and clearing the next one's pages takes longer than filling it.
"""

import math
import mmap
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock
from weakref import finalize

import numpy as np
from numpy.typing import DTypeLike

from .._types import Array

LEAST = 2**24  # bytes from which memory is used again; smaller arrays have pages that are known
WASTE = 1.1  # times what is asked for that a piece of memory may have


class _Memory:
    """The memory of arrays that nobody holds any more."""

    def __init__(self) -> None:
        self._free: list[mmap.mmap] = []
        self._one_takes = Lock()
        self._open = True

    def take(self, size: int) -> mmap.mmap:
        """Some memory of at least so many bytes."""
        with self._one_takes:  # others may give meanwhile, at the end of the list
            fits = [(len(p), i) for i, p in enumerate(self._free) if size <= len(p) <= WASTE * size]
            if fits:
                return self._free.pop(min(fits)[1])
            spent = 0
            while self._free and spent < size:  # what fits nothing now is not to add up
                spent += len(self._free.pop(0))
        return _new(size)

    def give(self, piece: mmap.mmap) -> None:
        if self._open:
            self._free.append(piece)

    def clear(self) -> None:
        with self._one_takes:
            self._free.clear()

    def close(self) -> None:
        self._open = False
        self._free.clear()


def _new(size: int) -> mmap.mmap:
    """Memory in small pages: large ones, as NumPy asks for, are no gain where they are cleared once."""
    try:
        if sys.platform == "win32":
            return mmap.mmap(-1, size)
        return mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    except OSError as error:
        raise MemoryError(f"{size:,} bytes are not free") from error


_memory: ContextVar[_Memory | None] = ContextVar("memory", default=None)


@contextmanager
def recycling() -> Iterator[None]:
    """Let arrays of `unfilled` in the block use the memory of earlier ones that nobody holds any more."""
    memory = _Memory()
    token = _memory.set(memory)
    try:
        yield
    finally:
        _memory.reset(token)
        memory.close()


def give_back() -> None:
    """Let the system have the memory that nobody holds, before something large is made in other memory."""
    memory = _memory.get()
    if memory is not None:
        memory.clear()


def unfilled(shape: int | tuple[int, ...], dtype: DTypeLike = np.float64) -> Array:
    """As `np.empty`, in memory that may have been another array's."""
    memory = _memory.get()
    if memory is None:
        return np.empty(shape, dtype)
    kind = np.dtype(dtype)
    size = math.prod(shape if isinstance(shape, tuple) else (shape,)) * kind.itemsize
    if size < LEAST:
        return np.empty(shape, dtype=kind)
    piece = memory.take(size)
    # of a buffer that is no array: so all views hold this array, and none of them the memory alone
    made = np.frombuffer(piece, dtype=kind, count=size // kind.itemsize)
    finalize(made, memory.give, piece).atexit = False
    return made.reshape(shape)


def transposed(array: Array) -> Array:
    """The transposed array, with rows one after the other, as of `unfilled`."""
    made = unfilled(array.shape[::-1], array.dtype)
    made[...] = array.T
    return made
