"""Linear angle based parameterization of triangle meshes, beside libigl.

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> uv = igl_linabf.linabf(V, F[1:])
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import adapters as adapters
    from . import io as io
    from .batch_runs import batch as batch
    from .charts import Atlas as Atlas
    from .charts import Chart as Chart
    from .charts import cut as cut
    from .charts import find_cones as find_cones
    from .charts import find_seams as find_seams
    from .charts import pack_together as pack_together
    from .charts import texture_seams as texture_seams
    from .charts import unwrap as unwrap
    from .errors import FallbackWarning as FallbackWarning
    from .errors import MemoryLimitError as MemoryLimitError
    from .errors import MeshError as MeshError
    from .errors import MeshWarning as MeshWarning
    from .errors import OutcomeWarning as OutcomeWarning
    from .errors import SingularSystemError as SingularSystemError
    from .flattening import ABF as ABF
    from .flattening import DNCP as DNCP
    from .flattening import LSCM as LSCM
    from .flattening import SCP as SCP
    from .flattening import Comparison as Comparison
    from .flattening import Flattener as Flattener
    from .flattening import Flattening as Flattening
    from .flattening import Hole as Hole
    from .flattening import Isometric as Isometric
    from .flattening import LinABF as LinABF
    from .flattening import OneStepABFpp as OneStepABFpp
    from .flattening import Outcome as Outcome
    from .flattening import Residuals as Residuals
    from .flattening import abf as abf
    from .flattening import compare as compare
    from .flattening import flatten as flatten
    from .flattening import flatten_many as flatten_many
    from .flattening import linabf as linabf
    from .flattening import linabf_angles as linabf_angles
    from .flattening import lscm as lscm
    from .io import write_grid as write_grid
    from .layouts import layout as layout
    from .measures import Quality as Quality
    from .measures import distortion as distortion
    from .measures import overlaps as overlaps
    from .measures import quality as quality
    from .patterns import Pattern as Pattern
    from .patterns import write_pattern as write_pattern
    from .remesh import QuadGrid as QuadGrid
    from .remesh import quad_grid as quad_grid
    from .surface import Cleaned as Cleaned
    from .surface import Repair as Repair
    from .surface import clean as clean
    from .surface import split_chords as split_chords
    from .textures import bake as bake

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
__all__ = sorted(["adapters", "io", *_ROOM])
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
