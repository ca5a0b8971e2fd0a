"""Resolve references to other files, and update them if the referring file moves to another folder."""

import os
from pathlib import Path


def find_file(name: str, folder: Path) -> Path | None:
    """Return the file that a reference in this folder points to, or None; backslashes are allowed."""
    for candidate in (name, name.replace("\\", "/")):
        try:
            if name and (folder / candidate).is_file():
                return folder / candidate
        except (OSError, ValueError):  # the name is too long or contains a null character
            return None
    return None


def relocate_reference(name: str, old: Path, new: Path) -> str:
    """Return a reference relative to another folder; references to missing files do not change."""
    target = find_file(name, old)
    if target is None or Path(name).is_absolute() or old.resolve() == new.resolve():
        return name
    target = target.parent.resolve() / target.name  # symbolic links between folders
    try:
        return os.path.relpath(target, new.resolve()).replace(os.sep, "/")
    except ValueError:  # on another drive
        return target.as_posix()
