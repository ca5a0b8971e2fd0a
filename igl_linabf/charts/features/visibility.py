"""The visibility of seams: weights of faces and factors on edge lengths, which hide seams where requested.

The weights of faces are averaged over the distance `SMOOTHING_REACH`. Therefore noise and single faces do not
matter.

Seams can be hidden on the back of a body if its shape shows where the back is. A head has eyes, nose and
mouth in front, and no such details behind. Therefore the front is the direction that most details face: the
mean of the normals weighted by salience (Lee, Varshney, Jacobs 2005), which is the difference between the
mean curvature at a fine scale and at a coarse scale.
"""

import warnings
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..._core import lengths
from ..._types import FloatArray, IntArray
from ...errors import MeshError, MeshWarning, first_few, stack_level
from ...surface import Submesh, sum_by_index
from . import constants
from .curvature import Smoothing, compute_dihedral_angles, compute_flat_share, integrate_mean_curvature

HIDING = 3.0  # multiplies the length of seams in full view, and divides the length of hidden seams
HIDING_ON_BACK = 2.0  # `HIDING` for hide="back"; lower, because the back is only estimated
MIN_BODY_SHARE = 0.01  # for hide="back", ignore components with a smaller share of all triangles
MIN_DETAILED_FACES = 300  # the front side is not determined for components with fewer triangles
FINE_SCALE = 0.01  # scale of details, relative to the square root of the area
COARSE_SCALE = 0.05  # scale of limbs, relative to the square root of the area
MAX_SALIENCE_STEPS = 60  # maximum number of smoothing steps for the coarse scale
CLEAR_FRONT = 0.1  # length of the salience-weighted mean normal from which the front is unambiguous
MIN_FRONT_SHARE = 0.1  # a component has no front if that length is below this share of `CLEAR_FRONT`

SMOOTHING_REACH = 0.02  # smoothing distance of the visibility of faces, in square roots of the area
MAX_SMOOTHING_STEPS = 30  # maximum number of smoothing steps of the visibility of faces

Hiding = ArrayLike | Literal["back"]


def compute_hiding_weights(surface: Submesh, hide: Hiding | None, face: IntArray) -> FloatArray | None:
    """Return how well each triangle hides a seam, from -1 to 1; None if `hide` is None.

    `hide` is a direction, (3,), a weight for each input face, or "back". `face` is the input face that each
    triangle is part of.
    """
    if hide is None:
        return None
    if isinstance(hide, str):
        return _find_backs(surface, hide, len(face))
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
        raise MeshError(f"hide is NaN or infinite at {first_few(bad)}: give finite numbers")
    if given.shape == (3,):
        made = np.zeros(len(face))
        made[surface.faces] = _measure_facing(surface, given)
        return made
    low, high = float(given.min()), float(given.max())
    return ((given - low) / (high - low) * 2 - 1)[face] if high > low else np.zeros(len(face))


def _find_backs(surface: Submesh, hide: str, n_faces: int) -> FloatArray:
    """Return how well each triangle hides a seam: positive on a body's back, 0 if its front is unknown."""
    if hide != "back":
        raise MeshError(f'hide is {hide!r}: pass "back", a direction, (3,), or a weight a face')
    made, as_hidden = np.zeros(n_faces), np.log(HIDING_ON_BACK) / np.log(HIDING)
    for part in surface.split_components():
        if len(part.F) >= MIN_BODY_SHARE * len(surface.F):
            made[part.faces] = as_hidden * _measure_facing_away(part)
    if not made.any():
        said = "no body has details that tell where its back is: seams lie anywhere; pass hide a direction"
        warnings.warn(said, MeshWarning, stacklevel=stack_level())
    return made


