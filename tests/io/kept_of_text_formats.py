"""What OBJ, PLY, OFF and STL files have, and what becomes of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from kept import Cell, carried

TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


def _polygons_of_obj(folder: Path) -> None:
    before, after = carried(folder, "a.obj", TETRA + "v 1 1 0\nf 1 3 5 2\nf 1 2 4\n")
    assert after.polygons.sizes.tolist() == [4, 3]
    assert (after.V[after.polygons.corners] == before.V[before.polygons.corners]).all()
    assert np.array_equal(after.TC[after.texture], before.TC[before.texture])


CELLS = [Cell("OBJ", "OBJ", "polygons, in their order", "kept", _polygons_of_obj)]
