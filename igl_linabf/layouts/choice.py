"""Choose the layout method, and place the map that it computes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from .._types import ComplexArray, FloatArray, IntArray
from ..angles import Constraints, Iterate, build_constraints
from ..errors import MeshError, SingularSystemError, first_few, format_count
from ..linalg import Analysis, NotPositiveDefiniteError, SolverName, Solvers
from ..surface import (
    Pins,
    Topology,
    build_planar_topology,
    complex_positions,
    count_vertices,
    drop_unused_vertices,
    face_array,
    find_loop_of_vertex,
    find_outer_loop_of_angles,
    move_to_pins,
    normalize_placement,
    real_coordinates,
    scatter_to_input,
    shape_is_pinned,
    validate_pins,
    vertex_array,
    with_outer_loop,
)
from .boundary import Boundary, compute_harmonic_map, develop_boundary
from .conformal_energy import find_far_points, least_squares
from .greedy import lay_out_greedily

LayoutName = Literal["auto", "boundary", "least-squares", "greedy"]

MAX_BOUNDARY_GAP = 2.5e-3  # "auto" lays out the boundary up to this closure error, relative to its length


def place_map(topology: Topology, z: ComplexArray, area: float, pinned: Pins | None) -> ComplexArray:
    """Move a map to its pins. Without pins, scale it to `area`, centre it, and align its principal axes."""
    return normalize_placement(topology, z, area) if pinned is None else move_to_pins(z, pinned)


@dataclass(frozen=True, eq=False)
class Layout:
    """A map with its layout method, the relative closure error of the boundary, and the solver."""

    z: ComplexArray
    method: str
    gap: float
    solver: str


@dataclass(frozen=True, eq=False)
class LayoutOptions:
    """The layout method and the placement of the map.

    Attributes
    ----------
    method : {"auto", "boundary", "least-squares", "greedy"}
    pinned : Pins or None
    area : float
        Area of the map without pins.
    side : (2,) or (0,) int64
        Two vertices of a map without pins. The map is turned so that the second vertex is to the right of the
        first.
    """

    method: LayoutName = "auto"
    pinned: Pins | None = None
    area: float = 1.0
    side: IntArray | None = None


def lay_out(
    constraints: Constraints,
    at: Iterate,
    options: LayoutOptions,
    solvers: Solvers,
    laplacian: Analysis | None = None,
    boundary: Boundary | None = None,
) -> Layout:
    """Compute a flat map from the angles of its triangles.

    Optional inputs save time: `laplacian` is the analysis of the pattern of the constraints, and `boundary`
    the outer loop that was laid out earlier. An outer loop with prescribed angle sums is laid out with these
    sums, and does not change.
    """
    method, pinned = options.method, options.pinned
    check_pins(method, pinned)
    topology, cot, holes = constraints.topology, at.cot, len(constraints.topology.holes)
    boundary = boundary or develop_boundary(constraints, at.residual)
    rim, gap = topology.loops[0], float(boundary.gaps.max())
    prescribed = not np.isnan(constraints.sums[rim]).all()
    solver = "none"
    if method == "auto":
        draws = (gap <= MAX_BOUNDARY_GAP or prescribed) and not holes and not shape_is_pinned(pinned)
        method = "boundary" if draws else "least-squares"
    elif method == "boundary" and holes:
        raise MeshError(
            f"the mesh has {len(topology.loops)} boundary loops, and layout='boundary' draws one: use "
            "layout='least-squares' or 'auto'"
        )
    try:
        if method == "boundary":
            z, solver = compute_harmonic_map(boundary, at, constraints, laplacian, solvers)
        elif method == "least-squares":
            ends = slice(None) if prescribed else find_far_points(real_coordinates(boundary.z))
            index, position = rim[ends], boundary.z[ends]
            if pinned is not None and not prescribed:
                index, position = pinned[0], complex_positions(pinned[1])
            z, solver = least_squares(topology, cot, index, position, solvers)
        else:
            z = lay_out_greedily(topology, at.alpha)
    except NotPositiveDefiniteError:
        raise SingularSystemError(_describe_thinnest(method, at.alpha)) from None
    if pinned is None or method != "least-squares" or prescribed:
        z = place_map(topology, z, options.area, pinned)
    if pinned is None and options.side is not None and len(options.side):
        side = z[options.side[1]] - z[options.side[0]]
        z = z * (abs(side) / side)
    return Layout(z, method, gap, solver)


def _describe_thinnest(method: str, alpha: FloatArray) -> str:
    """Return the error message for a singular layout, with the thinnest triangles."""
    thin = np.argsort(alpha.min(axis=0), kind="stable")[:5]
    return (
        f"the {method} layout is singular in double precision; the thinnest target triangles are faces "
        f"{first_few(thin)} (smallest angle {alpha[:, thin[0]].min():.1e} rad): remove degenerate faces, "
        "cut the mesh, or use layout='greedy'"
    )


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
    """Lay out triangles with given angles in the plane.

    Parameters
    ----------
    F : (#F, 3) int
        Triangles of one disk, with or without holes.
    angles : (#F, 3) float
        Target angles in radians, `angles[t, k]` at vertex `F[t, k]`, as returned by `igl.internal_angles`.
        All angles are in (0, pi), and each row sums to pi.
    b, bc : (#b,) int and (#b, 2) float, optional
        Two or more pinned vertices and their positions, as in `igl.lscm`.
    method : {"auto", "boundary", "least-squares", "greedy"}
        "boundary" draws the boundary loop from its angles; in the interior, both coordinates are harmonic.
        "least-squares" minimises the conformal energy from the triangles with these angles (section 5 of the
        paper). "greedy" places triangle after triangle (section 5). "auto" is "boundary" on a mesh without
        holes if there are at most two pins, and the closure error of the boundary loop is at most 2.5e-3 of
        its length. Otherwise, "auto" is "least-squares".
    outer : int, optional
        A vertex of the outer boundary loop; by default, the loop around all other loops. The
        default pins of "least-squares" are on this loop.
    solver : {"auto", "cholmod", "direct"}
        See `linabf`.

    Returns
    -------
    uv : (#V, 2) float64
        With pins, the pinned vertices are at `bc`. "least-squares" takes any number of pins as constraints;
        the other methods take two, and move the map to them by a similarity. Without pins, the map has area
        1, its centroid is at the origin, and its principal axes are along x and y. NaN at vertices that
        belong to no face.

    Raises
    ------
    MeshError
        `F` is not one oriented manifold disk, with or without holes; the angles are not angles of triangles;
        the pins are not two or more different vertices; or there are more than two pins, and the layout is
        "boundary" or "greedy".

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
    n = count_vertices(faces)
    vertices, compacted = drop_unused_vertices(faces, n)
    topology = build_planar_topology(compacted, vertices)
    alpha = check_angles(angles, len(faces))
    if outer is not None:
        first = find_loop_of_vertex(topology, outer, vertices)
    else:
        first = find_outer_loop_of_angles(topology, alpha)
    topology = with_outer_loop(topology, first)
    pinned = validate_pins(b, bc, vertices, n)
    constraints = build_constraints(topology)
    at, options = Iterate.from_angles(constraints, alpha), LayoutOptions(method, pinned)
    made = lay_out(constraints, at, options, Solvers(solver))
    return scatter_to_input(real_coordinates(made.z), vertices, n)


def check_method(method: str) -> None:
    """Raise an error if `method` is not the name of a layout."""
    if method not in get_args(LayoutName):
        names = ", ".join(map(repr, get_args(LayoutName)))
        raise ValueError(f"the layout is {method!r}: use one of {names}")


def check_pins(method: LayoutName, pinned: Pins | None) -> None:
    """Raise an error if the layout cannot meet all pins."""
    if shape_is_pinned(pinned) and method in ("boundary", "greedy"):
        raise ValueError(
            f"layout={method!r} is only moved to its pins, and there are {len(pinned[0])}: pin two vertices, "
            "or use layout='least-squares' or 'auto'"
        )


def check_angles(angles: ArrayLike, m: int) -> FloatArray:
    """Check that the angles are angles of triangles; return them as (3, #F)."""
    array = vertex_array(angles, 3, "angles")
    if len(array) != m:
        raise MeshError(
            f"angles has {format_count(len(array), 'row')} for {format_count(m, 'face')}: pass one row "
            "per face"
        )
    bad = np.flatnonzero(
        ~((array > 0) & (array < np.pi)).all(axis=1) | ~(np.abs(array.sum(axis=1) - np.pi) < 1e-6)
    )
    if len(bad):
        raise MeshError(
            f"the angles of faces {first_few(bad)} are not those of a triangle (face {bad[0]}: "
            f"{array[bad[0]].tolist()} rad): they must be within (0, pi) and sum to pi"
        )
    return np.ascontiguousarray(array.T)
