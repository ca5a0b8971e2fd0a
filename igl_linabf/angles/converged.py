"""Converged ABF: the least relative change of the angles that makes the mesh flat."""

from __future__ import annotations

import numpy as np

from ..errors import MeshError
from ..surface import NEXT, PREV, BoolArray, FloatArray
from .steps import AngleSolver

INNER = 0.03  # relative reduction of what an anchored step's multipliers miss
EXACT = 0.01  # and of a feasible or restoring step's
PLAIN = 30  # anchored steps at most
STALLED = 5  # of them without progress before the feasible form takes over
FEASIBLE = 60  # steps of the feasible form at most
SMALLEST = 0.01  # share of its initial value below which the feasible form lets no angle fall
RESTORE = 4  # restoring steps at most after each
HELD = 1e-12  # weight of an angle that is held at its bound, relative to a free one's
LEAST_SCALE = 1e-7  # of a feasible step
RESIDUAL, ACTIVE_SET = 1e-9, 20  # residual of the start of the feasible form, steps to it at most
CURVATURE = 0.2  # share of the objective's curvature below which none is believed


class ABF:
    """Minimise sum ((alpha - alpha_0) / alpha_0)^2 over the angles of flat meshes.

    That is the objective of Sheffer and de Sturler, under the constraints of eq. 5, 6 and of eq. 10
    before its linearisation. An *anchored* step is linear ABF's with weights alpha_0^2 and the
    change since alpha_0 as its gradient: a Gauss-Newton step of the constraints, whose fixed point
    is the minimiser. The factor of the Laplacian at alpha_0 serves all of them, and conjugate
    gradients go on from the last multipliers.

    Where that does not converge, the *feasible* form takes over from a converged active set. Its
    weights have the curvature of the wheel constraints in them, which is diagonal,
    |1 / alpha_0^2 + (x_right - x_left) / sin^2(alpha)| by the multipliers of the two wheels that an
    angle is in; each step is followed by steps that restore
    the constraints, and halved until the objective falls. Angles are bounded below by a hundredth
    of alpha_0: on hard meshes the least objective is otherwise where some vanish.

    Parameters
    ----------
    angles : AngleSolver
        At the initial estimate alpha_0.
    tol : float
        Largest relative change of an angle, and largest residual, at which to end.

    Attributes
    ----------
    converged : bool
    feasible : bool
        Whether the feasible form was needed.
    bound : (3, #F) bool
        The angles at their lower bound.
    """

    def __init__(self, angles: AngleSolver, tol: float) -> None:
        self._angles, self._tol = angles, tol
        self._anchor = angles.alpha
        self._weights = self._anchor**2
        self.converged = self.feasible = False
        self.bound: BoolArray = np.zeros(self._anchor.shape, dtype=bool)

    def run(self, *, feasibly: bool = True) -> None:
        """Iterate until converged, or until it is clear that it does not; then on in the feasible form."""
        try:
            self._run_anchored()
        except MeshError:  # it left what double precision solves; the feasible form keeps away from there
            self.converged = False
        self.feasible = feasibly and not self.converged
        if self.feasible:
            self._run_feasible()

    @property
    def objective(self) -> float:
        """sum ((alpha - alpha_0) / alpha_0)^2 at the present angles."""
        return float((((self._angles.alpha - self._anchor) / self._anchor) ** 2).sum())

    def _gradient(self) -> FloatArray:
        return np.asarray((self._angles.alpha - self._anchor) / self._weights)

    def _ends(self, p: FloatArray) -> bool:
        """Whether errors `p` and the residual are within the tolerance."""
        change = np.abs(p / self._angles.alpha).max()
        self.converged = bool(change <= self._tol and self._angles.residual.largest <= self._tol)
        return self.converged

    def _run_anchored(self) -> None:
        angles, multipliers = self._angles, None
        best, stalled = np.inf, 0
        for k in range(PLAIN):
            angles.take_system(self._weights, keep_factor=k > 0, close=k > 0)
            p, inner, multipliers = angles.direction(INNER, self._gradient(), multipliers)
            angles.move("anchored", p, inner)
            if self._ends(p):
                return
            merit = max(float(np.abs(p / angles.alpha).max()), angles.residual.largest)
            best, stalled = (merit, 0) if merit < 0.7 * best else (best, stalled + 1)
            if stalled > STALLED or (k > 1 and angles.steps[-1].limited):
                return

    def _run_feasible(self) -> None:
        angles = self._angles
        angles.place(self._anchor)
        self._restore(RESIDUAL, ACTIVE_SET)
        multipliers = np.zeros(0)
        scale = 1.0
        for _ in range(FEASIBLE):
            p, inner, multipliers = self._feasible_direction(multipliers)
            if self._ends(np.where(self.bound, 0.0, p)):
                return
            scale = self._search(p, inner, min(1.0, 2 * scale))
            if scale < LEAST_SCALE:
                return

    def _feasible_direction(self, multipliers: FloatArray) -> tuple[FloatArray, int, FloatArray]:
        """Direction at feasible angles, those at their bound that want to fall being held."""
        angles, gradient, inner = self._angles, self._gradient(), 0
        curvature = 1 / self._weights
        if len(multipliers):
            wheel = angles.at_vertices(multipliers)[angles.topology.corner, 1]
            curvature += (wheel[PREV] - wheel[NEXT]) / np.sin(angles.alpha) ** 2
        weights = 1 / np.maximum(np.abs(curvature), CURVATURE / self._weights)
        low = angles.alpha <= (1 + 1e-6) * SMALLEST * self._anchor
        self.bound = self.bound & low
        for _ in range(RESTORE):
            held = np.where(self.bound, HELD * weights, weights)
            angles.take_system(held, keep_slivers=False)
            p, steps, multipliers = angles.direction(EXACT, gradient, multipliers)
            inner += steps
            falling = low & (p < 0)
            if (falling == self.bound).all():
                break
            self.bound = falling
        return p, inner, multipliers

    def _search(self, p: FloatArray, inner: int, scale: float) -> float:
        """Go along `p` and back to the constraints, by so much that the objective falls."""
        angles = self._angles
        start, before = angles.alpha, self.objective
        slope = 2 * float((self._gradient() * p).sum())
        # so exactly that what is missing does not hide the change of the objective
        exact = max(1e-11, 1e-3 * min(float(np.abs(p / start).max()), 1e-3) ** 2)
        while scale >= LEAST_SCALE:
            trial = np.maximum(start + scale * p, np.minimum(start, SMALLEST * self._anchor))
            angles.place(trial * (np.pi / trial.sum(axis=0)), "feasible", inner)
            self._restore(exact, RESTORE)
            after = self.objective
            if after <= before + 1e-4 * scale * slope or abs(after - before) <= 1e-13 * before:
                return scale
            inner, scale = 0, scale / 2
        angles.place(start)
        return scale

    def _restore(self, exact: float, most: int) -> None:
        """Active-set steps, which measure from the present angles, until the residual is `exact`."""
        angles = self._angles
        for _ in range(most):
            if angles.residual.largest <= exact:
                return
            weights = np.where(self.bound, HELD, 1.0) * angles.alpha**2
            angles.take_system(weights, keep_slivers=False)
            p, inner, _ = angles.direction(EXACT)
            angles.move("restoration", p, inner)
