"""Automatic rebuild of the compiled core in an editable install. Wheels do not contain this module."""

from __future__ import annotations

import os
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).parent


def rebuild_if_changed(loader: object) -> None:
    """Build the core with the hook of scikit-build-core if a source is newer than the last build."""
    spec = find_spec("._baseline", __package__)
    built = Path(spec.origin) if spec and spec.origin else None
    sources = [HERE.parent.parent / "CMakeLists.txt", HERE / "src", *(HERE / "src").rglob("*")]
    if built and built.exists() and max(map(os.path.getmtime, sources)) <= os.path.getmtime(built):
        return
    print("igl_linabf: a source of the core has changed, building it", file=sys.stderr, flush=True)
    path = os.environ.get("PATH", "")
    os.environ["PATH"] = sysconfig.get_path("scripts") + os.pathsep + path  # find CMake and Ninja from PyPI
    try:
        loader.rebuild()  # type: ignore[attr-defined]
    except Exception as error:
        raise ImportError(
            "a source of igl_linabf's core has changed, and the core could not be built again: see above. "
            "Run scripts/bootstrap or `pip install -e .` in the clone to rebuild it"
        ) from error
    finally:
        os.environ["PATH"] = path
    if built:
        os.utime(built)
