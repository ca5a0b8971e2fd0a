"""The front of a body: where it is looked at from, as far as its shape tells.

A face has eyes, nose and mouth, the back of a head has none. So the front is where most detail looks: the
mean of the normals, weighted by the salience of Lee, Varshney, Jacobs 2005, which is the difference between
the mean curvature at a fine and at a coarse scale.
"""

from __future__ import annotations

import numpy as np

from ..._core import lengths
from ..._types import FloatArray
from ...surface import Submesh
from . import constants
from .curvature import Smoothing, dihedral_angles, flat_share, mean_curvature


def facing_away(component: Submesh) -> FloatArray:
    """How far each face looks away from the front, from -1 to 1; all 0 if the body has none."""
    nowhere = np.zeros(len(component.F))
    if len(component.F) < constants.MIN_DETAILED_FACES:
        return nowhere
    bend = dihedral_angles(component)
    if flat_share(component, bend) > constants.PLANAR_SHARE:
        return nowhere
    double_area, salience = component.measured[0], _salience(component, bend)[component.F].sum(axis=1)
    a, b, c = component.V[component.F.T]
    normal = np.cross(b - a, c - a)  # times twice the area
    looking = salience @ normal
    length, clear = float(np.linalg.norm(looking)), constants.CLEAR_FRONT * float(salience @ double_area)
    if not constants.MIN_FRONT_SHARE * clear < length < np.inf:
        return nowhere
    direction = looking / max(length, clear)
    return np.asarray(-(normal @ direction) / np.maximum(double_area, np.finfo(float).tiny))


def _salience(component: Submesh, bend: FloatArray) -> FloatArray:
    """Of each vertex: the difference between its curvature, by the edges' bends, and that around it."""
    topology = component.topology
    edges = topology.edges[topology.sides[1] >= 0]
    length = lengths(component.V, edges)
    turned = np.column_stack(mean_curvature(component, edges, length, bend))  # and the area
    smoothing, size = Smoothing(component, edges, length), float(np.sqrt(turned[:, 1].sum()))
    coarse = smoothing.steps(constants.COARSE_SCALE * size, constants.MAX_SALIENCE_STEPS)
    fine = max(round(coarse * (constants.FINE_SCALE / constants.COARSE_SCALE) ** 2), 1)
    curvature = []
    for steps in (fine, max(coarse - fine, 1)):
        turned = smoothing.of(turned, steps)
        curvature.append(turned[:, 0] / turned[:, 1])
    return np.asarray(np.abs(curvature[0] - curvature[1]))
