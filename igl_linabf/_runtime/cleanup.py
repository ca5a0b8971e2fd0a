"""Cleanup for a process that ends at once, as the command does at Ctrl-C.

An exception would surface in whatever library the main thread runs at that time. Some crash if their import
is interrupted, and VTK turns it into an error of its own.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

_undoings: dict[object, Callable[[], object]] = {}


@contextmanager
def undo_at_interrupt(undo: Callable[[], object]) -> Iterator[None]:
    """Within the block, `undo_all` calls `undo`, which must not wait for a lock."""
    key = object()
    _undoings[key] = undo
    try:
        yield
    finally:
        del _undoings[key]


def undo_all() -> None:
    """Call `undo` of all blocks that are running, the latest first."""
    for undo in reversed(list(_undoings.values())):
        with suppress(OSError):
            undo()


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[str]:
    """A temporary file beside `path` that takes its place when the block succeeds.

    Parameters
    ----------
    path : path of the file to write

    Yields
    ------
    str
        Path of the temporary file, with the same suffix.

    Raises
    ------
    OSError
        The folder is missing or not writable, or the disk is full; the error names `path`.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "notes.txt")
    >>> with replacing(path) as temporary, open(temporary, "w") as file:
    ...     print("whole or not at all", file=file)
    >>> os.listdir(os.path.dirname(path))
    ['notes.txt']
    """
    path = Path(path)
    temporary = path.with_name(f".igl_linabf-{secrets.token_hex(8)}{path.suffix}")
    remove = partial(temporary.unlink, missing_ok=True)
    with undo_at_interrupt(remove):
        try:
            # not tempfile's, whose mode only the umask of the whole process, threads and all, would tell
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            yield str(temporary)
            os.replace(temporary, path)
        except BaseException as error:
            remove()
            if isinstance(error, OSError) and error.errno and error.filename in (None, str(temporary)):
                raise OSError(error.errno, error.strerror, str(path)) from None
            raise