def _measure_facing_away(component: Submesh) -> FloatArray:
    """Return minus the cosine between each face's normal and the front direction; 0 if there is no front.

    The values are scaled down if the front is ambiguous.
    """
    nowhere = np.zeros(len(component.F))
    if len(component.F) < MIN_DETAILED_FACES:
        return nowhere
    bend = compute_dihedral_angles(component)
    if compute_flat_share(component, bend) > constants.PLANAR_SHARE:
        return nowhere
    double_area, salience = (
        component.areas_and_products[0],
        _compute_salience(component, bend)[component.F].sum(axis=1),
    )
    a, b, c = component.V[component.F.T]
    normal = np.cross(b - a, c - a)  # its length is twice the area of the face
    looking = salience @ normal
    length, clear = float(np.linalg.norm(looking)), CLEAR_FRONT * float(salience @ double_area)
    if not MIN_FRONT_SHARE * clear < length < np.inf:
        return nowhere
    direction = looking / max(length, clear)
    return np.asarray(-(normal @ direction) / np.maximum(double_area, np.finfo(float).tiny))


def _compute_salience(component: Submesh, bend: FloatArray) -> FloatArray:
    """Return the salience of each vertex: the difference of mean curvatures at the fine and coarse scale."""
    topology = component.topology
    edges = topology.edges[topology.sides[1] >= 0]
    length = lengths(component.V, edges)
    turned = np.column_stack(
        integrate_mean_curvature(component, edges, length, bend)
    )  # columns: integral, area
    smoothing, size = Smoothing(component, edges, length), float(np.sqrt(turned[:, 1].sum()))
    coarse = max(smoothing.count_steps(COARSE_SCALE * size, MAX_SALIENCE_STEPS), 1)
    fine = max(round(coarse * (FINE_SCALE / COARSE_SCALE) ** 2), 1)
    curvature = []
    for steps in (fine, max(coarse - fine, 1)):
        turned = smoothing.smooth(turned, steps)
        curvature.append(turned[:, 0] / turned[:, 1])
    return np.asarray(np.abs(curvature[0] - curvature[1]))


def _measure_facing(surface: Submesh, direction: FloatArray) -> FloatArray:
    """Return the cosine of the angle between a direction and the outer normal of each face."""
    length = float(np.linalg.norm(direction))
    if length == 0:
        raise MeshError("hide is a direction of no length: point to where seams are to be")
    facing = np.empty(len(surface.F))
    for part in surface.split_components():
        a, b, c = part.V[part.F.T] - part.V.mean(axis=0)
        normal = np.cross(b - a, c - a)
        inward = not part.topology.loops and float((a * normal).sum()) < 0
        norm = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)
        cosine = normal @ (direction / length) / norm
        facing[np.searchsorted(surface.faces, part.faces)] = -cosine if inward else cosine
    return facing


def compute_visibility_factors(
    surface: Submesh, edges: IntArray, length: FloatArray, hidden: FloatArray
) -> FloatArray:
    """Return the factor on the length of each inner edge, below 1 where a seam is hidden.

    On fine meshes, the hiding weights are averaged over the distance `SMOOTHING_REACH`.

    Parameters
    ----------
    surface : Submesh
    edges : (#E, 2) int64
    length : (#E,) float64
    hidden : (#F',) float64
        The hiding weights of the input faces.
    """
    own, double_area = hidden[surface.faces], surface.areas_and_products[0]
    smoothing = Smoothing(surface, edges, length)
    steps = smoothing.count_steps(
        SMOOTHING_REACH * float(np.sqrt(double_area.sum() / 2)), MAX_SMOOTHING_STEPS
    )
    if not steps:
        return np.asarray(HIDING ** -own[surface.topology.interior_edge_faces].mean(axis=1))
    corner, n = surface.topology.corner.ravel(), len(surface.V)
    mean = sum_by_index(corner, np.tile(double_area * own, 3), n) / sum_by_index(
        corner, np.tile(double_area, 3), n
    )
    return np.asarray(HIDING ** -smoothing.smooth(mean, steps)[edges].mean(axis=1))
