"""Compute the isometric layout, which preserves lengths as well as possible, from a map without flips."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..._core import normalize_maps
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...linalg import Solvers
from ...surface import Disks, Mesh, Pins, Ragged, complex_positions, shape_is_pinned, signed_double_areas
from ..choice import place_map
from .coarse import CoarseHessians
from .energy import RestTriangles
from .newton import STALLED_FALL, HessianModel, Hessians, IsometricEnergy, Springs, minimise_energy
from .slim import is_positively_oriented

UNWEIGHTED_TOL = 0.05  # relative tolerance of the unweighted energy, which is reduced first
STIFFNESSES = 10.0 ** np.arange(0, 11, 2)  # stiffnesses of the springs to the pins; an isometry has energy 1
MAX_PINNED_STEPS = 40  # maximum number of Newton steps for each stiffness
PINS_MET = 1e-6  # move vertices onto pins within this distance, for a surface of area 1
MOST_FREE_VERTICES = 1_000_000  # maximum number of vertices for the full Hessian, which takes 6 GB
WEAK_FIT = 0.3  # below this correlation of the free map and the pins, the pins determine the size


@dataclass(frozen=True, eq=False)
class IsometricMap:
    """A map without flipped triangles that has nearly minimal energy.

    Attributes
    ----------
    z : (#V,) complex128
    steps : int
        Number of Newton steps.
    stalled : bool
        Whether the energy stalled within the allowed steps.
    energy : float
        Isometric energy; 1 for an isometry.
    missed : float
        Largest distance of a vertex from its pin, relative to the size of the map; 0 if all pins are met.
    """

    z: ComplexArray
    steps: int
    stalled: bool
    energy: float
    missed: float


def make_isometric(
    mesh: Mesh,
    start: ComplexArray,
    weight: float,
    pinned: Pins | None,
    solvers: Solvers,
    tol: float = STALLED_FALL,
) -> IsometricMap:
    """Reduce the isometric energy of a map without flipped triangles until the energy stalls.

    The energy has stalled if further steps would reduce it by less than the share `tol`. Two pins are met by
    a similarity, as in the layouts of angles. With more pins, the map is first scaled to fit the pins best,
    and springs of increasing stiffness then pull the vertices to their pins.
    """
    energy = _make_single_chart_energy(mesh, weight)
    coarse = mesh.topology.n > MOST_FREE_VERTICES and not shape_is_pinned(pinned)
    corner = mesh.topology.corner
    hessians = CoarseHessians(corner, start, solvers) if coarse else Hessians(corner, len(start), solvers)
    z, (steps,), (stalled,) = _lower_energy(energy, start, hessians, tol)
    missed = 0.0
    if shape_is_pinned(pinned):
        made, z, more, missed = _pull_to_pins(energy, hessians, z, pinned)
        steps += more
    else:
        made = place_map(mesh.topology, z, mesh.area, pinned)
    return IsometricMap(made, int(steps), bool(stalled), float(energy.measure_chart_energies(z)[0]), missed)


def flatten_isometrically(
    disks: Disks, z: ComplexArray, weight: float, solvers: Solvers, tol: float
) -> tuple[ComplexArray, FloatArray, IntArray, BoolArray]:
    """Reduce the energy of disks side by side with a single system.

    Returns the map, the energies, the steps, and a mask of the valid disks. Each disk of the map has its own
    area, and is centred and turned to its principal axes. A disk is valid if its energy stalled and no
    triangle is flipped.
    """
    corner, vertices, faces = disks.topology.corner, disks.vertices, disks.faces
    rest = RestTriangles.from_charts(corner, disks.double_area, disks.dot, faces)
    energy = IsometricEnergy(rest, vertices, faces, weight)
    z, steps, stalled = _lower_energy(energy, z, Hessians(corner, len(z), solvers), tol)
    value = energy.measure_chart_energies(z)
    double = np.abs(signed_double_areas(z, corner))
    z = normalize_maps(z, corner, double, disks.area, vertices.start, faces.start)
    sound = ~faces.any(~(signed_double_areas(z, corner) > 0))
    return z, value, steps, sound & stalled


def pull_to_pins(
    mesh: Mesh, start: ComplexArray, weight: float, pinned: Pins, solvers: Solvers
) -> tuple[ComplexArray, float]:
    """Pull a map without flips to more than two pins; return the map and the largest distance to a pin."""
    z = start / np.sqrt(signed_double_areas(start, mesh.topology.corner).sum() / 2)
    energy = _make_single_chart_energy(mesh, weight)
    hessians = Hessians(mesh.topology.corner, len(z), solvers)
    made, _, _, missed = _pull_to_pins(energy, hessians, z, pinned)
    return made, missed


def _make_single_chart_energy(mesh: Mesh, weight: float) -> IsometricEnergy:
    """Return the energy of a single chart."""
    corner, n = mesh.topology.corner, mesh.topology.n
    faces = Ragged.from_sizes([corner.shape[1]])
    rest = RestTriangles.from_charts(corner, mesh.double_area, mesh.dot, faces)
    return IsometricEnergy(rest, Ragged.from_sizes([n]), faces, weight)


def _lower_energy(
    energy: IsometricEnergy, start: ComplexArray, hessians: HessianModel, tol: float
) -> tuple[ComplexArray, IntArray, BoolArray]:
    """Minimise the energy with `minimise_energy`, from maps of any scale.

    If the weight is larger than 1, the unweighted energy is reduced first. A weighted energy grows faster
    than its quadratic model if areas in the map differ much from areas on the surface.
    """
    size = energy.faces.sum(signed_double_areas(start, energy.rest.corner)) / 2
    z, first = start / energy.vertices.repeat(np.sqrt(size)), np.zeros(len(size), dtype=np.int64)
    if energy.weight > 1:
        z, first, _ = minimise_energy(replace(energy, weight=1.0), z, hessians, UNWEIGHTED_TOL)
    z, steps, stalled = minimise_energy(energy, z, hessians, tol)
    return z, first + steps, stalled


def _pull_to_pins(
    energy: IsometricEnergy, hessians: HessianModel, z: ComplexArray, pinned: Pins
) -> tuple[ComplexArray, ComplexArray, int, float]:
    """Pull the map to its pins by springs of increasing stiffness.

    Returns the map, the same map for a surface of area 1, the steps, and the largest distance to a pin.
    """
    index, position = pinned[0], complex_positions(pinned[1])
    mean, middle = z[index].mean(), position.mean()
    own, wanted = z[index] - mean, position - middle
    scale = np.vdot(own, wanted) / np.vdot(own, own)
    whole = np.linalg.norm(wanted) / np.linalg.norm(own)
    if abs(scale) < WEAK_FIT * whole:  # no rotation fits well, and the best scale is too small
        scale = whole * (scale / abs(scale) if scale else 1 + 0j)
    to = z.copy()
    to[index] = wanted / scale + mean
    steps, missed = 0, float(np.abs(z - to)[index].max())
    for stiffness in STIFFNESSES:
        if missed <= PINS_MET:
            break
        pull = np.zeros(len(z))
        pull[index] = stiffness
        pulled = replace(energy, springs=Springs(pull, to))
        z, (more,), _ = minimise_energy(pulled, z, hessians, max_steps=MAX_PINNED_STEPS)
        before, missed, steps = missed, float(np.abs(z - to)[index].max()), steps + more
        # pins are out of reach if, after the first two, a stiffer spring does not halve the distance
        if stiffness > STIFFNESSES[1] and missed > before / 2:
            break
    made = (z - mean) * scale + middle
    if missed <= PINS_MET:
        exact = made.copy()
        exact[index] = position
        if is_positively_oriented(exact, energy.rest.corner):
            return exact, z, steps, 0.0
    return made, z, steps, missed
