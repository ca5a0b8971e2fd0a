"""Define the command `igl-linabf doctor`, which prints the versions of packages."""

import platform
from importlib import metadata

from .._core import BUILD
from ..linalg import CHOLMOD_INSTALL_HINT, find_cholmod_blas, has_cholmod
from .jobs import ExitCode

NEEDED = ("libigl", "numpy", "scipy", "shapely", "pillow", "psutil", "rich", "shtab")
EXTRAS = {  # optional packages, explained in docs/install.md
    "batch": ("distributed", "bokeh"),
    "cholmod": ("scikit-sparse",),
    "cortex": ("nibabel", "nilearn"),
    "formats": ("lib3mf", "nibabel", "pyvista", "DracoPy", "meshopt"),
    "patterns": ("svgwrite", "ezdxf", "matplotlib"),
    "scrolls": ("tifffile", "imagecodecs"),
    "viz": ("pyvista",),
}


def print_versions() -> ExitCode:
    """Print the versions of packages, and the libraries that the linear solvers use."""
    print(
        f"igl-linabf {find_version('igl-linabf')}, Python {platform.python_version()}, {platform.platform()}"
    )
    for name in NEEDED:
        print(f"  {name} {find_version(name)}")
    print("Extras, each installed by pip install 'igl-linabf[EXTRA]':")
    for extra, packages in EXTRAS.items():
        print(f"  {extra}: {', '.join(f'{name} {find_version(name)}' for name in packages)}")
    if has_cholmod():
        print(f"CHOLMOD: yes, with {find_cholmod_blas() or 'an unknown BLAS'}")
    else:
        print(f"CHOLMOD: no; solver='cholmod' needs it. To get it, {CHOLMOD_INSTALL_HINT}")
    print(f"Core: built for {BUILD}")
    return ExitCode.GOOD


def find_version(package: str) -> str:
    """Return the installed version of a package, or "not installed"."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
