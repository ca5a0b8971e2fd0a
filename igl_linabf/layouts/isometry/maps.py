"""The isometric layout: from a map without flipped triangles to one that keeps lengths as well as it can."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np

from ..._core import centred
from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from ...linalg import Solvers
from ...surface import Disks, Mesh, Pins, Ragged, complex_positions, shape_is_pinned, signed_double_areas
from ..choice import placed
from .energy import Rest
from .newton import Charts, Hessians, Springs, descend
from .slim import slim, upright

FAR = 2.0  # energy from which SLIM comes first: Newton's method takes many short steps there
CHUNK = 2  # SLIM's iterations at a time
NEAR = 0.02  # relative fall in a chunk below which Newton's method is faster
STIFFNESS = 10.0 ** np.arange(0, 11, 2)  # of the springs to the pins, one after the other
SOFT = 100.0  # stiffness up to which the energy may hold them back
STEPS_EACH = 40
PINS_MET = 1e-6  # distance of a vertex from its pin, relative to the map's size, from which it is put there


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
    field = _Field.of(mesh, solvers)
    corner = mesh.topology.corner
    z = start / np.sqrt(signed_double_areas(start, corner).sum() / 2)
    z, slimmed = _unfolded(mesh, field.charts, z, weight)
    z, (steps,), (stalled,) = descend(field.charts, z, weight, field.hessians)
    missed = 0.0
    if shape_is_pinned(pinned):
        made, z, more, missed = _drawn_to_pins(field, z, weight, pinned)
        steps += more
    else:
        made = placed(mesh.topology, z, mesh.area, pinned)
    energy = float(field.charts.energy(z, weight)[0])
    return IsometricMap(made, slimmed, int(steps), bool(stalled), energy, missed)


def isometric_together(
    disks: Disks, z: ComplexArray, weight: float, solvers: Solvers
) -> tuple[ComplexArray, FloatArray, IntArray, BoolArray]:
    """Lower the energy of disks side by side, by one system.

    Returns the map, each disk of its area, centred and turned; energies; steps; and which are to be taken:
    those that began near an isometry and stalled.
    """
    corner, vertices, faces = disks.topology.corner, disks.vertices, disks.faces
    charts = Charts(Rest.of(corner, disks.double_area, disks.dot, faces), vertices, faces)
    z = z / vertices.repeat(np.sqrt(faces.sum(signed_double_areas(z, corner)) / 2))
    near = charts.energy(z, weight) <= FAR
    z, steps, stalled = descend(charts, z, weight, Hessians(corner, len(z), solvers))
    energy = charts.energy(z, weight)
    double = np.abs(signed_double_areas(z, corner))
    z = centred(z, corner, double, disks.area, vertices.start, faces.start)
    sound = ~faces.any(~(signed_double_areas(z, corner) > 0))
    return z, energy, steps, near & sound & stalled


def at_pins(
    mesh: Mesh, start: ComplexArray, weight: float, pinned: Pins, solvers: Solvers
) -> tuple[ComplexArray, float]:
    """A map without flipped triangles drawn to more than two pins, and how far it misses them."""
    z = start / np.sqrt(signed_double_areas(start, mesh.topology.corner).sum() / 2)
    made, _, _, missed = _drawn_to_pins(_Field.of(mesh, solvers), z, weight, pinned)
    return made, missed


@dataclass(frozen=True, eq=False)
class _Field:
    """The energy of one mesh."""

    charts: Charts
    hessians: Hessians

    @classmethod
    def of(cls, mesh: Mesh, solvers: Solvers) -> _Field:
        corner, n = mesh.topology.corner, mesh.topology.n
        faces = Ragged.of_sizes([corner.shape[1]])
        charts = Charts(Rest.of(corner, mesh.double_area, mesh.dot, faces), Ragged.of_sizes([n]), faces)
        return cls(charts, Hessians(corner, n, solvers))


def _unfolded(mesh: Mesh, charts: Charts, z: ComplexArray, weight: float) -> tuple[ComplexArray, int]:
    """The map that SLIM makes of one that is far from an isometry, and its iterations."""
    reached = float(charts.energy(z, weight)[0])
    if reached <= FAR:
        return z, 0
    iterations = 0
    for at in slim(mesh, z, igl.MappingEnergyType.SYMMETRIC_DIRICHLET, CHUNK):
        energy = float(charts.energy(at, weight)[0])
        if not (energy < reached and upright(at, mesh.topology.corner)):
            break
        slow = energy > (1 - NEAR) * reached
        z, reached, iterations = at, energy, iterations + CHUNK
        if slow:
            break
    return z, iterations


def _drawn_to_pins(
    field: _Field, z: ComplexArray, weight: float, pinned: Pins
) -> tuple[ComplexArray, ComplexArray, int, float]:
    """The map at its pins, the same where the surface has area one, steps, and the largest distance left."""
    index, position = pinned[0], complex_positions(pinned[1])
    mean, middle = z[index].mean(), position.mean()
    own, wanted = z[index] - mean, position - middle
    scale = np.vdot(own, wanted) / np.vdot(own, own)
    if not scale:  # no turn fits better than another
        scale = np.linalg.norm(wanted) / np.linalg.norm(own) + 0j
    to = z.copy()
    to[index] = wanted / scale + mean
    steps, missed = 0, np.inf
    for stiffness in STIFFNESS:
        pull = np.zeros(len(z))
        pull[index] = stiffness
        z, (more,), _ = descend(field.charts, z, weight, field.hessians, Springs(pull, to), STEPS_EACH)
        before, missed, steps = missed, float(np.abs(z - to)[index].max()), steps + more
        if stiffness > SOFT and missed > before / 2:  # out of reach, as a spring that rules brings a tenth
            break
    made = (z - mean) * scale + middle
    if missed <= PINS_MET:
        exact = made.copy()
        exact[index] = position
        if upright(exact, field.charts.rest.corner):
            return exact, z, steps, 0.0
    return made, z, steps, missed
