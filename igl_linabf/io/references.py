"""Resolve references to other files, and update them if the referring file moves to another folder.

By default, references are followed only within the folder of the referring file and its subfolders, because a
file from a stranger may refer to any file of this computer.
"""

import os
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ..charts import FIRST_UDIM_TILE
from ..errors import MeshError

REMEDY = "move the file into it, or allow the reference by allow_outside=True"
MAX_UDIM_PAGES = 100  # rows of ten pages: the tiles 1001 to 1100
TILE_PATTERN = re.compile(r"(<UDIM>|(?<!\d)1001(?!\d))(?=[^/\\]*$)", re.IGNORECASE)  # in an image's name
NUMBER_PATTERN = re.compile(r"(?=(\d{4}))")  # also finds numbers that overlap
MAX_NAME_LENGTH = 4096  # longest path of Linux


@dataclass(frozen=True)
class Folder:
    """The base folder of relative references in a file.

    Attributes
    ----------
    path : Path
    allow_outside : bool
        Follow references to files outside `root`.
    root : Path or None
        The folder that references do not leave; by default `path`.
    """

    path: Path
    allow_outside: bool = False
    root: Path | None = None

    def find_file(self, name: str) -> Path | None:
        """Return the file that a reference points to, or None; the reference may contain backslashes.

        Raises
        ------
        MeshError
            The file is outside the folder, directly or by a symbolic link.
        """
        file, is_allowed = self._find_allowed_file(name)
        if not is_allowed:
            raise MeshError(
                f"the reference {name} leads out of the folder {self.root or self.path}: {REMEDY}"
            )
        return file

    def find_tiles(self, name: str) -> dict[int, Path]:
        """Return the files of an image of UDIM tiles by page; {} for an image without tiles.

        The name contains <UDIM>, or it contains 1001 and there is a file for another tile.
        """
        places = [*TILE_PATTERN.finditer(name)] if len(name) <= MAX_NAME_LENGTH else []
        if not places:
            return {}
        begin, end = places[-1].span()
        numbers = range(FIRST_UDIM_TILE, FIRST_UDIM_TILE + MAX_UDIM_PAGES)
        tiles = [f"{name[:begin]}{number}{name[end:]}" for number in numbers]
        listed = self._list_numbers_beside(tiles[0])
        found = {
            page: file
            for page, tile in enumerate(tiles)
            if str(numbers[page]) in listed and (file := self.find_file(tile)) is not None
        }
        return found if len(found) > 1 or places[-1][1].upper() == "<UDIM>" else {}

    def _list_numbers_beside(self, name: str) -> set[str]:
        """Return all numbers of four digits in the names of the files in the folder of a referenced file.

        Looking up each of a hundred tiles would take milliseconds for each image.
        """
        self.find_file(name)  # raises an error if the folder must not be read
        folder = (self.path / name.replace("\\", "/")).parent
        with suppress(OSError, ValueError):  # there is no such folder
            return {number for entry in os.listdir(folder) for number in NUMBER_PATTERN.findall(entry)}
        return set()

    def contains(self, name: str) -> bool:
        """Return True if a reference points to an existing file, and may be followed."""
        return self._find_allowed_file(name)[0] is not None

    def is_outside(self, name: str) -> bool:
        """Return True if a reference leads out of the folder, and must not be followed."""
        return not self._find_allowed_file(name)[1]

    def with_path(self, path: Path) -> "Folder":
        """Return `path`, the folder of a referenced file, as a `Folder` with the same root."""
        return Folder(path, self.allow_outside, self.root or self.path)

    def relocate_reference(self, name: str, new: Path) -> str:
        """Return a reference relative to another folder.

        References to missing files and to files outside the folder do not change.
        """
        target, _ = self._find_allowed_file(name)
        if target is None or Path(name).is_absolute() or self.path.resolve() == new.resolve():
            return name
        target = target.parent.resolve() / target.name  # folder names may be symbolic links
        try:
            return os.path.relpath(target, new.resolve()).replace(os.sep, "/")
        except ValueError:  # the folders are on different drives
            return target.as_posix()

    def _find_allowed_file(self, name: str) -> tuple[Path | None, bool]:
        """Return the file of a reference, or None, and whether the reference may be followed."""
        if len(name) > MAX_NAME_LENGTH:
            return None, True
        for candidate in dict.fromkeys((name, name.replace("\\", "/"))):
            try:
                if not self._is_allowed(candidate):
                    return None, False
                if name and (self.path / candidate).is_file():
                    return self.path / candidate, True
            except (OSError, ValueError):  # the name is too long or contains a null character
                break
        return None, True

    def _is_allowed(self, name: str) -> bool:
        """Return True if a name is inside the folder, both as written and after links are resolved.

        The name as written is checked first, because resolving a network path may contact its server.
        """
        places: tuple[Callable[[Path], str], ...] = (os.path.abspath, os.path.realpath)
        return self.allow_outside or all(
            _is_within(place(self.path / name), place(self.root or self.path)) for place in places
        )


def _is_within(path: str, folder: str) -> bool:
    try:
        return os.path.commonpath((path, folder)) == os.path.normpath(folder)
    except ValueError:  # the paths are on different drives
        return False
