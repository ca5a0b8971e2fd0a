"""`igl-linabf doctor`, and versions."""

from __future__ import annotations

import argparse
import platform
from importlib import metadata
from importlib.util import find_spec

from ..kernels import fast_by
from ..linalg import HOW_TO_GET, blas_of_cholmod, has_cholmod
from .commands import GOOD, Command


def _doctor(options: argparse.Namespace) -> int:
    print(f"igl-linabf {version('igl-linabf')}, Python {platform.python_version()}, {platform.platform()}")
    for name in ("libigl", "numpy", "scipy", "pyamg", "scikit-sparse", "numba", "pyvista"):
        print(f"  {name} {version(name)}")
    if has_cholmod():
        print(f"CHOLMOD: yes, with {blas_of_cholmod() or 'an unknown BLAS'}")
    else:
        print(f"CHOLMOD: no; libigl's Cholesky and PyAMG's multigrid are used. To get it, {HOW_TO_GET}")
    print(f"Kernels: {fast_by()}")
    if find_spec("pyvista") is None:
        print("Pictures: no; pip install 'igl-linabf[viz]'")
    return GOOD


def version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


DOCTOR = Command("doctor", _doctor, "print what is installed and what the solvers use", {})
