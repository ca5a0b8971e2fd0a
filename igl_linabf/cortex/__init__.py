"""Flat maps of cortices: from a FreeSurfer subject to patches, surfaces and pictures.

In: the folder of a subject. Out: its hemispheres, cut as a template is or along seams that are found, laid
flat at the scale at which distances are best kept, with the numbers of the subject's vertices.
"""

from .flat_hemispheres import FlatHemisphere, flatten_hemisphere, flatten_hemispheres
from .pictures import mean_curvatures
from .subjects import HEMISPHERES, Hemisphere, HemisphereName
from .transfer import Cuts
from .writing import FLAT_PATCH, files_of, write_hemisphere, writing_hemispheres

__all__ = [
    "Cuts",
    "FlatHemisphere",
    "Hemisphere",
    "flatten_hemisphere",
    "flatten_hemispheres",
    "write_hemisphere",
]
