"""Import optional packages, call their readers, and check the meshes that they return."""

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
    """Import a module of an optional package; if it is missing, the error message states the pip command."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(f"{error}: {hint}") from None


def call_reader(read: Callable[[Any], Any], given: Any) -> Any:
    """Call a third-party reader, suppress its warnings, and convert its exceptions to `Damaged`."""
    if isinstance(given, Path):
        given.open("rb").close()  # raise OSError for a file that cannot be opened
        given = str(given)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read(given)
    except (MemoryError, Damaged):
        raise
    except Exception as error:  # third-party packages define their own exceptions
        raise Damaged(f"{type(error).__name__}: {error}") from None


def make_checked_mesh_file(V: FloatArray, polygons: Polygons, extras: Extras) -> MeshFile:
    """Return a mesh that another package has read; raise `Damaged` if faces refer to missing vertices."""
    outside = polygons.outside(len(V))
    if len(outside):
        raise Damaged(f"faces {some(outside)} refer to vertices outside 0..{len(V) - 1}")
    return MeshFile(V, polygons, extras=extras)
