"""Conjugate gradients solve each block of a system independently, and report its convergence."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from igl_linabf.linalg import conjugate_gradients

SIZES = (5, 40, 1, 0, 17)
Blocks = list[np.ndarray]


def make_systems(seed: int = 0) -> tuple[Blocks, Blocks, Blocks]:
    """Return positive definite matrices, Jacobi preconditioners, and right-hand sides."""
    rng = np.random.default_rng(seed)
    matrices = []
    for n in SIZES:
        root = rng.normal(size=(n, n))
        matrices.append(root @ root.T + np.diag(rng.uniform(1, 50, n)))
    return matrices, [np.diag(1 / np.diag(A)) for A in matrices], [rng.normal(size=n) for n in SIZES]


def solve_by_definition(A: np.ndarray, M: np.ndarray, b: np.ndarray, rtol: float) -> tuple[np.ndarray, int]:
    """Solve by the algorithm of Hestenes and Stiefel (1952) with preconditioner M; also count the steps."""
    x, r, steps = np.zeros_like(b), b.copy(), 0
    p, rho = np.zeros_like(b), 1.0
    while np.linalg.norm(r) > rtol * np.linalg.norm(b):
        z = M @ r
        before, rho = rho, r @ z
        p = z + (rho / before * p if steps else 0)
        x = x + rho / (p @ A @ p) * p
        r, steps = b - A @ x, steps + 1
    return x, steps


def solve(
    A: Blocks, M: Blocks, b: Blocks, rtol: float, **options: Any
) -> tuple[Blocks, list[int], list[bool]]:
    start = np.cumsum([0, *map(len, b)])

    def times(matrices: Blocks, x: np.ndarray) -> np.ndarray:
        return np.concatenate([B @ part for B, part in zip(matrices, np.split(x, start[1:-1]), strict=True)])

    x, steps, converged = conjugate_gradients(
        partial(times, A), np.concatenate(b), partial(times, M), rtol, start=start, **options
    )
    return np.split(x, start[1:-1]), steps.tolist(), converged.tolist()


@pytest.mark.parametrize("rtol", [0.3, 1e-3, 1e-8])
def test_each_block_has_the_iterates_and_steps_of_a_separate_system(rtol: float) -> None:
    A, M, b = make_systems()
    b[0] = np.zeros_like(b[0])  # the zero vector solves this block without a step
    found, steps, converged = solve(A, M, b, rtol)
    assert all(converged)
    for x, taken, *given in zip(found, steps, A, M, b, strict=True):
        expected, number = solve_by_definition(*given, rtol)
        assert taken == number
        np.testing.assert_allclose(x, expected, rtol=1e-6, atol=1e-9)
    assert len(set(steps)) > 2  # the blocks converge after different numbers of steps


def test_the_first_step_has_to_reach_first_rtol_and_later_steps_rtol() -> None:
    A, M, b = make_systems()
    M[1] = np.linalg.inv(A[1]) * 1.01  # an exact preconditioner, up to a factor: converges in one step
    _, plain, _ = solve(A, M, b, 0.5)
    _, asked, _ = solve(A, M, b, 0.5, first_rtol=1e-11)
    assert plain[1] == asked[1] == 1 and plain[4] == 1 < asked[4]
    for before, after, size in [(plain[k], asked[k], SIZES[k]) for k in (0, 2, 3, 4)]:
        assert after == min(max(before, 2), size)


def test_blocks_that_do_not_converge_are_reported_and_do_not_affect_other_blocks() -> None:
    A, M, b = make_systems()
    alone, steps, _ = solve(A, M, b, 1e-9)
    _, short, converged = solve(A, M, b, 1e-9, most=3)
    assert short == [min(3, taken) for taken in steps]
    assert converged == [taken <= 3 for taken in steps]
    A[1] = np.full_like(A[1], np.nan)  # NaN, as after an overflow
    found, steps, converged = solve(A, M, b, 1e-9)
    assert converged == [True, False, True, True, True] and steps[1] <= 1
    for k in (0, 2, 4):
        np.testing.assert_allclose(found[k], alone[k], rtol=1e-12, atol=1e-15)
