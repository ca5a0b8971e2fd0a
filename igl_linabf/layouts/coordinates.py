"""From angles to coordinates: developed boundary with a harmonic inside, least squares, greedy."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import csgraph

from ..angles import Residual, residual
from ..errors import FallbackWarning, MeshError, some, stack_level
from ..linalg import Factor, NotConvergedError, NotPositiveDefiniteError, Pattern, SolverName, Solvers
from ..surface import (
    ComplexArray,
    FloatArray,
    IntArray,
    Pins,
    Topology,
    centred,
    compact,
    complex_positions,
    coordinates,
    face_array,
    loop_through,
    pins,
    placed_at,
    planar_topology,
    scatter,
    signed_double_areas,
    vertex_array,
    with_outer,
)

LayoutName = Literal["auto", "boundary", "least-squares", "greedy"]

GAP = 2.5e-3  # relative gap of the developed boundary up to which "auto" trusts it


@dataclass(frozen=True, eq=False)
class Boundary:
    """The outer loop as its angles draw it.

    Attributes
    ----------
    z : (#loop,) complex128
        Positions of the vertices of `topology.loops[0]`, closed.
    gap : float
        By how much the loop failed to close, relative to its length.
    """

    z: ComplexArray
    gap: float


def develop_boundary(topology: Topology, missing: Residual) -> Boundary:
    """Draw the outer loop from its exterior angles and the ratios of its successive edges.

    What is missing of 2 pi in the turning and of 0 in the logarithms is spread evenly over the
    loop; the gap that remains is closed by the smallest change of lengths, min sum delta^2 / l.
    """
    loop = topology.loops[0]
    turning, log_ratio = missing.turning[loop], missing.log_ratio[loop]
    turning = turning + (2 * np.pi - turning.sum()) / len(loop)
    log_length = np.cumsum(log_ratio - log_ratio.mean())
    length = np.exp(log_length - log_length.max())
    edge = np.exp(1j * np.cumsum(turning))  # edge i leaves loop vertex i
    gap = (length * edge).sum()
    # delta = l Re(conj(edge) mu) closes it: a 2 by 2 system for mu
    u = np.stack((edge.real, edge.imag))
    mu = np.linalg.solve((u * length) @ u.T, -np.array([gap.real, gap.imag]))
    ends = np.cumsum(length * (1 + mu @ u) * edge)
    return Boundary(np.concatenate(([0], ends[:-1])), float(abs(gap) / length.sum()))


def harmonic(
    topology: Topology,
    boundary: Boundary,
    cot: FloatArray,
    pattern: Pattern,
    laplacian: Factor | None,
    solvers: Solvers,
) -> tuple[ComplexArray, str]:
    """Both coordinates harmonic inside the drawn boundary, by the target angles' Laplacian.

    Returns the map and the solver's name.
    """
    z = np.zeros(topology.n, dtype=np.complex128)
    z[topology.loops[0]] = boundary.z
    if not pattern.n:
        return z, "none"
    weight = topology.sum_at_edges(cot) / 2
    lower = pattern.laplacian(weight)
    laplacian = laplacian or solvers.laplacian(lower)
    laplacian.factor(lower)
    rhs = pattern.pull(weight, z[topology.edges.T])  # the inside being zero yet
    inside = topology.row >= 0
    try:
        z[inside] = complex_positions(laplacian.solve(rhs))
    except NotConvergedError:
        good = False
    else:
        good = laplacian.exact or bool((signed_double_areas(z, topology.corner) > 0).all())
    if not good:
        # a map whose scale varies a lot needs more digits than multigrid gives
        warnings.warn(
            f"{laplacian.name} did not solve the layout to a map without flipped triangles: it is factored",
            FallbackWarning,
            stacklevel=stack_level(),
        )
        laplacian = solvers.whole(lower)
        laplacian.factor(lower)
        z[inside] = complex_positions(laplacian.solve(rhs))
    return z, laplacian.name


def least_squares(
    topology: Topology, cot: FloatArray, pinned: IntArray, position: ComplexArray, solvers: Solvers
) -> tuple[ComplexArray, str]:
    """Minimise the conformal energy from triangles with the target angles (the paper's section 5).

    E(z) = 1/4 sum cot(alpha) |z_i - z_j|^2 - area(z) = 1/2 z^H (L + i Q) z, L the cotangent
    Laplacian of the target angles and Q skew, on the boundary edges only; two pins are
    eliminated and one complex Hermitian system is factored. Returns the map and the solver's name.
    """
    row = np.zeros(topology.n, dtype=np.int64)
    row[pinned] = -1
    free = row == 0
    row[free] = np.arange(np.count_nonzero(free))
    pattern = Pattern(topology, row, len(row) - len(pinned))
    a, b = topology.edges.T
    i, j = pattern.ends
    weight = topology.sum_at_edges(cot) / 2
    entry = -weight + 0.5j * (topology.sides[1] < 0)  # from a to b, the mesh on the left
    z = np.zeros(topology.n, dtype=np.complex128)
    z[pinned] = position
    rhs = [
        pattern.row_sums(i, part(entry * z[b])) + pattern.row_sums(j, part(entry.conj() * z[a]))
        for part in (np.real, np.imag)
    ]
    lower = pattern.lower(entry[pattern.pairs], pattern.row_sums(i, weight) + pattern.row_sums(j, weight))
    factor = solvers.whole(lower)
    factor.factor(lower)
    z[free] = factor.solve(-rhs[0] - 1j * rhs[1])
    return z, factor.name


def greedy(topology: Topology, alpha: FloatArray) -> ComplexArray:
    """Triangle after triangle over a breadth-first tree (the paper's section 5); errors add up.

    The seed is the triangle whose smallest angle is the largest; among equally short ways the
    tree takes the one across the smaller opposite angles, so that the numbering plays no part.
    """
    m = alpha.shape[1]
    angle = alpha.ravel()
    inside = topology.sides[:, topology.sides[1] >= 0]
    here, there = np.concatenate((inside, inside[::-1]), axis=1)  # half-edges, k m + t, and their twins
    weight = 1 + 1e-3 / m * (angle[here] + angle[there])
    graph = sparse.csr_array((weight, (here % m, there % m)), shape=(m, m))
    seed = int(np.argmax(alpha.min(axis=0)))
    depth, parent = csgraph.dijkstra(graph, indices=seed, return_predecessors=True)
    # every triangle in a frame of its own: corner 0 at 0, corner 1 on the real axis
    sine = np.sin(alpha)
    local = np.stack((np.zeros(m), sine[2], sine[1] * np.exp(1j * alpha[0])))
    # z -> ratio z + shift takes a triangle's frame to its parent's; their sides run in opposite ways
    tree = parent[there % m] == here % m
    k, t, c, child = here[tree] // m, here[tree] % m, there[tree] // m, there[tree] % m
    tail, head = local[(k + 1) % 3, t], local[(k + 2) % 3, t]
    child_tail, child_head = local[(c + 2) % 3, child], local[(c + 1) % 3, child]
    ratio, shift = np.ones(m, dtype=np.complex128), np.zeros(m, dtype=np.complex128)
    ratio[child] = (head - tail) / (child_head - child_tail)
    shift[child] = tail - ratio[child] * child_tail
    above = np.where(parent < 0, seed, parent)
    while (above != seed).any():  # each round composes the way to an ancestor twice as far up
        shift = ratio[above] * shift + shift[above]
        ratio = ratio[above] * ratio
        above = above[above]
    placed = (ratio * local + shift).ravel()
    nearest = np.argsort(np.tile(depth, 3), kind="stable")
    first = np.unique(topology.corner.ravel()[nearest], return_index=True)[1]
    return np.asarray(placed[nearest[first]])


def far_apart(points: FloatArray) -> IntArray:
    """Two points of a closed polygon (#P, dim) half its length apart; of such pairs the most distant."""
    arc = np.concatenate(([0], np.cumsum(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1))))
    opposite = np.searchsorted(arc, (arc[:-1] + arc[-1] / 2) % arc[-1]) % len(points)
    i = int(np.argmax(np.linalg.norm(points - points[opposite], axis=1)))
    return np.array([i, opposite[i]])


def placed(topology: Topology, z: ComplexArray, area: float, pinned: Pins | None) -> ComplexArray:
    """The map where its pins want it, or else scaled to `area`, centred and turned."""
    return centred(topology, z, area) if pinned is None else placed_at(z, pinned)


@dataclass(frozen=True, eq=False)
class Layout:
    """A map, how it was made, and by how much its boundary failed to close."""

    z: ComplexArray
    method: str
    gap: float
    solver: str


def lay_out(
    topology: Topology,
    alpha: FloatArray,
    missing: Residual,
    method: LayoutName,
    pinned: Pins | None,
    area: float,
    solvers: Solvers,
    pattern: Pattern | None = None,
    laplacian: Factor | None = None,
) -> Layout:
    """Lay out triangles' angles, (3, #F) radians.

    `pattern` and `laplacian` are those of the interior vertices, where they are there already.
    """
    boundary = develop_boundary(topology, missing)
    cot = 1 / np.tan(alpha)
    solver, made = "none", method
    holes = len(topology.loops) > 1
    if method == "auto":
        made = "boundary" if boundary.gap <= GAP and not holes else "least-squares"
    elif method == "boundary" and holes:
        raise MeshError(
            f"layout='boundary' draws one boundary loop, and the mesh has {len(topology.loops)}: use "
            "layout='least-squares' or 'auto'"
        )
    try:
        if made == "boundary":
            pattern = pattern or Pattern(topology, topology.row, len(topology.target))
            z, solver = harmonic(topology, boundary, cot, pattern, laplacian, solvers)
        elif made == "least-squares":
            ends = far_apart(coordinates(boundary.z))
            index, position = topology.loops[0][ends], boundary.z[ends]
            if pinned is not None:
                index, position = pinned[0], complex_positions(pinned[1])
            z, solver = least_squares(topology, cot, index, position, solvers)
        else:
            z = greedy(topology, alpha)
    except NotPositiveDefiniteError:
        thin = np.argsort(alpha.min(axis=0), kind="stable")[:5]
        raise MeshError(
            f"the {made} layout is singular in double precision; the thinnest target triangles are faces "
            f"{some(thin)} (smallest angle {alpha[:, thin[0]].min():.1e} rad): remove degenerate faces, "
            "cut the mesh, or use layout='greedy'"
        ) from None
    if pinned is None or made != "least-squares":
        z = placed(topology, z, area, pinned)
    return Layout(z, made, boundary.gap, solver)


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
        Triangles of one disk, or of one with holes.
    angles : (#F, 3) float
        Target angles in radians, `angles[t, k]` at vertex `F[t, k]` as `igl.internal_angles`
        returns them; in (0, pi), each row summing to pi.
    b, bc : (2,) int and (2, 2) float, optional
        Two pinned vertices and their positions, as in `igl.lscm`.
    method : {"auto", "boundary", "least-squares", "greedy"}
        "boundary" draws the boundary loop as the angles at it say, and both coordinates harmonic
        inside; "least-squares" minimises the conformal energy from the triangles with these angles
        (section 5 of the paper); "greedy" sets triangle to triangle (there, too). "auto" is the
        first where there are no holes and the drawn loop closes to 2.5e-3 of its length, and
        else the second.
    outer : int, optional
        A vertex of the outer boundary loop; by default that is the loop of the most edges. The
        default pins of "least-squares" are on it.
    solver : {"auto", "cholmod", "multigrid", "direct"}
        See `linabf`.

    Returns
    -------
    uv : (#V, 2) float64
        With pins, they are where `bc` says: constraints of "least-squares", and reached by a
        similarity otherwise. Without, the map has the area 1, its centroid at the origin and its
        principal axes along x and y. NaN at vertices that no face refers to.

    Raises
    ------
    MeshError
        `F` is not one oriented manifold disk or one with holes, the angles are not those of
        triangles, or the pins are not two different vertices.

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
        topology = with_outer(topology, loop_through(topology, outer, vertices))
    alpha = checked_angles(angles, len(faces))
    pinned = pins(b, bc, vertices, n)
    made = lay_out(topology, alpha, residual(topology, alpha), method, pinned, 1.0, Solvers(solver))
    return scatter(coordinates(made.z), vertices, n)


def check_method(method: str) -> None:
    """Raise where `method` is not the name of a layout."""
    if method not in get_args(LayoutName):
        names = ", ".join(map(repr, get_args(LayoutName)))
        raise ValueError(f"the layout is {method!r}: use one of {names}")


def checked_angles(angles: ArrayLike, m: int) -> FloatArray:
    """Angles as (3, #F), if they are those of triangles."""
    array = vertex_array(angles, 3, "angles")
    if len(array) != m:
        raise MeshError(f"angles has {len(array)} rows for {m} faces: pass three angles a face")
    bad = np.flatnonzero(
        ~((array > 0) & (array < np.pi)).all(axis=1) | ~(np.abs(array.sum(axis=1) - np.pi) < 1e-6)
    )
    if len(bad):
        raise MeshError(
            f"the angles of faces {some(bad)} are not those of a triangle (face {bad[0]}: "
            f"{array[bad[0]].tolist()} rad): they must be within (0, pi) and sum to pi"
        )
    return np.ascontiguousarray(array.T)
