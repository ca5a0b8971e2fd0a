"""The isometric energy of the core agrees with its definition."""

import numpy as np
import pytest
from carried import MESHES
from reference import isometry as reference

from igl_linabf import _core as core
from igl_linabf.layouts.isometry.energy import RestTriangles
from igl_linabf.surface import Ragged, planar_mesh


class Given:
    """A mesh with holes, and a random map of its triangles."""

    def __init__(self):
        mesh = planar_mesh(*MESHES["crown"]())
        self.corner, self.n, rng = mesh.topology.corner, mesh.topology.n, np.random.default_rng(1)
        rest = RestTriangles.from_charts(
            self.corner, mesh.double_area, mesh.dot, Ragged.from_sizes([self.corner.shape[1]])
        )
        self.gradient, self.share = rest.gradient, rest.share
        self.z, self.direction = rng.normal(size=(2, self.n, 2)) @ [1, 1j]

    def arguments(self, weight):
        return self.corner, self.gradient, self.share, self.z, weight


@pytest.fixture(scope="module")
def given():
    return Given()


def same(made, expected):
    largest = np.abs(expected).max(initial=0, where=np.isfinite(expected))
    np.testing.assert_allclose(made, expected, rtol=1e-11, atol=1e-11 * largest)


def select_unflipped(g, weight):
    """Restrict the arguments to triangles that are not flipped, whose energy is finite."""
    corner, gradient, share, z, _ = g.arguments(weight)
    p, q = reference.derivatives(corner, gradient, z)
    good = np.abs(p) > 1.2 * np.abs(q)
    assert 100 < np.count_nonzero(good) < len(good)
    return (
        np.ascontiguousarray(corner[:, good]),
        np.ascontiguousarray(gradient[:, good]),
        share[good],
        z,
        weight,
    )


@pytest.mark.parametrize("weight", [0.0, 1.0, 1.5, 4.0])
def test_the_energy_agrees_with_singular_values(weight, given):
    made = core.isometric_energy(*given.arguments(weight))
    expected = reference.isometric_energy(*given.arguments(weight))
    assert np.array_equal(np.isinf(made), np.isinf(expected)) and np.isinf(made).any()
    args = select_unflipped(given, weight)
    same(core.isometric_energy(*args), reference.isometric_energy(*args))


@pytest.mark.parametrize("weight", [0.0, 1.0, 1.5, 4.0])
def test_gradients_and_convex_parts_agree_with_the_hessian_by_p_and_q(weight, given):
    args = select_unflipped(given, weight)
    slope, rows = core.isometric_derivatives(*args)
    rows = rows.reshape(4, 6, -1)
    expected, convex = reference.slope_and_hessian(*args)
    same(slope, expected)
    same(np.einsum("rit,rjt->ijt", rows, rows), convex)


@pytest.mark.parametrize(
    "weight", [0.0, 1.0, 1.5]
)  # at weight 1, p and q of an isometry have the same stiffness
def test_a_similarity_has_no_direction_of_q(weight):
    flat = np.array([[0], [1], [2]])
    gradient = np.array([[-1 + 1j], [1], [-1j]]) / 2
    for scale in (1.0, 3.0):  # a similarity has q = 0
        args = (flat, gradient, np.ones(1), scale * np.array([0, 1, 1j]), weight)
        slope, rows = core.isometric_derivatives(*args)
        expected, convex = reference.slope_and_hessian(*args)
        same(slope, expected)
        same(np.einsum("rit,rjt->ijt", rows.reshape(4, 6, 1), rows.reshape(4, 6, 1)), convex)


def test_the_gradient_is_the_derivative_of_the_energy(given):
    args = select_unflipped(given, 1.5)
    slope, _ = core.isometric_derivatives(*args)
    step = 1e-6 * given.direction
    along = (slope * np.concatenate((step.real[args[0]], step.imag[args[0]]))).sum(axis=0)
    after, before = (core.isometric_energy(*args[:3], given.z + h, 1.5) for h in (step, -step))
    np.testing.assert_allclose((after - before) / 2, along, rtol=1e-4, atol=1e-6 * np.abs(along).max())


def test_outer_products_are_added_at_corners_and_sides(given):
    rng, m = np.random.default_rng(2), given.corner.shape[1]
    rows = rng.normal(size=(18, m))
    own, across = rng.integers(0, 50, (2, 3, m))
    across[rng.random(across.shape) < 0.5] ^= -1
    same(core.sum_outer_products(rows, own, across, 50), reference.sum_outer_products(rows, own, across, 50))


def test_a_position_beyond_the_pattern_is_rejected(given):
    rows, place = np.ones((6, 2)), np.zeros((3, 2), dtype=np.int64)
    for own, across in ((place + 4, place), (place, place + 4), (place, ~(place + 4)), (place - 1, place)):
        with pytest.raises(ValueError, match="place"):
            core.sum_outer_products(rows, own, across, 4)
    with pytest.raises(ValueError, match="argument 1"):
        core.sum_outer_products(np.ones((7, 2)), place, place, 4)


def test_collapse_lengths_are_roots_of_a_quadratic_equation(given):
    args = given.corner, given.gradient, given.z, given.direction
    made, expected = core.collapse_lengths(*args), reference.collapse_lengths(*args)
    assert np.array_equal(np.isinf(made), np.isinf(expected)) and np.isinf(made).any()
    same(made, expected)
