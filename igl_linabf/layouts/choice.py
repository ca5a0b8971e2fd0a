"""From angles to coordinates: the choice of the layout, and the placement of its map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from .._types import ComplexArray, FloatArray, IntArray
from ..angles import Constraints, Iterate, Residual, constraints_of
from ..errors import MeshError, SingularSystemError, some
from ..linalg import Analysis, NotPositiveDefiniteError, SolverName, Solvers
from ..surface import (
    Pins,
    Topology,
    centred,
    compact,
    complex_positions,
    coordinates,
    face_array,
    flipped_faces,
    loop_through,
    move_to_pins,
    pins,
    planar_topology,
    scatter,
    shape_is_pinned,
    vertex_array,
    with_outer_loop,
)
from .boundary import Boundary, by_relaxed_loops, develop_boundary, harmonic
from .conformal_energy import far_apart, least_squares
from .greedy import greedy, one_by_one

LayoutName = Literal["auto", "boundary", "least-squares", "greedy"]

GAP = 2.5e-3  # relative gap of the developed boundary up to which "auto" trusts it
FLAT = 1e-4  # residual of the constraints up to which it draws the loops of holes, too
NEARLY_CLOSED = 0.1  # relative gap of loops up to which it changes those to the ones of the least squares
MOST_HOLES = 12  # where it does: each takes one more solve


def placed(topology: Topology, z: ComplexArray, area: float, pinned: Pins | None) -> ComplexArray:
    """The map moved to its pins; without pins, scaled to `area`, centred and turned to its axes."""
    return centred(topology, z, area) if pinned is None else move_to_pins(z, pinned)


@dataclass(frozen=True, eq=False)
class Layout:
    """A map, how it was made, and by how much its boundary failed to close."""

    z: ComplexArray
    method: str
    gap: float
    solver: str


def lay_out(
    constraints: Constraints,
    at: Iterate,
    method: LayoutName,
    pinned: Pins | None,
    area: float,
    solvers: Solvers,
    laplacian: Analysis | None = None,
    along: IntArray | None = None,
    boundary: Boundary | None = None,
    in_turn: bool = False,
) -> Layout:
    """Lay out triangles' angles.

    `laplacian` is the analysis of the constraints' pattern, if it is known already. Where angle sums of
    the outer loop are prescribed, it is drawn with them, and stays as it is drawn. Without pins, the
    second vertex of `along` is put to the right of the first. `boundary` is that loop, if known. If
    `in_turn`, angles that are flat to nearly all digits are laid out without a system.
    """
    check_pins(method, pinned)
    topology, alpha, cot = constraints.topology, at.alpha, at.cot
    boundary = boundary or develop_boundary(constraints, at.residual)
    rim = topology.loops[0]
    prescribed = not np.isnan(constraints.sums[rim]).all()
    solver, made = "none", method
    holes, relaxes, found = len(topology.holes), False, None
    if method == "auto":
        held = shape_is_pinned(pinned)
        drawn = boundary.gap <= GAP or prescribed
        if holes:
            may_draw = _may_draw_holes(constraints)
            drawn = drawn and may_draw and at.residual.largest <= FLAT
            relaxes = may_draw and not prescribed and not held and _nearly_closed(boundary, at.residual)
        made = "boundary" if drawn and not held else "least-squares"
    elif method == "boundary" and holes:
        raise MeshError(
            f"the mesh has {len(topology.loops)} boundary loops, and layout='boundary' draws one: use "
            "layout='least-squares' or 'auto'"
        )
    try:
        if made == "boundary":
            exact = one_by_one(boundary, at, topology) if in_turn else None
            if exact is not None:
                z, solver = exact, "triangles one by one"
            else:
                z, solver = harmonic(boundary, at, constraints, laplacian, solvers)
            if holes and len(flipped_faces(z, topology.corner)):
                made, relaxes = "least-squares", False
        if made == "least-squares" and relaxes:
            found = by_relaxed_loops(boundary, at, constraints, laplacian, solvers)
        if found is not None:
            z, solver = found
        elif made == "least-squares":
            ends = slice(None) if prescribed else far_apart(coordinates(boundary.z))
            index, position = rim[ends], boundary.z[ends]
            if pinned is not None and not prescribed:
                index, position = pinned[0], complex_positions(pinned[1])
            z, solver = least_squares(topology, cot, index, position, solvers)
        elif made == "greedy":
            z = greedy(topology, alpha)
    except NotPositiveDefiniteError:
        thin = np.argsort(alpha.min(axis=0), kind="stable")[:5]
        raise SingularSystemError(
            f"the {made} layout is singular in double precision; the thinnest target triangles are faces "
            f"{some(thin)} (smallest angle {alpha[:, thin[0]].min():.1e} rad): remove degenerate faces, "
            "cut the mesh, or use layout='greedy'"
        ) from None
    if pinned is None or found is not None or made != "least-squares" or prescribed:
        z = placed(topology, z, area, pinned)
    if pinned is None and along is not None and len(along):
        side = z[along[1]] - z[along[0]]
        z = z * (abs(side) / side)
    return Layout(z, made, boundary.gap, solver)


def _may_draw_holes(constraints: Constraints) -> bool:
    """Whether the loops of holes may be drawn: each has a row, and there are few."""
    rows = constraints.wheels == constraints.n and not constraints.paths
    return rows and len(constraints.topology.holes) <= MOST_HOLES


def _nearly_closed(boundary: Boundary, b: Residual) -> bool:
    """Whether the drawn loops are nearly those of the least squares."""
    return max(boundary.gap, float(np.abs(b.holonomy.gap).max())) <= NEARLY_CLOSED


def layout(
    F: ArrayLike,
    angles: ArrayLike,
    b: ArrayLike | None = None,
    bc: ArrayLike | None = None,
    *,
    method: LayoutName = "auto",
    outer: int | None = None,
    solver: SolverName = "auto",
) -> FloatArray:
    """Flat map of triangles with given angles.

    Parameters
    ----------
    F : (#F, 3) int
        Triangles of one disk, with or without holes.
    angles : (#F, 3) float
        Target angles in radians, `angles[t, k]` at vertex `F[t, k]` as `igl.internal_angles`
        returns them; in (0, pi), each row summing to pi.
    b, bc : (#b,) int and (#b, 2) float, optional
        Two or more pinned vertices and their positions, as in `igl.lscm`.
    method : {"auto", "boundary", "least-squares", "greedy"}
        "boundary" draws the boundary loop from the angles at it; inside, both coordinates are
        harmonic. "least-squares" minimises the conformal energy from the triangles with these
        angles (section 5 of the paper). "greedy" places triangle after triangle (section 5).
        "auto" is "boundary" if there are no more than two pins, and the drawn loop closes to 2.5e-3 of its
        length; with holes, of which there may be twelve, if the angles are flat to 1e-4, and then holes'
        loops are drawn, too. Otherwise it is "least-squares".
    outer : int, optional
        A vertex of the outer boundary loop; by default the loop with the most edges is the outer
        one. The default pins of "least-squares" are on it.
    solver : {"auto", "cholmod", "direct"}
        See `linabf`.

    Returns
    -------
    uv : (#V, 2) float64
        With pins, the pinned vertices are at `bc`: any number as constraints for "least-squares", two by
        a similarity for the others. Without pins, the map has area 1, its centroid at the origin and
        its principal axes along x and y. NaN at vertices that no face uses.

    Raises
    ------
    MeshError
        `F` is not one oriented manifold disk, with or without holes; the angles are not those of
        triangles; the pins are not two or more different vertices; or there are more than two, and the
        layout is "boundary" or "greedy".

    Examples
    --------
    >>> import numpy as np
    >>> F = np.array([[0, 1, 2]])
    >>> layout(F, np.deg2rad([[90, 45, 45]]), b=[1, 2], bc=[[1, 0], [0, 1]]).round(12) + 0.0
    array([[0., 0.],
           [1., 0.],
           [0., 1.]])
    """
    check_method(method)
    faces = face_array(F)
    n = int(faces.max()) + 1
    vertices, compacted = compact(faces, n)
    topology = planar_topology(compacted, vertices)
    if outer is not None:
        topology = with_outer_loop(topology, loop_through(topology, outer, vertices))
    alpha = checked_angles(angles, len(faces))
    pinned = pins(b, bc, vertices, n)
    constraints = constraints_of(topology)
    made = lay_out(constraints, Iterate.of(constraints, alpha), method, pinned, 1.0, Solvers(solver))
    return scatter(coordinates(made.z), vertices, n)


def check_method(method: str) -> None:
    """Raise if `method` is not the name of a layout."""
    if method not in get_args(LayoutName):
        names = ", ".join(map(repr, get_args(LayoutName)))
        raise ValueError(f"the layout is {method!r}: use one of {names}")


def check_pins(method: LayoutName, pinned: Pins | None) -> None:
    """Raise if the layout cannot hold so many pins."""
    if shape_is_pinned(pinned) and method in ("boundary", "greedy"):
        raise MeshError(
            f"layout={method!r} is only moved to its pins, and there are {len(pinned[0])}: pin two vertices, "
            "or use layout='least-squares' or 'auto'"
        )


def checked_angles(angles: ArrayLike, m: int) -> FloatArray:
    """Check that angles are those of triangles; return them as (3, #F)."""
    array = vertex_array(angles, 3, "angles")
    if len(array) != m:
        raise MeshError(f"angles has {len(array)} rows for {m} faces: pass one row a face")
    bad = np.flatnonzero(
        ~((array > 0) & (array < np.pi)).all(axis=1) | ~(np.abs(array.sum(axis=1) - np.pi) < 1e-6)
    )
    if len(bad):
        raise MeshError(
            f"the angles of faces {some(bad)} are not those of a triangle (face {bad[0]}: "
            f"{array[bad[0]].tolist()} rad): they must be within (0, pi) and sum to pi"
        )
    return np.ascontiguousarray(array.T)
