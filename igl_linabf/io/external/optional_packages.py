"""Readers and writers of other packages: found, called quietly, their meshes checked."""

import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from ..._types import FloatArray
from ...errors import some
from ...surface import Polygons
from ..mesh_file import MeshFile
from ..parsing import Damaged, Extras


def import_optional(
    module: str, hint: str = "pip install 'igl-linabf[formats]' reads and writes this format"
) -> Any:
    """The module of another package; where it is missing, the error says how to get it."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(f"{error}: {hint}") from None


def call_reader(read: Callable[[Any], Any], given: Any) -> Any:
    """What another package's reader makes of a path; whatever it raises says that the file is damaged."""
    if isinstance(given, Path):
        given.open("rb").close()  # what cannot be opened is no damage
        given = str(given)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read(given)
    except (MemoryError, Damaged):
        raise
    except Exception as error:  # each package has its own
        raise Damaged(f"{type(error).__name__}: {error}") from None


def make_checked_mesh_file(V: FloatArray, polygons: Polygons, extras: Extras) -> MeshFile:
    """The mesh that a package has read; raises where faces name vertices that are not there."""
    outside = polygons.outside(len(V))
    if len(outside):
        raise Damaged(f"faces {some(outside)} name vertices outside 0..{len(V) - 1}")
    return MeshFile(V, polygons, extras=extras)
