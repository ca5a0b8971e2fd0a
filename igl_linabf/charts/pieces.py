"""A piece of a surface, flattened alone."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from .._runtime import advance
from .._types import FloatArray
from ..errors import MeshError, SingularSystemError, some
from ..flattening import Flattening, Method, Outcome, Sketch, flatten_together
from ..measures import change_of
from ..surface import Submesh, centred, complex_positions, coordinates, planar_mesh


def flattened(piece: Submesh, method: Method) -> Flattening:
    """Flatten a piece; faces and vertices of the result are numbered within the piece."""
    start, topology = perf_counter(), piece.topology
    if topology.genus or not topology.loops:
        what = f"has {topology.genus} handle{'s' * (topology.genus > 1)}" if topology.loops else "is closed"
        which = f"the chart of faces {some(piece.faces)} {what}"
        raise MeshError(f"{which}: give more seams, or complete=True, and unwrap finds the others")
    n = len(piece.V)
    mesh = replace(planar_mesh(piece), vertices=np.arange(n), n_given=n)
    checked = perf_counter() - start
    advance("check", 0.05)
    made = method.run(mesh, None)
    return replace(made, seconds={"check": checked, **made.seconds, "total": perf_counter() - start})


def on_part(uv: FloatArray, piece: Submesh, part: Submesh) -> FloatArray:
    """The coordinates of a piece's map at the vertices of a part of it."""
    of = np.empty(len(part.V), dtype=np.int64)
    of[part.F.ravel()] = piece.F[np.searchsorted(piece.faces, part.faces)].ravel()
    return np.asarray(uv[of])


def of_own_size(uv: FloatArray, piece: Submesh) -> FloatArray:
    """The map of a piece, as large as the surface and turned and placed as every map is."""
    z = centred(piece.topology, complex_positions(uv), float(piece.measured[0].sum()) / 2)
    return coordinates(z)


def cut_out(result: Flattening, piece: Submesh, part: Submesh, uv: FloatArray) -> Flattening:
    """The map of a part of a flattened piece, which is the piece's map at some scale.

    Only a part that has flipped triangles is flipped.
    """
    rows = np.searchsorted(piece.faces, part.faces)
    place = np.full(len(piece.F), -1)
    place[rows] = np.arange(len(rows))
    flipped, repaired = (np.sort(kept[kept >= 0]) for kept in (place[result.flipped], place[result.repaired]))
    made = replace(
        result,
        uv=uv,
        F=part.F,
        angles=result.angles[rows],
        flipped=flipped,
        repaired=repaired,
        holes=result.holes if len(part.topology.loops) > 1 else (),
    )
    if made.outcome is not Outcome.FLIPPED or len(flipped):
        return made
    return replace(made, outcome=Outcome.VALID, message="no triangle of this part of the map is flipped")


def distortion(pieces: list[Submesh]) -> float:
    """L2 stretch and mean conformal distortion of pieces that are flattened: 1 if they come out isometric.

    Infinite if a triangle flips.
    """
    total, stretch, shear = 0.0, 0.0, 0.0
    for piece, known in zip(pieces, flatten_together([(p.V, p.F) for p in pieces], Sketch()), strict=True):
        try:
            result = flattened(piece, Sketch()) if known is None else known
        except SingularSystemError:
            return np.inf
        if len(result.flipped):
            return np.inf
        changed = change_of(piece, result.uv)
        total += float(changed.double_area.sum())
        stretch += float(changed.double_area @ changed.squared_stretch)
        shear += float(changed.double_area @ changed.conformal)
    return float(np.sqrt(stretch / total)) + shear / total - 1
