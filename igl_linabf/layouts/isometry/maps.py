"""The isometric layout: from a map without flipped triangles to one that keeps lengths as well as it can."""

from __future__ import annotations

from dataclasses import dataclass, replace

import igl
import numpy as np

from ..._core import centred
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...linalg import Solvers
from ...surface import Disks, Mesh, Pins, Ragged, complex_positions, shape_is_pinned, signed_double_areas
from ..choice import place_map
from .constants import (
    FAR_FROM_ISOMETRY,
    MAX_PINNED_STEPS,
    PINS_MET,
    SLIM_CHUNK_FAR,
    SLIM_SLOW_FALL,
    STIFFNESSES,
    WEAK_FIT,
)
from .energy import Rest
from .newton import Hessians, IsometricEnergy, Springs, descend
from .slim import slim, upright


@dataclass(frozen=True, eq=False)
class IsometricMap:
    """A map without flipped triangles, lowered in energy.

    Attributes
    ----------
    z : (#V,) complex128
    slim, newton : int
        Iterations of SLIM, and steps of Newton's method after it.
    stalled : bool
        Whether the energy has stalled within the steps allowed.
    energy : float
        1 for an isometry.
    missed : float
        The largest distance of a vertex from its pin, relative to the map's size; 0 if all are met.
    """

    z: ComplexArray
    slim: int
    newton: int
    stalled: bool
    energy: float
    missed: float


def isometric(
    mesh: Mesh, start: ComplexArray, weight: float, pinned: Pins | None, solvers: Solvers
) -> IsometricMap:
    """Lower the isometric energy from a map without flipped triangles, until it stalls.

    Far from an isometry igl's SLIM is fast, near to one Newton's method. Two pins are met by a similarity,
    as in the layouts of angles. With more of them the surface has the scale at which the free map fits the
    pins best, and stiffer and stiffer springs draw the vertices to their pins.
    """
    energy, hessians = _energy_of(mesh, weight, solvers)
    corner = mesh.topology.corner
    z = start / np.sqrt(signed_double_areas(start, corner).sum() / 2)
    z, slimmed = _nearer_to_isometry(mesh, energy, z)
    z, (steps,), (stalled,) = descend(energy, z, hessians)
    missed = 0.0
    if shape_is_pinned(pinned):
        made, z, more, missed = _drawn_to_pins(energy, hessians, z, pinned)
        steps += more
    else:
        made = place_map(mesh.topology, z, mesh.area, pinned)
    return IsometricMap(made, slimmed, int(steps), bool(stalled), float(energy.of_charts(z)[0]), missed)


def isometric_together(
    disks: Disks, z: ComplexArray, weight: float, solvers: Solvers
) -> tuple[ComplexArray, FloatArray, IntArray, BoolArray]:
    """Lower the energy of disks side by side, by one system.

    Returns the map, each disk of its area, centred and turned; energies; steps; and which are to be taken:
    those that began near an isometry and stalled.
    """
    corner, vertices, faces = disks.topology.corner, disks.vertices, disks.faces
    rest = Rest.of(corner, disks.double_area, disks.dot, faces)
    energy = IsometricEnergy(rest, vertices, faces, weight)
    z = z / vertices.repeat(np.sqrt(faces.sum(signed_double_areas(z, corner)) / 2))
    near = energy.of_charts(z) <= FAR_FROM_ISOMETRY
    z, steps, stalled = descend(energy, z, Hessians(corner, len(z), solvers))
    value = energy.of_charts(z)
    double = np.abs(signed_double_areas(z, corner))
    z = centred(z, corner, double, disks.area, vertices.start, faces.start)
    sound = ~faces.any(~(signed_double_areas(z, corner) > 0))
    return z, value, steps, near & sound & stalled


def at_pins(
    mesh: Mesh, start: ComplexArray, weight: float, pinned: Pins, solvers: Solvers
) -> tuple[ComplexArray, float]:
    """A map without flipped triangles drawn to more than two pins, and how far it misses them."""
    z = start / np.sqrt(signed_double_areas(start, mesh.topology.corner).sum() / 2)
    energy, hessians = _energy_of(mesh, weight, solvers)
    made, _, _, missed = _drawn_to_pins(energy, hessians, z, pinned)
    return made, missed


def _energy_of(mesh: Mesh, weight: float, solvers: Solvers) -> tuple[IsometricEnergy, Hessians]:
    """The energy of a single chart, and the pattern of its Hessian."""
    corner, n = mesh.topology.corner, mesh.topology.n
    faces = Ragged.of_sizes([corner.shape[1]])
    rest = Rest.of(corner, mesh.double_area, mesh.dot, faces)
    return IsometricEnergy(rest, Ragged.of_sizes([n]), faces, weight), Hessians(corner, n, solvers)


def _nearer_to_isometry(mesh: Mesh, energy: IsometricEnergy, z: ComplexArray) -> tuple[ComplexArray, int]:
    """The map that SLIM makes of one that is far from an isometry, and its iterations."""
    reached = float(energy.of_charts(z)[0])
    if reached <= FAR_FROM_ISOMETRY:
        return z, 0
    iterations = 0
    for at in slim(mesh, z, igl.MappingEnergyType.SYMMETRIC_DIRICHLET, SLIM_CHUNK_FAR):
        value = float(energy.of_charts(at)[0])
        if not (value < reached and upright(at, mesh.topology.corner)):
            break
        slow = value > (1 - SLIM_SLOW_FALL) * reached
        z, reached, iterations = at, value, iterations + SLIM_CHUNK_FAR
        if slow:
            break
    return z, iterations


def _drawn_to_pins(
    energy: IsometricEnergy, hessians: Hessians, z: ComplexArray, pinned: Pins
) -> tuple[ComplexArray, ComplexArray, int, float]:
    """The map at its pins, the same where the surface has area one, steps, and the largest distance left."""
    index, position = pinned[0], complex_positions(pinned[1])
    mean, middle = z[index].mean(), position.mean()
    own, wanted = z[index] - mean, position - middle
    scale = np.vdot(own, wanted) / np.vdot(own, own)
    whole = np.linalg.norm(wanted) / np.linalg.norm(own)
    if abs(scale) < WEAK_FIT * whole:  # hardly a turn fits better than another: the best scale has no size
        scale = whole * (scale / abs(scale) if scale else 1 + 0j)
    to = z.copy()
    to[index] = wanted / scale + mean
    steps, missed = 0, np.inf
    for stiffness in STIFFNESSES:
        pull = np.zeros(len(z))
        pull[index] = stiffness
        pulled = replace(energy, springs=Springs(pull, to))
        z, (more,), _ = descend(pulled, z, hessians, MAX_PINNED_STEPS)
        before, missed, steps = missed, float(np.abs(z - to)[index].max()), steps + more
        # out of reach: a spring stiffer than the first two, which the surface may resist, brings a tenth
        if stiffness > STIFFNESSES[1] and missed > before / 2:
            break
    made = (z - mean) * scale + middle
    if missed <= PINS_MET:
        exact = made.copy()
        exact[index] = position
        if upright(exact, energy.rest.corner):
            return exact, z, steps, 0.0
    return made, z, steps, missed
