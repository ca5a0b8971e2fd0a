"""UV unwrapping and flattening of triangle meshes, by linear angle based parameterization.

For vertices V (#V, 3) and faces F (#F, 3), call:

    unwrap(V, F)               for any mesh: an atlas of charts with even texels
    linabf(V, F)               for a disk: a map that preserves angles; abf(V, F) is its reference
    isometric(V, F)            for a disk: a map that preserves lengths and areas
    flatten(V, F)              for a disk: a map with its outcome, residuals and times
    quality(V, F, uv)          for any map: its distortion, flips and overlaps
    check_uv(V, F, TC, FTC)    for texture coordinates of any program: their faults
    find_seams(V, F)           for any mesh: edges to cut along; cut(V, F, seams) cuts
    clean(V, F)                for a mesh that is not manifold or oriented: its repair
    read_mesh(path)            for files; write_mesh writes maps and atlases
    textures.bake(V, F, ...)   for colours or other values: their image on an atlas

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> atlas = igl_linabf.unwrap(V, F)  # texture coordinates atlas.TC, and their indices atlas.FTC
>>> uv = igl_linabf.linabf(V, F[1:])  # (#V, 2)
"""

from importlib import import_module

# A subpackage is imported when one of its names is first used, so that importing `igl_linabf` is fast, and
# the command responds to Ctrl-C while NumPy, SciPy and libigl are imported. The stub `__init__.pyi` is the
# only list of names: its lines are `from .ROOM import NAME as NAME` or `from . import ROOM as ROOM`.
with open(f"{__file__}i", encoding="utf-8") as _stub:  # importing pathlib would double the import time
    _IMPORTS = {words[3]: words[1] for words in map(str.split, _stub) if words[:1] == ["from"]}
__all__ = sorted(name for name, room in _IMPORTS.items() if room != ".")


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version  # a slow import, therefore only if needed

        value: object = version("igl-linabf")
    elif name not in _IMPORTS:
        message = f"module {__name__!r} has no attribute {name!r}{_find_home(name)}"
        raise AttributeError(message, name=name, obj=import_module(__name__))  # Python suggests similar names
    elif _IMPORTS[name] == ".":
        return import_module(f".{name}", __name__)
    else:
        value = getattr(import_module(_IMPORTS[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*_IMPORTS, "__version__"])


def _find_home(name: str) -> str:
    """Return the end of an error message: where a public name lives, without importing the subpackages."""
    import re
    from importlib.util import find_spec

    if name == "Seams":  # the class of version 0.2
        return ": pass edges as seams=, and options as charts=igl_linabf.ChartOptions(...)"
    for room in () if name.startswith("_") else (name for name, of in _IMPORTS.items() if of == "."):
        spec = find_spec(f"{__name__}.{room}")
        if spec is None or spec.origin is None:
            continue
        with open(spec.origin, encoding="utf-8") as source:
            imports = re.findall(r"^from \S+ import (\([^)]*\)|.*)", source.read(), re.MULTILINE)
        if name in re.findall(r"\w+", " ".join(imports)):
            return f": it is {__name__}.{room}.{name}"
    return ""
