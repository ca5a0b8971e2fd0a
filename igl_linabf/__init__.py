"""Linear angle based parameterization of triangle meshes, beside libigl.

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> uv = igl_linabf.linabf(V, F[1:])
"""

from importlib import import_module
from pathlib import Path

# A room is imported when one of its names is first used: so `igl-linabf` answers Ctrl-C before NumPy, SciPy
# and libigl are there, and importing the package costs nothing. The stub, which type checkers read, is the
# only list of names: each of its lines is `from .ROOM import NAME as NAME` or `from . import ROOM as ROOM`.
_LINES = Path(__file__).with_suffix(".pyi").read_text("utf-8").splitlines()
_IMPORTS = {words[3]: words[1] for words in map(str.split, _LINES) if words[:1] == ["from"]}
__all__ = sorted(name for name, room in _IMPORTS.items() if room != ".")


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version  # takes as long as the rest of this module

        value: object = version("igl-linabf")
    elif name not in _IMPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    elif _IMPORTS[name] == ".":
        return import_module(f".{name}", __name__)
    else:
        value = getattr(import_module(_IMPORTS[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_IMPORTS, "__version__"})
