"""What has to be undone should the process end at once, as the command does at Ctrl-C.

An exception instead would surface inside whatever library the main thread is in: some crash when their import
is broken off, and VTK makes an error of its own of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

_undoings: dict[object, Callable[[], object]] = {}


@contextmanager
def undone_at_once(undo: Callable[[], object]) -> Iterator[None]:
    """Within the block, `undo_all` calls `undo`, which must not wait for a lock."""
    key = object()
    _undoings[key] = undo
    try:
        yield
    finally:
        del _undoings[key]


def undo_all() -> None:
    """Undo what the blocks under way have done, the latest first."""
    for undo in reversed(list(_undoings.values())):
        with suppress(OSError):
            undo()
