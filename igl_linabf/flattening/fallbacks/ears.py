"""Map a disk to a circle without its ears, and add the ears on the arcs over their chords."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core import signed_double_areas
from ..._types import ComplexArray, FloatArray, IntArray
from ...layouts import place_map
from ...surface import (
    Mesh,
    Pins,
    Topology,
    build_topology,
    compute_flat_angles,
    drop_unused_vertices,
    with_outer_loop,
)

EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Ears:
    """The ears of a disk, which are faces with two boundary edges, and the disk without them.

    On a circle, the arc over the chord determines the shape of an ear, independent of the angles of the ear.
    If ears were part of the system, the angles at their chords would need many more digits than other angles.

    Attributes
    ----------
    whole, rest : Mesh
        The disk with the ears, and the disk without the ears.
    vertices, faces : (#rest V,), (#rest F,) int64
        Vertices and faces of `whole` that belong to `rest`.
    layers : tuple of (#ears, 3) int64 arrays
        The vertices of the ears that were removed in the same round, with the apex second and the chord from
        the third to the first.
    pinned : Pins or None
        Pins at vertices of `whole`.
    """

    whole: Mesh
    rest: Mesh
    vertices: IntArray
    faces: IntArray
    layers: tuple[IntArray, ...]
    pinned: Pins | None

    @classmethod
    def remove_from(cls, mesh: Mesh, pinned: Pins | None) -> Ears | None:
        """Remove the ears at the outer loop repeatedly, until none remain; return None if there are no ears.

        If all faces of a disk have three boundary vertices, no ears are removed.
        """
        faces, layers = mesh.topology.compute_once("without ears", lambda: _remove_ears(mesh.topology))
        if not layers:
            return None
        vertices, numbered = drop_unused_vertices(mesh.topology.corner.T[faces], mesh.topology.n)
        topology = build_topology(numbered, mesh.vertices[vertices])
        if len(topology.loops) > 1:
            on_rim = np.isin(vertices, mesh.topology.loops[0])
            topology = with_outer_loop(
                topology, next(i for i, loop in enumerate(topology.loops) if on_rim[loop[0]])
            )
        rest = Mesh(
            mesh.V[vertices],
            topology,
            mesh.double_area[faces],
            mesh.dot[:, faces],
            mesh.vertices[vertices],
            mesh.n_given,
        )
        return cls(mesh, rest, vertices, faces, layers, pinned)

    def add_to_map(self, rest: ComplexArray) -> ComplexArray:
        """Return the map of the disk with ears, given the map without ears, (#rest V,), on a circle.

        An apex divides the arc so that its two edges have the same length ratio as on the surface. If the arc
        is too flat for double precision, the apex is moved outwards by a few units of rounding.
        """
        V = self.whole.V
        z = np.zeros(self.whole.topology.n, dtype=np.complex128)
        z[self.vertices] = rest
        centre, radius = _fit_circle(rest[self.rest.topology.loops[0]])
        for ears in reversed(self.layers):
            before, apex, after = ears.T
            chord = z[after] - z[before]
            half = np.arcsin(np.minimum(np.abs(chord) / (2 * radius), 1.0))
            half = np.where((chord.conj() * (centre - z[before])).imag < 0, np.pi - half, half)
            ratio = np.linalg.norm(V[apex] - V[before], axis=1) / np.linalg.norm(V[after] - V[apex], axis=1)
            # a is half the arc to the apex, with sin a / sin(half - a) = ratio
            a = np.arctan2(ratio * np.sin(half), 1 + ratio * np.cos(half))
            z[apex] = z[before] + (z[before] - centre) * (2j * np.sin(a) * np.exp(1j * a))
        z = place_map(self.whole.topology, z, self.whole.area, self.pinned)
        before, apex, after = np.concatenate(self.layers).T
        outward, size = -1j * (z[after] - z[before]), float(np.abs(z).max())
        outward /= np.maximum(np.abs(outward), np.finfo(np.float64).tiny)
        flat = z[apex]
        for roundings in 2.0 ** np.arange(10):
            thin = ~(signed_double_areas(z, np.stack((before, apex, after))) > 0)
            z[apex[thin]] = flat[thin] + outward[thin] * (roundings * EPSILON * size)
        return z

    def add_to_angles(self, rest: FloatArray, z: ComplexArray) -> FloatArray:
        """Combine the angles of the disk without ears, `rest`, with the angles of the ears in the map z."""
        corner, ears = self.whole.topology.corner, np.ones(len(self.whole.double_area), dtype=bool)
        ears[self.faces] = False
        alpha = np.empty(corner.shape)
        alpha[:, self.faces], alpha[:, ears] = rest, compute_flat_angles(z, corner[:, ears])
        return alpha


def _remove_ears(topology: Topology) -> tuple[IntArray, tuple[IntArray, ...]]:
    """Return the faces that remain after ears are removed repeatedly, and the ears of each round."""
    on_rim = np.zeros(topology.n, dtype=bool)
    on_rim[topology.loops[0]] = True
    left, layers = np.ones(topology.corner.shape[1], dtype=bool), list[IntArray]()
    count = np.bincount(topology.corner.ravel(), minlength=topology.n)
    among = np.flatnonzero(on_rim[topology.corner].all(axis=0))
    while len(among) < len(left):
        corner = topology.corner[:, among]
        apex = count[corner] == 1
        is_ear = apex.any(axis=0)
        if not is_ear.any():
            break
        k, own = np.argmax(apex[:, is_ear], axis=0), corner[:, is_ear]
        layers.append(np.stack([own[(k + i) % 3, np.arange(len(k))] for i in (2, 0, 1)], axis=1))
        count -= np.bincount(own.ravel(), minlength=topology.n)
        left[among[is_ear]] = False
        among = among[~is_ear]
    return np.flatnonzero(left), tuple(layers)


def _fit_circle(z: ComplexArray) -> tuple[complex, float]:
    """Return the centre and the radius of the circle that fits the points z best."""
    A = np.column_stack((z.real, z.imag, np.ones(len(z))))
    x, y, c = np.linalg.lstsq(A, np.abs(z) ** 2, rcond=None)[0]
    centre = complex(x, y) / 2
    return centre, float(np.sqrt(c + abs(centre) ** 2))
