"""Make maps without flips from maps with flips by the SLIM of igl (Rabinovich et al. 2017)."""

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
    complex_positions,
    compute_area_scale_ratio,
    compute_flat_angles,
    real_coordinates,
    signed_double_areas,
)
from ..convex import embed_in_circle, embed_patches

SLIM_CHUNK = 5  # iterations of SLIM between two checks of the map
MAX_SLIM_CHUNKS = 60
SLIM_STALLED_FALL = 2e-3  # SLIM has stalled if the angle distortion decreases by a smaller fraction per chunk

Place = Callable[[ComplexArray], ComplexArray]


@dataclass(frozen=True, eq=False)
class InjectiveMap:
    """A map without flipped triangles.

    Attributes
    ----------
    z : (#V,) complex128
    start : str
        The map from which SLIM started.
    iterations : int
        Iterations of SLIM up to this map.
    distortion : float
        Mean squared relative change of the angles by the map (F/3nt of the paper).
    """

    z: ComplexArray
    start: str
    iterations: int
    distortion: float


def make_injective(mesh: Mesh, z: ComplexArray, place: Place, solvers: Solvers) -> InjectiveMap | None:
    """Make a map without flipped triangles from a map with flips.

    First, a valid start is found: patches of increasing width around the flipped triangles are embedded
    again. If no patch helps, the whole surface is embedded in a circle, which is valid in exact arithmetic.
    From the start, the SLIM of igl (Rabinovich et al. 2017) reduces the conformal energy sum A (s1^2 + s2^2)
    / (2 s1 s2). The line search of SLIM flips no triangle. The map with the least angle distortion
    F/3nt (the mean squared relative change of the angles) is returned.

    `place` moves maps to their final position. Flips are counted after `place`, because rounding can flip
    very small triangles. Returns None if no valid start was found.
    """
    corner = mesh.topology.corner
    best = None
    for name, starts in (
        ("the map with its flipped triangles embedded again", embed_patches(mesh.topology, z, solvers)),
        ("an embedding in a circle", embed_in_circle(mesh.topology, solvers)),
    ):
        for start in starts:
            at = place(start)
            if is_positively_oriented(at, corner):
                made = _reduce_distortion_by_slim(
                    mesh, start, InjectiveMap(at, name, 0, _measure_distortion(mesh, at)), place
                )
                best = made if best is None or made.distortion < best.distortion else best
                break
        # SLIM may have ended early, because of rounding, if the ratio of area scales is larger
        if best is not None and compute_area_scale_ratio(mesh, best.z) <= SAFE_AREA_RATIO:
            break
    return best


def embed_in_boundary(
    mesh: Mesh, z: ComplexArray, circle: bool, place: Place, solvers: Solvers
) -> tuple[ComplexArray, str] | None:
    """Make a map without flipped triangles that keeps the boundary of a map with flips.

    Returns the map and a description, or None. Patches are embedded again, as in `make_injective`. The widest
    patch is valid in exact arithmetic if the boundary is convex and no chord joins two vertices on the same
    straight side (Tutte 1963). If the boundary is a circle on which vertices are too close for double
    precision, all vertices of the circle are spaced evenly.
    """
    hopeless = compute_area_scale_ratio(mesh, z) > HOPELESS_AREA_RATIO
    for made in () if hopeless else embed_patches(mesh.topology, z, solvers):
        if is_positively_oriented(made, mesh.topology.corner):
            return made, "convex combinations around the flipped triangles"
    for made in embed_in_circle(mesh.topology, solvers) if circle else ():
        if is_positively_oriented(at := place(made), mesh.topology.corner):
            return at, "an embedding in a circle, its vertices spaced evenly"
    return None


def _reduce_distortion_by_slim(
    mesh: Mesh, start: ComplexArray, best: InjectiveMap, place: Place
) -> InjectiveMap:
    """Run SLIM from a valid map until the angle distortion stops decreasing or rounding flips a triangle."""
    for chunk, made in enumerate(run_slim(mesh, start, igl.MappingEnergyType.CONFORMAL, SLIM_CHUNK), start=1):
        at = place(made)
        if not is_positively_oriented(at, mesh.topology.corner):
            break
        reached, least = _measure_distortion(mesh, at), best.distortion
        if reached < least:
            best = InjectiveMap(at, best.start, SLIM_CHUNK * chunk, reached)
        if chunk > 1 and not reached < (1 - SLIM_STALLED_FALL) * least:
            break
    return best


def run_slim(
    mesh: Mesh, start: ComplexArray, energy: igl.MappingEnergyType, chunk: int
) -> Iterator[ComplexArray]:
    """Run the SLIM of igl from a valid map, and yield the map after every `chunk` iterations.

    The surface and the start are scaled to area 1.
    """
    size = float(np.sqrt(signed_double_areas(start, mesh.topology.corner).sum() / 2))
    data = igl.slim_precompute(
        np.asfortranarray(mesh.V / np.sqrt(mesh.area)),
        np.asfortranarray(mesh.faces, dtype=np.int32),
        np.asfortranarray(real_coordinates((start - start.mean()) / size)),
        energy,
        np.zeros(0, dtype=np.int32),
        np.zeros((0, 2), order="F"),
        0.0,
    )
    for _ in range(MAX_SLIM_CHUNKS):
        made = complex_positions(igl.slim_solve(data, chunk))
        advance("SLIM", 0.1)
        yield made


def _measure_distortion(mesh: Mesh, z: ComplexArray) -> float:
    """Return the mean squared relative change of the angles by a map (F/3nt of the paper)."""
    alpha = corner_angles(mesh)
    return float((((compute_flat_angles(z, mesh.topology.corner) - alpha) / alpha) ** 2).mean())


def is_positively_oriented(z: ComplexArray, corner: IntArray) -> bool:
    """Return True if every triangle is positively oriented, computed from each of its corners."""
    return all(bool((signed_double_areas(z, corner[turn]) > 0).all()) for turn in ([0, 1, 2], NEXT, PREV))
