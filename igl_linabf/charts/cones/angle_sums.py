"""Angle sums of cones: given, of one scale, or multiples of 90 degrees; and which ones triangles can have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..._types import BoolArray, FloatArray, IntArray
from ...errors import MeshError, some
from .component import ConeComponent
from .constants import FULL_TURN, QUARTER_TURN, QUARTERS_OF_CORNER, QUARTERS_OF_CROWDED_CORNER, USABLE_STRETCH
from .quantisation import QuantisedCurvatures
from .scale import ConeScale


def cone_angles_of(
    component: ConeComponent, cones: IntArray, wanted: str | FloatArray | None
) -> tuple[FloatArray, ConeScale | None, QuantisedCurvatures | None]:
    """Angle sums of the cones of a component: those that are wanted, of one scale, or quarter turns.

    Also returns the scale that they follow from, and the quantised curvatures, which may change afterwards.

    Raises
    ------
    MeshError
        They do not obey Gauss-Bonnet, or triangles cannot have them.
    """
    submesh, total = component.submesh, component.total_curvature
    names, nodes = submesh.vertices[cones], component.closed.node[cones]
    scale, quantised = None, None
    if isinstance(wanted, np.ndarray):
        angle = wanted
        _check_gauss_bonnet(component, names, angle)
    else:
        needed = component.min_cones
        if len(cones) < needed or (total == 0 and len(cones) == 1):
            given = f"{len(cones)} cones ({some(names)}) are" if len(cones) else "no cones are"
            raise MeshError(
                f"{given} too few for the component of faces "
                f"{some(submesh.faces)}, which is closed, of Euler characteristic "
                f"{submesh.topology.characteristic}: give at least {max(needed, 2)}"
            )
        if not len(cones):
            return np.zeros(0), None, None
        scale = ConeScale.at(component.closed, nodes)
        curvature: FloatArray = scale.curvature
        if wanted == "quarter":
            quantised = quantised_curvatures(component, scale)
            curvature = np.asarray(quantised.for_stretch * QUARTER_TURN)
        angle = 2 * np.pi - curvature
    around = component.n_triangles[nodes]
    bad = np.flatnonzero(~are_possible(angle, around))
    if len(bad):
        i = bad[0]
        given, other = ("would be", "your own") if wanted is None else ("is", "other")
        raise MeshError(
            f"the angle sum of {len(bad)} of {len(cones)} cones is outside of what triangles can have: at "
            f"vertex {names[i]} it {given} {angle[i]:.4g} rad, and must be within 0 and {around[i]} pi = "
            f"{np.pi * around[i]:.4g}: give more cones near vertices {some(names[bad])}, or {other} "
            "angles"
        )
    return np.asarray(angle), scale, quantised


def _check_gauss_bonnet(component: ConeComponent, names: IntArray, angle: FloatArray) -> None:
    """Raise `MeshError` if the curvatures do not sum to what a closed surface has."""
    total = component.total_curvature
    if total is None or abs((2 * np.pi - angle).sum() - total) < 1e-6:
        return
    right = 2 * np.pi * len(angle) - total
    raise MeshError(
        f"the angles of cones at vertices {some(names)} sum to {angle.sum():.6g} rad; on a "
        f"closed surface of Euler characteristic {component.submesh.topology.characteristic}, "
        f"those of {len(angle)} cones have to sum to {right:.6g} (Gauss-Bonnet): "
        f"change them by {right - angle.sum():+.6g} in all"
        + (", or from degrees to radians" if np.isclose(np.deg2rad(angle).sum(), right) else "")
    )


def are_possible(angle: FloatArray, n_triangles: IntArray) -> BoolArray:
    """Whether so many triangles around a vertex can have these angle sums."""
    return np.asarray((angle > 0) & (angle < np.pi * n_triangles))


def least_quarter_turns(n_triangles: IntArray, of_corner: float = QUARTERS_OF_CORNER) -> IntArray:
    """The least curvature, in quarter turns, of a cone with so many triangles.

    A corner takes `of_corner` quarter turns at most. At least a quarter turn is left to the cone.
    """
    least = FULL_TURN - np.floor(of_corner * n_triangles).astype(np.int64)
    return np.asarray(np.minimum(least, FULL_TURN - 1))


def quantised_curvatures(component: ConeComponent, scale: ConeScale) -> QuantisedCurvatures:
    """The cones' curvatures in quarter turns; with wider corners where that saves much stretch."""
    n_triangles = component.n_triangles[scale.nodes]
    narrow = QuantisedCurvatures(scale, least_quarter_turns(n_triangles), FULL_TURN - 1)
    much = np.log(USABLE_STRETCH)
    if narrow.log_stretch <= np.log(scale.stretch) + much:
        return narrow
    wide = replace(narrow, least=least_quarter_turns(n_triangles, QUARTERS_OF_CROWDED_CORNER))
    return wide if wide.log_stretch < narrow.log_stretch - much else narrow
