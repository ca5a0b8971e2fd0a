"""Names of other files in a file, as seen from the folder that it is written to."""

import os
from pathlib import Path


def find_file(name: str, folder: Path) -> Path | None:
    """The file that a name stands for in a file of this folder; Windows' names have backslashes."""
    for candidate in (name, name.replace("\\", "/")):
        try:
            if name and (folder / candidate).is_file():
                return folder / candidate
        except (OSError, ValueError):  # longer than a name can be, or with a zero in it
            return None
    return None


def relocate_reference(name: str, old: Path, new: Path) -> str:
    """A file's name as seen from another folder; a name of no file stays as it is."""
    target = find_file(name, old)
    if target is None or Path(name).is_absolute() or old.resolve() == new.resolve():
        return name
    target = target.parent.resolve() / target.name  # links among folders lead elsewhere from there
    try:
        return os.path.relpath(target, new.resolve()).replace(os.sep, "/")
    except ValueError:  # on another drive
        return target.as_posix()
