"""Room: flattening."""

from .baselines import bare_lscm, far_pins
from .comparison import LABELS, Comparison, Entry, compare, medians
from .result import Flattening, Hole, Outcome, Residuals, Rung
from .verbs import METHODS, abf, flatten, linabf, linabf_angles, lscm

__all__ = [
    "LABELS",
    "METHODS",
    "Comparison",
    "Entry",
    "Flattening",
    "Hole",
    "Outcome",
    "Residuals",
    "Rung",
    "abf",
    "bare_lscm",
    "compare",
    "far_pins",
    "flatten",
    "linabf",
    "linabf_angles",
    "lscm",
    "medians",
]
