"""Seams: the edges along which a surface is cut open, so that it can be flattened."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from .._runtime import advance
from .._types import FloatArray, IntArray
from ..errors import MeshError, some
from ..linalg import Solvers
from ..surface import (
    NEXT,
    PREV,
    Submesh,
    Topology,
    check_fans,
    compact,
    cut_faces,
    face_array,
    seam_mask,
    topology_of,
    vertex_array,
)
from .cut_graph import ClosedSurface, closed_surface, join, open_handles, shortened

TRADE = 6.0
MAX_LEAVES = 100  # on a component
MAX_LEAVES_IN_VAIN = 3  # in a row that do not pay, before no more are tried
MAX_LOG_SCALE = 100.0  # up to which powers of the scale are told apart


def cut(V: ArrayLike, F: ArrayLike, seams: ArrayLike) -> tuple[FloatArray, IntArray, IntArray]:
    """Cut a surface open along edges (`igl.cut_mesh` with its input checked).

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, loops and handles.
    seams : (#E, 2) int, or (#F, 3) bool
        The edges, as pairs of vertices; or for the edge from `F[f, k]` to `F[f, k + 1]` of each
        face whether it is a seam, said on one of its two sides at least. Boundary edges are
        harmless, and so is a single edge inside, which opens nothing.

    Returns
    -------
    V : (#V', 3) float64
        The vertices as they were, then the copies that the seams made of them.
    F : (#F, 3) int64
        The same faces and corners in the same order.
    origin : (#V',) int64
        The vertex that each was.

    Raises
    ------
    MeshError
        The arrays are malformed, the surface is no oriented manifold, or a pair is no edge.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> V_cut, F_cut, origin = cut(V, F, find_seams(V, F))
    >>> len(igl.boundary_loop_all(F_cut)), igl.euler_characteristic(F_cut)
    (1, 1)
    >>> bool((V_cut == V[origin]).all())
    True
    """
    positions, faces = vertex_array(V), face_array(F)
    _manifold(faces, len(positions))
    F_cut, origin = cut_faces(faces, len(positions), seam_mask(seams, faces, len(positions)))
    return positions[origin], F_cut, origin


def texture_seams(F: ArrayLike, FTC: ArrayLike) -> IntArray:
    """The seams of existing texture coordinates.

    Parameters
    ----------
    F : (#F, 3) int
        Oriented triangles.
    FTC : (#F, 3) int
        Rows of the texture coordinates at their corners, as `igl.readOBJ` returns them.

    Returns
    -------
    seams : (#E, 2) int64
        Vertices of the edges inside the surface whose two faces differ in a texture corner.

    Raises
    ------
    MeshError
        The arrays are malformed or do not fit, a corner has no texture, or the surface is no
        oriented manifold.

    Examples
    --------
    >>> texture_seams([[0, 1, 2], [2, 1, 3]], [[0, 1, 2], [4, 1, 3]])
    array([[1, 2]])
    """
    faces, texture = face_array(F), face_array(FTC)
    if texture.shape != faces.shape:
        raise MeshError(f"FTC has {len(texture)} rows for {len(faces)} faces: pass one row a face")
    bad = np.flatnonzero((texture < 0).any(axis=1))
    if len(bad):
        raise MeshError(f"faces {some(bad)} have corners without texture in FTC: give them coordinates")
    topology, vertices = _manifold(faces, int(faces.max()) + 1)
    return vertices[edges_between_textures(topology, texture)]


def edges_between_textures(topology: Topology, texture: IntArray) -> IntArray:
    """`texture_seams` of a surface that is checked, by its own vertices."""
    first, second = topology.sides[:, topology.sides[1] >= 0]
    start, end = texture.T[NEXT].ravel(), texture.T[PREV].ravel()  # of each half-edge
    differ = (start[first] != end[second]) | (end[first] != start[second])
    return np.asarray(topology.edges[topology.sides[1] >= 0][differ])


def find_seams(
    V: ArrayLike, F: ArrayLike, *, trade: float = TRADE, holes: bool = False, disks: bool = False
) -> IntArray:
    """Find short seams that make every component a disk of low distortion.

    Handles are opened along short loops through one point (shortest-path tree and cotree of
    Erickson, Whittlesey 2005), holes joined by a tree of shortest paths. Then leaves grow on the
    seam, each by a shortest path from where the scale of the conformal map with unit scale on the
    seam is farthest from one (one Laplace system a leaf, as in boundary first flattening), which
    is at the tips that would shrink. That map's stretch, which the flattened surface's is close
    to, tells which number of leaves is worth its length, and which branch points may move to
    shorten the seam.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of components, loops and handles.
    trade : float
        Seam length, in square roots of the component's area, that lowering the L2 stretch by 1
        is worth; along a crease of a right angle or more an edge counts half. 0: only what is
        needed to be a disk. Large: leaves as long as the stretch to expect falls, at most 100 a
        component.
    holes : bool
        Leave boundary loops uncut where they are: each component becomes a disk with holes.
    disks : bool
        Grow leaves on components that need no seam, too; by default they are left as they are.

    Returns
    -------
    seams : (#E, 2) int64
        Vertices of the edges, as `cut` takes them.

    Raises
    ------
    MeshError
        The arrays are malformed, the surface is no oriented manifold, or a face is degenerate.
    ValueError
        `trade` is negative or not a number.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> find_seams(V, F[1:]).shape  # a disk
    (0, 2)
    >>> find_seams(V, F, trade=0).shape  # a path from one vertex to the opposite one
    (3, 2)
    """
    return seams_of(Submesh.checked_manifold(V, F), trade, holes=holes, disks=disks)


def seams_of(
    surface: Submesh, trade: float, *, holes: bool = False, disks: bool = False, gain: float = 0.0
) -> IntArray:
    """`find_seams` of a checked manifold, or of a part of one; by the caller's vertices.

    Components that need no seam get one if it pays by `gain` at least, in L2 stretch.
    """
    if not trade >= 0:
        raise ValueError(f"trade is {trade!r}: use a number from 0 (shortest seams) upwards")
    found = [np.zeros((0, 2), dtype=np.int64)]
    for component in surface.components():
        loops, genus = len(component.topology.loops), component.topology.genus
        open_ = genus == 0 and (loops == 1 or (holes and loops > 1))
        if not open_ or (disks and trade > 0):
            piece = closed_surface(component)
            seam = _seam(piece, trade, holes)
            if not open_ or _cost(piece, seam[:0], trade) - _cost(piece, seam, trade) >= gain:
                found.append(component.vertices[piece.edges[seam]])
    return np.concatenate(found)


def _manifold(faces: IntArray, n: int) -> tuple[Topology, IntArray]:
    """Connectivity, and the vertices in use; raises if no manifold."""
    vertices, packed = compact(faces, n)
    topology = topology_of(packed, vertices)
    check_fans(packed, topology.sides, vertices)
    return topology, vertices


def _seam(piece: ClosedSurface, trade: float, holes: bool) -> IntArray:
    """Edges to cut `piece` along."""

    def cost(seam: IntArray) -> float:
        return _cost(piece, seam, trade)

    seam = open_handles(piece) if piece.genus else np.zeros(0, dtype=np.int64)
    seam = shortened(piece, seam, piece.total)
    if not holes:
        seam = join(piece, seam)
    if not piece.holes and not len(seam):
        seam = _slit(piece)
    if trade > 0:
        seam = _grow(piece, seam, trade)
    return shortened(piece, seam, cost)


def _slit(piece: ClosedSurface) -> IntArray:
    """A path to open a sphere: between the tips farthest from it, as the scale sees it."""
    extra = piece.curvature - 4 * np.pi * piece.area / piece.area.sum()
    start = int(np.argmin(_log_scale(piece, np.array([0]), extra)))
    end = int(np.argmin(_log_scale(piece, np.array([start]), piece.curvature)))
    distance, before, _ = piece.search(np.array([start]))
    path = piece.paths(before, [end])
    if len(path) == 1:  # a single edge opens nothing
        distance[[start, end]] = np.inf
        path = np.append(path, piece.paths(before, [int(np.argmin(distance))]))
    return path


def _grow(piece: ClosedSurface, seam: IntArray, trade: float) -> IntArray:
    """Add leaves one by one; of these seams the one of least cost."""
    best, least, in_vain = seam, np.inf, 0
    for _ in range(MAX_LEAVES):
        u = _log_scale(piece, _open_nodes(piece, seam), piece.curvature)
        cost = _cost(piece, seam, trade, u)
        advance("seams", 0.1)
        in_vain = 0 if cost < least else in_vain + 1
        if in_vain == 0:
            best, least = seam, cost
        leaf = int(np.argmax(np.abs(u)))
        if in_vain == MAX_LEAVES_IN_VAIN or u[leaf] == 0:
            break
        _, before, _ = piece.search(_open_nodes(piece, seam))
        seam = np.append(seam, piece.paths(before, [leaf]))
    return best


def _cost(piece: ClosedSurface, seam: IntArray, trade: float, u: FloatArray | None = None) -> float:
    """The L2 stretch to expect, and the length by what it is worth."""
    length = piece.total(seam) / piece.size
    if trade == 0:
        return length
    if u is None:
        u = _log_scale(piece, _open_nodes(piece, seam), piece.curvature)
    weight = piece.area / piece.area.sum()
    return float(np.sqrt((weight @ np.exp(-2 * u)) * (weight @ np.exp(2 * u)))) + length / trade


def _open_nodes(piece: ClosedSurface, seam: IntArray) -> IntArray:
    """The nodes on the seam and the holes."""
    return np.union1d(piece.ends[seam], np.arange(piece.holes))


def _log_scale(piece: ClosedSurface, fixed: IntArray, curvature: FloatArray) -> FloatArray:
    """Logarithm of the scale that takes away `curvature`, zero at the nodes `fixed`."""
    free = np.setdiff1d(np.arange(piece.n), fixed)
    u = np.zeros(piece.n)
    if len(free):
        lower = sparse.tril(piece.laplacian[free][:, free]).tocsc()
        lower.sort_indices()
        u[free] = Solvers().laplacian(lower).factor(lower).solve(-curvature[free])
    return np.clip(u, -MAX_LOG_SCALE, MAX_LOG_SCALE)
