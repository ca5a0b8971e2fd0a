"""Cuts of a hemisphere without a template: seams from its medial wall, as many as the map needs."""

from __future__ import annotations

import warnings

import numpy as np

from .._types import BoolArray, IntArray
from ..charts import find_seams
from ..errors import MeshError, MeshWarning, stack_level
from ..flattening import flatten
from ..measures import Distances
from ..surface import Submesh, connected_labels, patch_faces
from .constants import CRUMBS_SHARE, SOURCES, TRADES
from .subjects import Hemisphere
from .transfer import Cuts


def find_cuts(given: Hemisphere, wall: BoolArray, max_distance_error: float) -> Cuts:
    """The shortest of some cuts whose isometric map has at most this error of distances.

    Warns
    -----
    MeshWarning
        None has: those of the least error are taken.
    """
    if not wall.any():
        raise MeshError(f"{given.subject}, {given.name} has no medial wall: cuts are found from it")
    patch = patch_faces(given.F, ~wall)
    surface = Submesh.checked(given.V, given.F[patch.rows])
    least, best = np.inf, Cuts(wall, ())
    for trade in (None, *TRADES):
        seams = (
            find_seams(surface.V, surface.F, method="isometric", trade=trade, disks=True) if trade else None
        )
        cuts = Cuts(wall, () if seams is None else _seam_parts(surface.vertices[seams], len(wall)))
        error = _error(given, cuts)
        if error < least:
            least, best = error, cuts
        if least <= max_distance_error:
            return best
    warnings.warn(
        f"{given.subject}, {given.name}: the found cuts leave an error of {least:.3f} in distances, more "
        f"than {max_distance_error:g}: allow more, or use a template",
        MeshWarning,
        stacklevel=stack_level(),
    )
    return best


def _error(given: Hemisphere, cuts: Cuts) -> float:
    """Of the isometric map that cuts leave, at its best scale; infinite where they leave pieces."""
    patch = patch_faces(given.F, cuts.stays)
    if sum(map(len, patch.pieces)) > CRUMBS_SHARE * len(given.V):
        return np.inf
    surface = Submesh.checked(given.V, given.F[patch.rows])
    uv = flatten(surface.V, surface.F, "isometric").uv
    distances = Distances.within(surface.as_manifold(), most=SOURCES)
    return distances.error(uv * distances.best_scale(uv))


def _seam_parts(seams: IntArray, n: int) -> tuple[IntArray, ...]:
    """The vertices of each part of the seams that is in one piece."""
    label = connected_labels(seams, n)
    used = np.unique(seams)
    return tuple(used[label[used] == i] for i in np.unique(label[used]))
