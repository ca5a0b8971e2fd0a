"""The layout of disks side by side: every boundary drawn, both coordinates harmonic inside."""

from dataclasses import dataclass

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray
from ..angles import Constraints, Iterate
from ..kernels import centred
from ..linalg import Solvers
from ..surface import Disks, area_ratio, complex_positions, signed_double_areas
from .boundary import develop_boundaries


@dataclass(frozen=True, eq=False)
class FlatDisks:
    """The maps of disks side by side.

    Attributes
    ----------
    z : (#V, ) complex128
        Each of the area of its disk, centred and turned.
    gap : (#disks,) float64
        By how much each boundary failed to close, relative to its length.
    flipped : (#disks,) bool
        Whether a triangle of it is flipped or collapsed.
    ratio : (#disks,) float64
        Of its largest area scale to its smallest one, as `span` has it.
    solver : str
    """

    z: ComplexArray
    gap: FloatArray
    flipped: BoolArray
    ratio: FloatArray
    solver: str


def flat_disks(disks: Disks, constraints: Constraints, at: Iterate, solvers: Solvers) -> FlatDisks:
    """Lay out the angles of disks side by side.

    Raises
    ------
    NotPositiveDefiniteError
        The layout of one of them is singular in double precision.
    """
    topology, pattern = disks.topology, constraints.pattern
    (drawn, gap), solver = develop_boundaries(disks, at.residual), "none"
    z = np.zeros(topology.n, dtype=np.complex128)
    z[disks.rim[0]] = drawn
    if pattern.n:
        weight = topology.sum_at_edges(at.cot) / 2
        lower = pattern.laplacian(weight)
        factored = pattern.analysis(solvers).factor(lower.data)
        z[topology.interior] = complex_positions(factored.solve(pattern.pull(weight, z)))
        solver = factored.name
    with np.errstate(divide="ignore", invalid="ignore"):  # of a disk whose angles are not to be drawn
        areas = signed_double_areas(z, topology.corner)
        scale = np.abs(areas)
        z = centred(z, topology.corner, scale, disks.area, disks.vertices.start, disks.faces.start)
        scale /= disks.double_area
        ratio = area_ratio(disks.faces.max(scale), disks.faces.min(scale))
    return FlatDisks(z, gap, disks.faces.any(~(areas > 0)), ratio, solver)
