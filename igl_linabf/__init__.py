"""Linear angle based parameterization of triangle meshes, beside libigl.

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> uv = igl_linabf.linabf(V, F[1:])
"""

from .compare import Comparison, compare
from .errors import FallbackWarning, MeshError, MeshWarning, OutcomeWarning
from .flatten import abf, flatten, linabf, linabf_angles, lscm
from .layout import layout
from .quality import Quality, quality
from .result import Flattening, Hole, Outcome, Residuals

__all__ = [
    "Comparison",
    "FallbackWarning",
    "Flattening",
    "Hole",
    "MeshError",
    "MeshWarning",
    "Outcome",
    "OutcomeWarning",
    "Quality",
    "Residuals",
    "abf",
    "compare",
    "flatten",
    "layout",
    "linabf",
    "linabf_angles",
    "lscm",
    "quality",
]
