"""Linear angle based parameterization of triangle meshes, beside libigl.

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> uv = igl_linabf.linabf(V, F[1:])
"""

from . import files, io
from .atlas import Atlas, Chart, unwrap
from .compare import Comparison, compare
from .distortion import distortion
from .errors import FallbackWarning, MeshError, MeshWarning, OutcomeWarning
from .flatten import abf, flatten, linabf, linabf_angles, lscm
from .grid import QuadGrid, quad_grid, write_grid
from .layout import layout
from .overlaps import overlaps
from .quality import Quality, quality
from .result import Flattening, Hole, Outcome, Residuals
from .seams import cut, find_seams, texture_seams

__all__ = [
    "Atlas",
    "Chart",
    "Comparison",
    "FallbackWarning",
    "Flattening",
    "Hole",
    "MeshError",
    "MeshWarning",
    "Outcome",
    "OutcomeWarning",
    "QuadGrid",
    "Quality",
    "Residuals",
    "abf",
    "compare",
    "cut",
    "distortion",
    "files",
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
