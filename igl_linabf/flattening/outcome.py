"""How a flattening ended, and the sentence that says it."""

from __future__ import annotations

import numpy as np

from ..angles import AngleSolver
from ..errors import some
from ..layouts import Layout
from ..surface import ALL_DIGITS, SPAN, IntArray, Mesh, span
from .result import Outcome


def judge(
    angles: AngleSolver, mesh: Mesh, made: Layout, flipped: IntArray, reached: bool, tried: str
) -> tuple[Outcome, str]:
    """The outcome, and the sentence that says it.

    `reached` says whether the method's tolerance was, `tried` what came of trying where it was not.
    """
    fit = f"the angles fit to {angles.residual.largest:.1e}"
    if angles.invalid.any():
        bad = np.flatnonzero(angles.invalid)
        return Outcome.ANGLES_INVALID, (
            f"the target angles of faces {some(bad)} left (0, pi), {len(flipped)} triangles of the map are "
            "flipped: use linear ABF with its safeguard, or converged ABF"
        )
    ratio = span(mesh, made.z)
    wide = f"area scale varies by a factor of {ratio:.0e}{' or more' if ratio > ALL_DIGITS else ''}"
    if not len(flipped):
        note = f"; its {wide}, near the end of double precision: cut the mesh, as unwrap does"
        note = note if ratio > SPAN else ""
        if made.method == "SLIM":
            return Outcome.VALID, f"no triangle is flipped, by {made.solver}{note}"
        if reached:
            return Outcome.CONVERGED, f"no triangle is flipped, and {fit}{note}"
        if not tried:
            return Outcome.VALID, f"no triangle is flipped; {fit}{note}"
        return Outcome.NOT_CONVERGED, (
            f"no triangle is flipped, but {tried}, {fit}: look for degenerate faces, or cut the mesh{note}"
        )
    where = f"faces {some(flipped)} are flipped or collapsed"
    helps = (
        "cut the mesh open towards them (igl_linabf.unwrap does, by itself), or ask for "
        "guarantee='injective', a map of more distortion without flips"
    )
    if not reached:
        return Outcome.FLIPPED, f"{where}: {fit} only, and {tried or 'more iterations may help'}; {helps}"
    if ratio > SPAN:
        return Outcome.FLIPPED, (
            f"{where}: {fit}, but the map's {wide}, which double precision does not hold; {helps}"
        )
    return Outcome.FLIPPED, f"{where}, though {fit}: {helps}"
