"""Room: angles."""

from .closure import Border
from .constraints import CAP_ANGLE, Residual, closure_of, corner_angles, initial_estimate, opened, residual
from .converged import ABF, SMALLEST
from .reduced import System
from .steps import AngleSolver, Step

__all__ = [
    "ABF",
    "CAP_ANGLE",
    "SMALLEST",
    "AngleSolver",
    "Border",
    "Residual",
    "Step",
    "System",
    "closure_of",
    "corner_angles",
    "initial_estimate",
    "opened",
    "residual",
]
