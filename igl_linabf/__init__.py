"""Linear angle based parameterization of triangle meshes, beside libigl.

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> uv = igl_linabf.linabf(V, F[1:])
"""

from . import io
from .charts import Atlas, Chart, cut, find_seams, texture_seams, unwrap
from .errors import FallbackWarning, MeshError, MeshWarning, OutcomeWarning
from .flattening import (
    ABF,
    DNCP,
    LSCM,
    SCP,
    Comparison,
    Flattening,
    Hole,
    LinABF,
    OneStepABFpp,
    Outcome,
    Residuals,
    abf,
    compare,
    flatten,
    linabf,
    linabf_angles,
    lscm,
)
from .io import write_grid
from .layouts import layout
from .measures import Quality, distortion, overlaps, quality
from .remesh import QuadGrid, quad_grid
from .surface import Cleaned, Repair, clean

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
    "Flattening",
    "Hole",
    "LinABF",
    "MeshError",
    "MeshWarning",
    "OneStepABFpp",
    "Outcome",
    "OutcomeWarning",
    "QuadGrid",
    "Quality",
    "Repair",
    "Residuals",
    "abf",
    "clean",
    "compare",
    "cut",
    "distortion",
    "find_seams",
    "flatten",
    "io",
    "layout",
    "linabf",
    "linabf_angles",
    "lscm",
    "overlaps",
    "quad_grid",
    "quality",
    "texture_seams",
    "unwrap",
    "write_grid",
]
