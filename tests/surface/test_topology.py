"""Tests of the connectivity of surfaces: outer loops, disks and handles."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf import MeshError, flatten
from igl_linabf.surface import build_manifold_topology, build_topology


def torus(n: int = 8) -> tuple[np.ndarray, np.ndarray]:
    i, j = np.indices((n, n)).reshape(2, -1)
    u, v = 2 * np.pi * i / n, 2 * np.pi * j / n
    V = np.column_stack(((3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)))
    a, b, c, d = i * n + j, (i + 1) % n * n + j, (i + 1) % n * n + (j + 1) % n, i * n + (j + 1) % n
    return V, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


def test_a_disk_and_a_torus_are_not_a_disk_although_their_characteristics_add_up_to_one() -> None:
    (V, F), (W, G) = load("bumps"), torus()
    both = np.concatenate((F, G + len(V)))
    topology = build_manifold_topology(both, np.arange(len(V) + len(W)))
    assert (topology.characteristic, len(topology.loops)) == (1, 1)
    assert not topology.is_planar
    with pytest.raises(MeshError, match="components"):
        flatten(np.concatenate((V, W)), both)


@pytest.mark.parametrize("holes", [0, 1, 2])
def test_handles_are_counted_beside_boundary_loops(holes: int) -> None:
    V, F = torus(12)
    apart = [0, len(F) // 2 + 60][:holes]
    topology = build_manifold_topology(np.delete(F, apart, axis=0), np.arange(len(V)))
    assert (topology.genus, len(topology.loops)) == (1, holes)


def test_fans_that_meet_in_a_boundary_vertex_are_rejected_and_named() -> None:
    bowtie = np.array([[0, 1, 2], [0, 3, 4], [5, 6, 7]])
    with pytest.raises(MeshError, match=r"at vertices 10 several fans of faces meet .*2 fans at the first"):
        build_topology(bowtie, np.arange(10, 18))
    assert [len(loop) for loop in build_topology(np.arange(6).reshape(2, 3), np.arange(6)).loops] == [3, 3]


def test_the_outer_loop_has_the_most_edges() -> None:
    V, F = igl.triangulated_grid(12, 9)
    inside = (np.abs(V[F].mean(axis=1) - [0.5, 0.4]) < 0.12).all(axis=1)
    V, F = igl.remove_unreferenced(V, F[~inside])[:2]
    topology = build_manifold_topology(F, np.arange(len(V)))
    outer, hole = topology.loops
    assert len(outer) == 38 > len(hole)
    assert np.ptp(V[outer], axis=0) == pytest.approx([1, 1])
    assert set(np.flatnonzero(~topology.is_interior)) == set(igl.boundary_facets(F)[0].ravel().tolist())
