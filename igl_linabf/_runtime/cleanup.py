"""Cleanup for a process that terminates without raising, such as the command on Ctrl-C.

A KeyboardInterrupt would surface inside the library that the main thread is running. Some libraries crash if
their import is interrupted, and VTK converts the exception to its own error.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

_undo_functions: dict[object, Callable[[], object]] = {}


@contextmanager
def undo_at_interrupt(undo: Callable[[], object]) -> Iterator[None]:
    """Register `undo` for `undo_all` during the block; `undo` must not wait for a lock."""
    key = object()
    _undo_functions[key] = undo
    try:
        yield
    finally:
        del _undo_functions[key]


def undo_all() -> None:
    """Call the registered `undo` functions of all active blocks, most recent first."""
    for undo in reversed(list(_undo_functions.values())):
        with suppress(OSError):
            undo()


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[str]:
    """Write to a temporary file beside `path`, which replaces `path` if the block succeeds.

    Parameters
    ----------
    path : path-like
        The file to write.

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
            # not `tempfile`, whose files have mode 0o600; reading the umask would set it for all threads
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            yield str(temporary)
            os.replace(temporary, path)
        except BaseException as error:
            remove()
            if isinstance(error, OSError) and error.errno and error.filename in (None, str(temporary)):
                raise OSError(error.errno, error.strerror, str(path)) from None
            raise
