"""Pins that only a mirrored map can meet are refused; unreachable pins keep the size of the map."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from igl_linabf import MeshError, flatten, lscm


def dome() -> tuple[np.ndarray, np.ndarray]:
    V, F = igl.icosahedron()
    for _ in range(2):
        V, F = igl.upsample(V, F)
    V = V / np.linalg.norm(V, axis=1)[:, None]
    F = F[V[F].mean(axis=1)[:, 2] > -0.1]
    used, F = np.unique(F, return_inverse=True)
    return V[used], F.reshape(-1, 3)


METHODS = ("linabf", "abf", "isometric", "lscm", "dncp")


@pytest.mark.parametrize("width", [1, 6])
@pytest.mark.parametrize("method", METHODS)
def test_a_boundary_pinned_clockwise_is_refused_and_its_mirror_image_taken(method: str, width: float) -> None:
    V, F = dome()
    V = V * [width, 1, 1]
    b = np.asarray(igl.boundary_loop(F))
    bc = igl.map_vertices_to_circle(V, b)
    clockwise = bc * [1, -1]
    with pytest.raises(
        MeshError, match=r"are mirrored: they run clockwise .* mirror the positions, as bc \* "
    ):
        flatten(V, F, b, clockwise, method=method)
    # each of the two remedies that the message names helps
    for faces, at in ((F, clockwise * [1, -1]), (F[:, ::-1], clockwise)):
        made = flatten(V, faces, b, at, method=method)
        assert made.outcome.good
        assert np.allclose(made.uv[b], at, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_all_vertices_pinned_to_a_mirrored_map_are_refused(method: str) -> None:
    V, F = dome()
    with pytest.raises(MeshError, match="are mirrored"):
        flatten(V, F, np.arange(len(V)), flatten(V, F).uv * [1, -1], method=method)


def test_lscm_refuses_mirrored_pins_too() -> None:
    V, F = dome()
    b = np.asarray(igl.boundary_loop(F))
    with pytest.raises(MeshError, match="are mirrored"):
        lscm(V, F, b, igl.map_vertices_to_circle(V, b) * [-1, 1])


def test_unreachable_pins_give_a_map_of_their_size() -> None:
    V, F = dome()
    b = np.asarray(igl.boundary_loop(F))
    bc = np.random.default_rng(0).permutation(igl.map_vertices_to_circle(V, b))
    made = flatten(V, F, b, bc, method="isometric")
    assert len(made.flipped) == 0
    assert "pins are missed" in made.message
    assert 0.5 < np.ptp(made.uv, axis=0).min() < np.ptp(made.uv, axis=0).max() < 8
