"""Anderson's acceleration: of linear iterations with k slow modes, k + 1 steps tell the end."""

from __future__ import annotations

import numpy as np
import pytest

from igl_linabf.angles.steps.acceleration import PastStep, accelerate, anderson_coefficients
from igl_linabf.angles.steps.linearisation import Direction


def steps(modes: int, number: int) -> tuple[list[PastStep], np.ndarray, np.ndarray]:
    """The steps e = B (end - alpha), the latest first; the end, and what x is there."""
    rng, shape = np.random.default_rng(modes), (3, 8)
    axes = np.linalg.qr(rng.normal(size=(24, 24)))[0]
    falls = np.ones(24)
    falls[:modes] = np.linspace(0.45, 0.85, modes)  # of the others, one step takes all
    B, X = axes * falls @ axes.T, rng.normal(size=(5, 24))
    end, x_end = rng.normal(size=24), rng.normal(size=5)
    alpha, past = end + axes[:, :modes] @ rng.normal(size=modes), []
    for _ in range(number):
        e = B @ (end - alpha)
        x = x_end + X @ (end - alpha - e)
        direction = Direction(e.reshape(shape), x, None, np.zeros(1, int), np.ones(1, bool))  # type: ignore[arg-type]
        past.insert(0, PastStep(alpha.reshape(shape), direction, e.copy()))
        alpha = alpha + e
    return past, end, x_end


@pytest.mark.parametrize("modes", [1, 2, 3])
def test_accelerated_steps_lead_to_the_end_of_linear_iterations(modes: int) -> None:
    (now, *earlier), end, x_end = steps(modes, modes + 1)
    made = accelerate(now, earlier)
    np.testing.assert_allclose((now.alpha + made.e).ravel(), end, atol=1e-9)
    np.testing.assert_allclose(made.x, x_end, atol=1e-9)
    plain = np.abs((now.alpha + now.direction.e).ravel() - end).max()
    assert plain > 0.01
    assert accelerate(now, ()) is now.direction


def test_what_is_missing_is_the_least_that_coefficients_of_sum_one_leave() -> None:
    rng = np.random.default_rng(0)
    earlier, now = list(rng.normal(size=(3, 40))), rng.normal(size=40)
    c = np.array(anderson_coefficients(earlier, now))

    def left(c: np.ndarray) -> float:
        return float(np.linalg.norm((1 - c.sum()) * now + c @ earlier))

    assert all(left(c) <= left(c + 1e-3 * rng.normal(size=3)) for _ in range(50))
    nearly = [now + 1e-9 * rng.normal(size=40) for _ in range(2)]
    assert anderson_coefficients(nearly, now) == []  # they would be large: what is missing is not linear
