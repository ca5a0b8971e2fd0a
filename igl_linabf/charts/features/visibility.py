"""Where a seam shows: less in valleys, and where the caller wants it hidden.

All is smoothed over `REACH`, so that noise and single faces do not matter.
"""

import warnings
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..._types import FloatArray, IntArray
from ...errors import MeshError, MeshWarning, some, stack_level
from ...surface import Submesh
from .curvature import Smoothing, mean_curvature
from .view_salience import facing_away

REACH = 0.02  # times the square root of the area: how far values are smoothed
MAX_STEPS = 30  # of smoothing
VALLEY_DISCOUNT = 0.5  # share of its length that an edge in a deep valley is shorter by
VALLEY = 10.0  # curvature times size at which half of that is given
HIDING = 3.0  # times its length counts an edge where nothing is hidden, and by this is it divided in hiding
GUESSED = float(np.log(2.0) / np.log(HIDING))  # the same by 2, where the back of a body is a guess
LEAST_SHARE = 0.01  # of all triangles that a body has which is looked at

Hiding = ArrayLike | Literal["back"]


def hiding_weights(surface: Submesh, hide: Hiding | None, face: IntArray) -> FloatArray | None:
    """How well each triangle hides a seam, from -1 to 1; None if it does not matter.

    `hide` is a direction, (3,), the weights of the caller's faces, or "back"; `face` is each triangle's.
    """
    if hide is None:
        return None
    if isinstance(hide, str):
        return _backs(surface, hide, len(face))
    try:
        given = np.asarray(hide, dtype=np.float64)
    except (TypeError, ValueError):
        raise MeshError('hide is no array of numbers: pass a direction, a weight a face, or "back"') from None
    n_faces = int(face[-1]) + 1
    if given.shape not in ((3,), (n_faces,)):
        raise MeshError(
            f"hide has the shape {given.shape}: pass a direction, (3,), or weights of the {n_faces} faces"
        )
    bad = np.flatnonzero(~np.isfinite(given))
    if len(bad):
        raise MeshError(f"hide is NaN or infinite at {some(bad)}: give finite numbers")
    if given.shape == (3,):
        made = np.zeros(len(face))
        made[surface.faces] = _facing(surface, given)
        return made
    low, high = float(given.min()), float(given.max())
    return ((given - low) / (high - low) * 2 - 1)[face] if high > low else np.zeros(len(face))


def _backs(surface: Submesh, hide: str, n_faces: int) -> FloatArray:
    """The same of bodies whose details tell where their back is."""
    if hide != "back":
        raise MeshError(f'hide is {hide!r}: pass "back", a direction, (3,), or a weight a face')
    made = np.zeros(n_faces)
    for part in surface.components():
        if len(part.F) >= LEAST_SHARE * len(surface.F):
            made[part.faces] = GUESSED * facing_away(part)
    if not made.any():
        said = "no body has details that tell where its back is: seams lie anywhere; pass hide a direction"
        warnings.warn(said, MeshWarning, stacklevel=stack_level())
    return made


def _facing(surface: Submesh, direction: FloatArray) -> FloatArray:
    """Cosine of the angle between a direction and the outer normal of each face."""
    length = float(np.linalg.norm(direction))
    if length == 0:
        raise MeshError("hide is a direction of no length: point to where seams are to be")
    facing = np.empty(len(surface.F))
    for part in surface.components():
        a, b, c = part.V[part.F.T] - part.V.mean(axis=0)
        normal = np.cross(b - a, c - a)
        inward = not part.topology.loops and float((a * normal).sum()) < 0
        norm = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)
        cosine = normal @ (direction / length) / norm
        facing[np.searchsorted(surface.faces, part.faces)] = -cosine if inward else cosine
    return facing


def valley_factors(
    component: Submesh,
    edges: IntArray,
    length: FloatArray,
    bend: FloatArray,
    smoothing: Smoothing,
    size: float,
) -> FloatArray:
    """What a seam's length is multiplied by at each edge: less than 1 in concave valleys."""
    steps = smoothing.steps(REACH * size, MAX_STEPS)
    turned, area = smoothing.of(np.column_stack(mean_curvature(component, edges, length, bend)), steps).T
    depth = np.maximum(-turned / area * size, 0)
    depth = (depth[edges[:, 0]] + depth[edges[:, 1]]) / 2
    return np.asarray(1 - VALLEY_DISCOUNT * depth / (depth + VALLEY))


def hiding_factors(
    component: Submesh, edges: IntArray, hidden: FloatArray, smoothing: Smoothing, size: float
) -> FloatArray:
    """What a seam's length is multiplied by at each edge, as `hidden` says of the caller's faces."""
    n, double_area = len(component.V), component.measured[0]
    corner = component.F.T.ravel()
    area = np.bincount(corner, np.tile(double_area, 3), minlength=n)
    mean = np.bincount(corner, np.tile(double_area * hidden[component.faces], 3), minlength=n) / area
    mean = smoothing.of(mean, smoothing.steps(REACH * size, MAX_STEPS))
    return hiding_factor_between(mean[edges])


def hiding_factor_between(hidden: FloatArray) -> FloatArray:
    """What a seam's length is multiplied by between two faces, or vertices, that hide it so well, (#E, 2)."""
    return np.asarray(HIDING ** -hidden.mean(axis=1))
