"""Flatten a disk, with or without holes.

Takes V, F, a method and pins. Returns uv, or a `Flattening` with angles, residuals, attempts and outcome.
Linear ABF follows Zayer, Levy, Seidel 2007. ABF, LSCM, SCP, DNCP and one step of ABF++ are available for
comparison.
"""

from .baselines import find_far_pins, make_lscm_call
from .boundary_shapes import BoundaryName
from .comparison import Comparison, Entry, compare, measure_median_times
from .flattener import Flattener
from .functions import Fit, abf, flatten, isometric, linabf, linabf_angles, lscm
from .many_meshes import flatten_batch, flatten_many
from .methods import (
    ABF,
    DNCP,
    LSCM,
    METHODS,
    SCP,
    Isometric,
    LinABF,
    Method,
    MethodOptions,
    OneStepABFpp,
    get_guaranteed_method,
    resolve_method,
)
from .result import Attempt, Flattening, FlatteningReport, Hole, Outcome, Residuals, Status, report_overlaps
from .with_cones import DivergedError, KnownLaplacian, PrescribedHolonomy, flatten_with_cones
