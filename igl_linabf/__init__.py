"""Linear angle based parameterization of triangle meshes, beside libigl.

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> uv = igl_linabf.linabf(V, F[1:])
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import adapters, io
    from .batch_runs import batch
    from .charts import Atlas, Chart, cut, find_cones, find_seams, pack_together, texture_seams, unwrap
    from .errors import (
        FallbackWarning,
        MemoryLimitError,
        MeshError,
        MeshWarning,
        OutcomeWarning,
        SingularSystemError,
    )
    from .flattening import (
        ABF,
        DNCP,
        LSCM,
        SCP,
        Comparison,
        Flattener,
        Flattening,
        Hole,
        Isometric,
        LinABF,
        OneStepABFpp,
        Outcome,
        Residuals,
        abf,
        compare,
        flatten,
        flatten_many,
        linabf,
        linabf_angles,
        lscm,
    )
    from .io import write_grid
    from .layouts import layout
    from .measures import Quality, distortion, overlaps, quality
    from .patterns import Pattern, write_pattern
    from .remesh import QuadGrid, quad_grid
    from .surface import Cleaned, Repair, clean, split_chords
    from .textures import bake

__all__ = [
    "ABF",
    "DNCP",
    "LSCM",
    "SCP",
    "Atlas",
    "Chart",
    "Cleaned",
    "Comparison",
    "FallbackWarning",
    "Flattener",
    "Flattening",
    "Hole",
    "Isometric",
    "LinABF",
    "MemoryLimitError",
    "MeshError",
    "MeshWarning",
    "OneStepABFpp",
    "Outcome",
    "OutcomeWarning",
    "Pattern",
    "QuadGrid",
    "Quality",
    "Repair",
    "Residuals",
    "SingularSystemError",
    "abf",
    "adapters",
    "bake",
    "batch",
    "clean",
    "compare",
    "cut",
    "distortion",
    "find_cones",
    "find_seams",
    "flatten",
    "flatten_many",
    "io",
    "layout",
    "linabf",
    "linabf_angles",
    "lscm",
    "overlaps",
    "pack_together",
    "quad_grid",
    "quality",
    "split_chords",
    "texture_seams",
    "unwrap",
    "write_grid",
    "write_pattern",
]

# A room is imported when one of its names is first used: so `igl-linabf` answers Ctrl-C before NumPy, SciPy
# and libigl are there, and importing the package costs nothing.
_NAMES = {
    "batch_runs": "batch",
    "charts": "Atlas Chart cut find_cones find_seams pack_together texture_seams unwrap",
    "errors": "FallbackWarning MemoryLimitError MeshError MeshWarning OutcomeWarning SingularSystemError",
    "flattening": "ABF DNCP LSCM SCP Comparison Flattener Flattening Hole Isometric LinABF OneStepABFpp "
    "Outcome Residuals abf compare flatten flatten_many linabf linabf_angles lscm",
    "io": "write_grid",
    "layouts": "layout",
    "measures": "Quality distortion overlaps quality",
    "patterns": "Pattern write_pattern",
    "remesh": "QuadGrid quad_grid",
    "surface": "Cleaned Repair clean split_chords",
    "textures": "bake",
}
_ROOM = {name: room for room, names in _NAMES.items() for name in names.split()}
_ROOMS = {*_NAMES, "adapters", "angles", "kernels", "linalg"}

if not TYPE_CHECKING:  # a type checker would take any name for one of the package

    def __getattr__(name: str) -> object:
        if name in _ROOMS:
            return import_module(f"{__name__}.{name}")
        if name not in _ROOM:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = globals()[name] = getattr(import_module(f"{__name__}.{_ROOM[name]}"), name)
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__, *_ROOMS})
