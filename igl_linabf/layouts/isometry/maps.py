"""The isometric layout: from a map without flipped triangles to one that keeps lengths as well as it can."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..._core import centred
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...linalg import Solvers
from ...surface import Disks, Mesh, Pins, Ragged, complex_positions, shape_is_pinned, signed_double_areas
from ..choice import place_map
from .constants import MAX_PINNED_STEPS, PINS_MET, STALLED_FALL, STIFFNESSES, UNWEIGHTED_TOL, WEAK_FIT
from .energy import Rest
from .newton import Hessians, IsometricEnergy, Springs, descend
from .slim import upright


@dataclass(frozen=True, eq=False)
class IsometricMap:
    """A map without flipped triangles, lowered in energy.

    Attributes
    ----------
    z : (#V,) complex128
    steps : int
        Of Newton's method.
    stalled : bool
        Whether the energy has stalled within the steps allowed.
    energy : float
        1 for an isometry.
    missed : float
        The largest distance of a vertex from its pin, relative to the map's size; 0 if all are met.
    """

    z: ComplexArray
    steps: int
    stalled: bool
    energy: float
    missed: float


def isometric(
    mesh: Mesh,
    start: ComplexArray,
    weight: float,
    pinned: Pins | None,
    solvers: Solvers,
    tol: float = STALLED_FALL,
) -> IsometricMap:
    """Lower the isometric energy from a map without flipped triangles, until it stalls.

    It has stalled where further steps lower it by less than `tol` of it. Two pins are met by a similarity, as
    in the layouts of angles. With more of them the surface has the scale at which the free map fits the
    pins best, and stiffer and stiffer springs draw the vertices to their pins.
    """
    energy, hessians = _energy_of(mesh, weight, solvers)
    z, (steps,), (stalled,) = _lowered(energy, start, hessians, tol)
    missed = 0.0
    if shape_is_pinned(pinned):
        made, z, more, missed = _drawn_to_pins(energy, hessians, z, pinned)
        steps += more
    else:
        made = place_map(mesh.topology, z, mesh.area, pinned)
    return IsometricMap(made, int(steps), bool(stalled), float(energy.of_charts(z)[0]), missed)


def isometric_together(
    disks: Disks, z: ComplexArray, weight: float, solvers: Solvers, tol: float
) -> tuple[ComplexArray, FloatArray, IntArray, BoolArray]:
    """Lower the energy of disks side by side, by one system.

    Returns the map, each disk of its area, centred and turned; energies; steps; and which are to be taken:
    those that stalled.
    """
    corner, vertices, faces = disks.topology.corner, disks.vertices, disks.faces
    rest = Rest.of(corner, disks.double_area, disks.dot, faces)
    energy = IsometricEnergy(rest, vertices, faces, weight)
    z, steps, stalled = _lowered(energy, z, Hessians(corner, len(z), solvers), tol)
    value = energy.of_charts(z)
    double = np.abs(signed_double_areas(z, corner))
    z = centred(z, corner, double, disks.area, vertices.start, faces.start)
    sound = ~faces.any(~(signed_double_areas(z, corner) > 0))
    return z, value, steps, sound & stalled


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


def _lowered(
    energy: IsometricEnergy, start: ComplexArray, hessians: Hessians, tol: float
) -> tuple[ComplexArray, IntArray, BoolArray]:
    """What `descend` returns, from maps of any scale; by the unweighted energy first if the weight is more.

    Where areas are far from those of the surface, a weighted energy grows faster than its model.
    """
    size = energy.faces.sum(signed_double_areas(start, energy.rest.corner)) / 2
    z, first = start / energy.vertices.repeat(np.sqrt(size)), np.zeros(len(size), dtype=np.int64)
    if energy.weight > 1:
        z, first, _ = descend(replace(energy, weight=1.0), z, hessians, UNWEIGHTED_TOL)
    z, steps, stalled = descend(energy, z, hessians, tol)
    return z, first + steps, stalled


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
    steps, missed = 0, float(np.abs(z - to)[index].max())
    for stiffness in STIFFNESSES:
        if missed <= PINS_MET:
            break
        pull = np.zeros(len(z))
        pull[index] = stiffness
        pulled = replace(energy, springs=Springs(pull, to))
        z, (more,), _ = descend(pulled, z, hessians, max_steps=MAX_PINNED_STEPS)
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
