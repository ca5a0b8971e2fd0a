"""Flatten the cortex of a FreeSurfer subject, and write patches, surfaces and pictures.

Each hemisphere of a subject is cut along a template's cuts or along seams that are found. It is then
flattened at the scale that preserves distances best. Vertices keep the subject's numbering.
"""

from .flat_hemispheres import CutSource as CutSource
from .flat_hemispheres import FlatHemisphere, flatten_hemisphere, flatten_hemispheres
from .flat_hemispheres import WallSource as WallSource
from .pictures import compute_mean_curvatures
from .subjects import HEMISPHERE_NAMES, Hemisphere, HemisphereName
from .transfer import Cuts
from .writing import FLAT_PATCH_NAME, list_output_paths, write_hemisphere, writing_hemispheres

__all__ = [
    "Cuts",
    "FlatHemisphere",
    "Hemisphere",
    "flatten_hemisphere",
    "flatten_hemispheres",
    "write_hemisphere",
]
