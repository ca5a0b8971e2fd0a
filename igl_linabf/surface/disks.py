"""Concatenate many small disks into one mesh, which is checked and measured at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .._core import boundary_loops, connected_labels, find_edges, side_products
from .._types import BoolArray, FloatArray, IntArray
from .constants import LARGEST_COORDINATE, SMALLEST_COORDINATE
from .ragged import Ragged
from .topology import Topology, find_nonmanifold_edges

Arrays = tuple[FloatArray, IntArray]  # V (#V, 3) float64 and F (#F, 3) int64


@dataclass(frozen=True, eq=False)
class Disks:
    """A batch of disks without holes, concatenated into one mesh.

    Attributes
    ----------
    topology : Topology
        Connectivity of all disks; loop i is the boundary of disk i.
    double_area : (#F,) float64
        Twice the area of each face.
    dot : (3, #F) float64
        Scalar product of the two sides that meet at each corner.
    vertices, faces : Ragged
        The vertices and faces of each disk.
    """

    topology: Topology
    double_area: FloatArray
    dot: FloatArray
    vertices: Ragged
    faces: Ragged

    def __len__(self) -> int:
        return len(self.faces)

    @cached_property
    def area(self) -> FloatArray:
        """Area of each disk."""
        return np.asarray(self.faces.sum(self.double_area)) / 2

    @cached_property
    def boundary_loops(self) -> tuple[IntArray, Ragged]:
        """The vertices of all boundary loops, and their division into disks."""
        loops = self.topology.loops
        return np.concatenate(loops), Ragged.from_sizes([len(loop) for loop in loops])


def concatenate_sound_disks(meshes: Sequence[Arrays]) -> tuple[Disks | None, IntArray]:
    """Concatenate the meshes that are valid disks without holes; return them and their indices in `meshes`.

    For any other mesh, `planar_mesh` raises an error that describes its defects.
    """
    places = np.arange(len(meshes))
    while len(places):
        disks, good = _concatenate_disks([meshes[i] for i in places.tolist()])
        if disks is not None:
            return disks, places
        places = places[good]
    return None, places


def _concatenate_disks(meshes: list[Arrays]) -> tuple[Disks | None, BoolArray]:
    """Concatenate the meshes if all are disks, otherwise return None; also mark meshes that may be disks."""
    vertices = Ragged.from_sizes([len(V) for V, _ in meshes])
    faces = Ragged.from_sizes([len(F) for _, F in meshes])
    F = np.concatenate([F for _, F in meshes])
    corner = np.ascontiguousarray(F.T)
    n = faces.repeat(vertices.sizes)
    a, b, c = corner
    wrong = (corner.min(axis=0) < 0) | (corner.max(axis=0) >= n) | (a == b) | (b == c) | (c == a)
    good = ~faces.any(wrong)
    if not good.all():
        return None, good
    corner += faces.repeat(vertices.start[:-1])
    V = np.concatenate([V for V, _ in meshes])
    lost = np.bincount(corner.ravel(), minlength=len(V)) == 0
    with np.errstate(invalid="ignore"):
        largest = Ragged(3 * vertices.start).max(np.abs(V).ravel())  # NaN if any coordinate is NaN
        good = (largest > SMALLEST_COORDINATE) & (largest < LARGEST_COORDINATE) & ~vertices.any(lost)
    if not good.all():
        return None, good
    double_area, dot, least = side_products(V, corner)
    thin = ~(double_area > least)
    topology, sound = _build_topology(corner, vertices, faces)
    good = sound & ~faces.any(thin)
    if topology is None or not good.all():
        return None, good
    return Disks(topology, double_area, dot, vertices, faces), good


def _build_topology(corner: IntArray, vertices: Ragged, faces: Ragged) -> tuple[Topology | None, BoolArray]:
    """Build the connectivity if all meshes are disks, or return None; also mark the possible disks."""
    n, m = int(vertices.start[-1]), corner.shape[1]
    edges, sides, sound = find_edges(corner, n)
    of_edge = Ragged(np.searchsorted(np.minimum(*edges.T), vertices.start))  # edges are sorted by lower end
    good = np.ones(len(faces), dtype=bool)
    if not sound:
        _, crowded, turned = find_nonmanifold_edges(corner, edges)
        good = ~of_edge.any(crowded | turned)
    tail, head = edges[sides[1] < 0].T
    around, sizes, twice = boundary_loops(tail, head, n)
    good[np.searchsorted(vertices.start, twice, side="right") - 1] = False
    if not good.all():
        return None, good
    rim = Ragged.from_sizes(sizes)
    holes = np.diff(np.searchsorted(around[rim.start[:-1]], vertices.start))  # number of loops of each disk
    pairs = sides.T[sides[1] >= 0]
    pairs -= m * ((pairs >= m).astype(np.int64) + (pairs >= 2 * m))  # half-edges % m, but faster
    label = connected_labels(pairs, m)
    good = (holes == 1) & (vertices.sizes - of_edge.sizes + faces.sizes == 1)
    good &= faces.min(label) == faces.max(label)
    if not good.all():
        return None, good
    loops = tuple(rim.split(around))
    return Topology(n, corner, edges, sides, loops, len(loops)), good
