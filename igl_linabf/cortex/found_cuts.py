"""Find cuts of a hemisphere without a template, as seams that start at its medial wall."""

from __future__ import annotations

import warnings

import numpy as np

from .._types import BoolArray, IntArray
from ..charts import find_seams
from ..errors import MeshError, MeshWarning, stack_level
from ..flattening import flatten
from ..measures import Distances
from ..surface import Submesh, connected_labels, find_patch_faces
from .constants import MAX_DISTANCE_SOURCES, MAX_OMITTED_SHARE
from .subjects import Hemisphere
from .transfer import Cuts

TRIED_TRADES = (1.0, 3.0, 10.0, 30.0, 100.0)  # values of `trade` in `find_seams`, tried in this order


def find_cuts(given: Hemisphere, wall: BoolArray, max_distance_error: float) -> Cuts:
    """Find the shortest cuts whose isometric map has at most the given error of distances.

    Warns
    -----
    MeshWarning
        No cuts reach the given error. The cuts with the smallest error are returned.
    """
    if not wall.any():
        raise MeshError(f"{given.subject}, {given.name} has no medial wall, at which found cuts start")
    patch = find_patch_faces(given.F, ~wall)
    surface = Submesh.from_input(given.V, given.F[patch.rows])
    least, best = np.inf, Cuts(wall, ())
    for trade in (None, *TRIED_TRADES):
        seams = (
            find_seams(surface.V, surface.F, method="isometric", trade=trade, disks=True) if trade else None
        )
        paths = () if seams is None else _split_seams_into_components(surface.vertices[seams], len(wall))
        cuts = Cuts(wall, paths)
        error = _measure_distance_error(given, cuts)
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


def _measure_distance_error(given: Hemisphere, cuts: Cuts) -> float:
    """Return the error of distances of the isometric map, or infinity if the cuts separate large pieces."""
    patch = find_patch_faces(given.F, cuts.is_kept)
    if sum(map(len, patch.pieces)) > MAX_OMITTED_SHARE * len(given.V):
        return np.inf
    surface = Submesh.from_input(given.V, given.F[patch.rows])
    uv = flatten(surface.V, surface.F, method="isometric").uv
    distances = Distances.measure_within_rings(surface.as_manifold(), most=MAX_DISTANCE_SOURCES)
    return distances.compute_mean_error(uv * distances.find_best_scale(uv))


def _split_seams_into_components(seams: IntArray, n: int) -> tuple[IntArray, ...]:
    """Return the vertices of each connected component of the seams."""
    label = connected_labels(seams, n)
    used = np.unique(seams)
    return tuple(used[label[used] == i] for i in np.unique(label[used]))
