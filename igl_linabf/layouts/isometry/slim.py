"""igl's SLIM (Rabinovich et al. 2017); by it, a map without flips from one that has some (the guarantee)."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import igl
import numpy as np

from ..._runtime import advance
from ..._types import ComplexArray, IntArray
from ...angles import corner_angles
from ...linalg import Solvers
from ...surface import (
    HOPELESS_AREA_RATIO,
    NEXT,
    PREV,
    SAFE_AREA_RATIO,
    Mesh,
    area_scale_ratio,
    complex_positions,
    coordinates,
    flat_angles,
    signed_double_areas,
)
from ..convex import on_circle, patched
from .constants import MAX_SLIM_CHUNKS, SLIM_CHUNK, SLIM_STALLED_FALL

Place = Callable[[ComplexArray], ComplexArray]


@dataclass(frozen=True, eq=False)
class InjectiveMap:
    """A map without flipped triangles.

    Attributes
    ----------
    z : (#V,) complex128
    start : str
        What SLIM started from.
    iterations : int
        Its iterations up to this map.
    distortion : float
        Its F/3nt.
    """

    z: ComplexArray
    start: str
    iterations: int
    distortion: float


def injective(mesh: Mesh, z: ComplexArray, place: Place, solvers: Solvers) -> InjectiveMap | None:
    """Make a map without flipped triangles from one that has some.

    First a valid start is found. A patch around the flipped triangles is embedded anew, wider and
    wider. If no patch helps, the whole surface is embedded in a circle, which is valid in exact
    arithmetic. From there igl's SLIM (Rabinovich et al. 2017) lowers the conformal energy sum
    A (s1^2 + s2^2) / (2 s1 s2). No triangle can flip in its line search. The map of the least
    F/3nt is kept.

    `place` moves maps to where the caller wants them. Flips are counted after `place`, since rounding
    can flip very small triangles. Returns None if no start was valid.
    """
    corner = mesh.topology.corner
    best = None
    for name, starts in (
        ("the map with its flipped triangles embedded anew", patched(mesh.topology, z, solvers)),
        ("an embedding in a circle", on_circle(mesh.topology, solvers)),
    ):
        for start in starts:
            at = place(start)
            if upright(at, corner):
                made = _lower_by_slim(mesh, start, InjectiveMap(at, name, 0, _distortion(mesh, at)), place)
                best = made if best is None or made.distortion < best.distortion else best
                break
        # where the ratio is larger, rounding ends SLIM early
        if best is not None and area_scale_ratio(mesh, best.z) <= SAFE_AREA_RATIO:
            break
    return best


def embedded_inside(
    mesh: Mesh, z: ComplexArray, circle: bool, place: Place, solvers: Solvers
) -> tuple[ComplexArray, str] | None:
    """A map without flipped triangles that has the boundary of one with some, and how it was made.

    As the first part of `injective`. If the boundary is convex, and no chord joins two of its vertices on
    one straight side, the widest patch is valid in exact arithmetic (Tutte 1963). On a circle the
    vertices may be too close for double precision; they are then spaced evenly.
    """
    hopeless = area_scale_ratio(mesh, z) > HOPELESS_AREA_RATIO
    for made in () if hopeless else patched(mesh.topology, z, solvers):
        if upright(made, mesh.topology.corner):
            return made, "convex combinations around the flipped triangles"
    for made in on_circle(mesh.topology, solvers) if circle else ():
        if upright(at := place(made), mesh.topology.corner):
            return at, "an embedding in a circle, its vertices spaced evenly"
    return None


def _lower_by_slim(mesh: Mesh, start: ComplexArray, best: InjectiveMap, place: Place) -> InjectiveMap:
    """SLIM from a valid map, until F/3nt no longer falls or rounding flips a triangle."""
    for chunk, made in enumerate(slim(mesh, start, igl.MappingEnergyType.CONFORMAL, SLIM_CHUNK), start=1):
        at = place(made)
        if not upright(at, mesh.topology.corner):
            break
        reached, least = _distortion(mesh, at), best.distortion
        if reached < least:
            best = InjectiveMap(at, best.start, SLIM_CHUNK * chunk, reached)
        if chunk > 1 and not reached < (1 - SLIM_STALLED_FALL) * least:
            break
    return best


def slim(
    mesh: Mesh, start: ComplexArray, energy: igl.MappingEnergyType, chunk: int
) -> Iterator[ComplexArray]:
    """The maps after every `chunk` iterations of igl's SLIM from a valid map; surface and start of area 1."""
    size = float(np.sqrt(signed_double_areas(start, mesh.topology.corner).sum() / 2))
    data = igl.slim_precompute(
        np.asfortranarray(mesh.V / np.sqrt(mesh.area)),
        np.asfortranarray(mesh.faces, dtype=np.int32),
        np.asfortranarray(coordinates((start - start.mean()) / size)),
        energy,
        np.zeros(0, dtype=np.int32),
        np.zeros((0, 2), order="F"),
        0.0,
    )
    for _ in range(MAX_SLIM_CHUNKS):
        made = complex_positions(igl.slim_solve(data, chunk))
        advance("SLIM", 0.1)
        yield made


def _distortion(mesh: Mesh, z: ComplexArray) -> float:
    """F/3nt."""
    alpha = corner_angles(mesh)
    return float((((flat_angles(z, mesh.topology.corner) - alpha) / alpha) ** 2).mean())


def upright(z: ComplexArray, corner: IntArray) -> bool:
    """Whether every triangle is positively oriented, seen from each of its corners."""
    return all(bool((signed_double_areas(z, corner[turn]) > 0).all()) for turn in ([0, 1, 2], NEXT, PREV))
