"""
Checkerboards on six surfaces
=============================

What a flat map does is seen on the surface: squares that stay squares say that angles are kept,
their size how areas change. A disk, disks with holes, and closed surfaces with the seams drawn that
open them; each is flattened by linear ABF.
"""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from cortex import cortex
from high_curvature import crown, rings, spiky
from holes import crown_without_tips
from stretch import bunny

from igl_linabf import Atlas, flatten, quality, unwrap
from igl_linabf.io import replacing
from igl_linabf.plot import plot_checkerboard


def double_torus() -> tuple[np.ndarray, np.ndarray]:
    """A closed surface with two handles, as a level set."""
    grid = pv.ImageData(dimensions=(97, 65, 33), spacing=(1 / 32,) * 3, origin=(-1.5, -1.0, -0.5))
    x, y, z = grid.points.T
    level = (x**2 * (1 - x**2 / 1.6) - y**2) ** 2 + 0.5 * z**2 - 0.025
    surface = grid.contour([0.0], level).clean()
    F = surface.regular_faces.astype(np.int64)
    V, F, *_ = igl.remove_unreferenced(surface.points.astype(float), F)
    return V, F


if __name__ == "__main__":
    surfaces = {
        "cortex": (*cortex(), 30),
        "spiky": (*rings(40, spiky), 30),
        "crown": (*rings(40, crown), 50),
        "seven holes": (*crown_without_tips(), 50),
        "Stanford bunny": (*bunny(), 50),
        "double torus": (*double_torus(), 50),
    }
