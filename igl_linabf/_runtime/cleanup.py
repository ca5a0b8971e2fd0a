"""Undo incomplete work in a process that terminates without an exception, such as the command on Ctrl-C.

A KeyboardInterrupt is not used, because it would be raised inside the library that the main thread is
running. Some libraries crash if their import is interrupted, and VTK converts the exception to its own error.
"""

from __future__ import annotations

import os
import secrets
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

TEMPORARY = ".igl_linabf-"  # prefix of the names of temporary files
_cleaned_folders = set[Path]()
_undo_functions: dict[object, Callable[[], object]] = {}


@contextmanager
def undo_at_interrupt(undo: Callable[[], object]) -> Iterator[None]:
    """Make `undo_all` call `undo` if it runs during the `with` block; `undo` must not wait for a lock."""
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


def _create_locked(path: Path) -> int | None:
    """Create a file, lock it against removal by `_remove_abandoned`, and return its open descriptor.

    On Windows, where open files cannot be renamed, close the file and return None.
    """
    while True:
        # `tempfile` would set mode 0o600; the default mode depends on the umask, which cannot be read safely
        file = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        if sys.platform == "win32":
            os.close(file)
            return None
        import fcntl

        with suppress(OSError):  # some network file systems do not support locks
            fcntl.flock(file, fcntl.LOCK_SH)
        if os.fstat(file).st_nlink:
            return file
        os.close(file)  # another process has removed the file before it was locked


def _remove_abandoned(folder: Path) -> None:
    """Remove temporary files that killed processes left in a folder; each folder is searched once."""
    if sys.platform == "win32" or folder in _cleaned_folders:
        return
    import fcntl

    _cleaned_folders.add(folder)
    with suppress(OSError):
        for entry in [entry for entry in os.scandir(folder) if entry.name.startswith(TEMPORARY)]:
            with suppress(OSError):
                file = os.open(entry.path, os.O_RDONLY | os.O_NOFOLLOW)
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # raises if the writing process is alive
                    os.unlink(entry.path)
                finally:
                    os.close(file)


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[str]:
    """Yield the path of a temporary file beside `path`, which replaces `path` if the `with` block succeeds.

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
    temporary = path.with_name(f"{TEMPORARY}{secrets.token_hex(8)}{path.suffix}")
    remove = partial(temporary.unlink, missing_ok=True)
    with ExitStack() as stack:
        stack.enter_context(undo_at_interrupt(remove))
        try:
            _remove_abandoned(path.parent)
            lock = _create_locked(temporary)
            if lock is not None:
                stack.callback(os.close, lock)
            yield str(temporary)
            os.replace(temporary, path)
        except BaseException as error:
            remove()
            if isinstance(error, OSError) and error.errno and error.filename in (None, str(temporary)):
                raise OSError(error.errno, error.strerror, str(path)) from None
            raise


@contextmanager
def replacing_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield the path of a temporary folder beside `path`, which replaces `path` if the `with` block succeeds.

    Parameters
    ----------
    path : path-like
        The folder to write; an existing folder is removed with all its contents.

    Yields
    ------
    Path
        The temporary folder.

    Raises
    ------
    OSError
        The folder around it is missing or not writable, or the disk is full.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "notes")
    >>> with replacing_folder(path) as temporary:
    ...     _ = (temporary / "first.txt").write_text("whole or not at all")
    >>> os.listdir(path)
    ['first.txt']
    """
    path = Path(path)
    temporary, old = (path.with_name(f"{TEMPORARY}{secrets.token_hex(8)}") for _ in range(2))

    def restore_folder() -> None:
        shutil.rmtree(temporary, ignore_errors=True)
        if old.exists() and not path.exists():
            os.replace(old, path)

    with undo_at_interrupt(restore_folder):
        try:
            temporary.mkdir()
            yield temporary
            if path.exists():
                os.replace(path, old)
            os.replace(temporary, path)
        except BaseException:
            restore_folder()
            raise
    shutil.rmtree(old, ignore_errors=True)
