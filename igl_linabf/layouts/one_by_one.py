"""The layout of angles that are flat to nearly all digits: no system is solved."""

import numpy as np

from .. import _core
from .._types import ComplexArray
from ..angles import Iterate
from ..surface import Topology
from .boundary import Boundary

EXACT = 1e-7  # residual of the constraints up to which triangles may be placed one after another
MISFIT = 1e-4  # and how far a corner may then be off, over its triangle's shortest side


def one_by_one(boundary: Boundary, at: Iterate, topology: Topology) -> ComplexArray | None:
    """Triangles placed one after another from the drawn boundary inwards, over a breadth-first tree.

    Where the angles fulfil all constraints, no way to a triangle differs from another one. None where
    they do so too little, as where small triangles lie between large ones.
    """
    if not at.residual.largest <= EXACT or topology.holes:
        return None
    z, known = np.zeros(topology.n, dtype=np.complex128), ~topology.interior
    z[topology.loops[0]] = boundary.z
    one, other = topology.sides
    twin = np.full(at.cot.size, -1)
    inside = other >= 0
    twin[one[inside]], twin[other[inside]] = other[inside], one[inside]
    made, misfit = _core.developed(z, known, one[~inside], twin, topology.corner, at.cot)
    return made if misfit <= MISFIT else None
