"""Quadrangular remeshing of a surface along the iso-lines of its flat map."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, first_few, is_number
from ..measures import measure_change
from ..surface import Submesh, complex_positions, connected_labels, cycles, signed_double_areas
from .constants import ROUNDING
from .slicing import Fragments, slice_along_integers, slice_region

DEFAULT_CELLS = 1000  # default number of cells
MAX_CELLS = 10_000_000  # maximum number of cells; exceeded if the spacing is in the wrong unit


@dataclass(frozen=True, eq=False)
class QuadGrid:
    """A quad-dominant mesh of a surface.

    Attributes
    ----------
    V : (#P, 3) float64
        Vertices on the surface.
    uv : (#P, 2) float64
        The same vertices in the flat map.
    faces : tuple of int64 arrays
        Polygons with the orientation of the surface. Each is a cell of the grid, or a part of a cell that is
        divided by the boundary.
    whole : (#faces,) bool
        Whether each polygon is a whole cell, which is a square in the map.
    spacing : float
        Distance between neighbouring iso-lines in the map.
    """

    V: FloatArray
    uv: FloatArray
    faces: tuple[IntArray, ...]
    whole: BoolArray
    spacing: float

    @property
    def quads(self) -> IntArray:
        """The whole cells, (#Q, 4)."""
        chosen = [self.faces[i] for i in np.flatnonzero(self.whole)]
        return np.array(chosen, dtype=np.int64).reshape(-1, 4)


def quad_grid(V: ArrayLike, F: ArrayLike, uv: ArrayLike, spacing: float | None = None) -> QuadGrid:
    """Remesh a surface along the iso-lines u = i spacing, v = j spacing of its flat map.

    Each cell inside the map becomes a quadrangle, with right angles if the map is conformal. Cells at the
    boundary are clipped to polygons, so that the grid covers the surface. A cell with a hole inside is cut in
    two. Edges are straight, even if the surface is curved.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of any number of charts. The grid ends at their boundaries.
    uv : (#V, 2) float
        The map. It may overlap itself, but must not have flipped triangles.
    spacing : float, optional
        Distance between lines in the units of `uv`; by default it gives about 1000 cells.

    Returns
    -------
    QuadGrid

    Raises
    ------
    MeshError
        The surface is not an oriented manifold, the map has flipped triangles or winds more than
        once around a vertex, or `spacing` gives more than ten million cells.
    ValueError
        `spacing` is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> V, F = np.array([[0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    >>> grid = quad_grid(V, F, V[:, :2], 1.0)
    >>> grid.quads.shape, grid.V.shape
    ((6, 4), (12, 3))
    """
    surface = Submesh.from_input(V, F)
    map_ = surface.check_map(uv)
    changed = measure_change(surface, map_)
    if changed.is_flipped.any():
        bad = np.flatnonzero(changed.is_flipped)
        raise MeshError(f"faces {first_few(bad)} are flipped in uv: a grid needs a map without flips")
    topology = surface.topology
    around = topology.sum_at_vertices(changed.angle + changed.angle_error)
    around[topology.edges[(topology.sides < 0).any(axis=0)]] = 0
    if (around > 3 * np.pi).any():
        twice = surface.vertices[around > 3 * np.pi]
        raise MeshError(
            f"uv winds more than once around vertices {first_few(twice)}: a grid needs one winding"
        )
    area = signed_double_areas(complex_positions(map_), topology.corner).sum() / 2
    if spacing is None:
        spacing = float(np.sqrt(area / DEFAULT_CELLS))
    if not is_number(spacing, 0, np.finfo(float).max, above=True):
        raise ValueError(f"spacing is {spacing!r}: give a positive distance between lines in uv")
    crossed = np.ptp(map_[topology.edges], axis=1).sum() / spacing  # number of crossings of edges and lines
    cells = max(area / spacing**2, crossed)
    if cells > MAX_CELLS:
        raise MeshError(f"spacing {spacing:g} would make {cells:.2g} cells: give more distance between lines")
    fragments = slice_along_integers(Fragments(map_ / spacing, surface.V, surface.F))
    loops = _trace_loops(fragments)
    while loops.holes:
        regions = len(np.unique(loops.region))
        for region, hole in loops.holes.items():
            low, high = fragments.x[hole].min(axis=0), fragments.x[hole].max(axis=0)
            axis = int(np.argmax(high - low))
            fragments = slice_region(fragments, region, axis, float((low + high)[axis] / 2))
        loops = _trace_loops(fragments)
        if len(np.unique(loops.region)) == regions:
            break  # the hole is too small for double precision
    return _assemble_grid(fragments, loops, spacing, topology.characteristic)


@dataclass(frozen=True, eq=False)
class _Loops:
    """The boundary loops of the regions.

    Attributes
    ----------
    region : (#L,) int64
        Region of each loop.
    vertices : list of int64 arrays
        Vertices of each loop.
    borders : (#B, 2) int64
        Edges between different regions, and boundary edges of the surface.
    rim : (#R, 2) int64
        Directed boundary edges of the surface.
    holes : dict of int to int64 array
        The loop of one hole for each region that is not a disk.
    """

    region: IntArray
    vertices: list[IntArray]
    borders: IntArray
    rim: IntArray
    holes: dict[int, IntArray]


def _trace_loops(fragments: Fragments) -> _Loops:
    """Merge the fragments of each cell to connected regions, relabel them, and trace their loops."""
    F = fragments.F
    beside, side = igl.triangle_triangle_adjacency(F)
    same = (beside >= 0) & (fragments.label[beside] == fragments.label[:, None])
    t, k = np.nonzero(same)
    fragments.label[:] = connected_labels(np.column_stack((t, beside[t, k])), len(F))
    t, k = np.nonzero(~same)  # half-edge k runs from corner k to k + 1
    number = np.full(F.shape, -1)
    number[t, k] = np.arange(len(t))
    ahead_t, ahead_k = t.copy(), (k + 1) % 3
    going = np.flatnonzero(same[ahead_t, ahead_k])
    while len(going):  # rotate around the head of each half-edge, within its region
        i, j = ahead_t[going], ahead_k[going]
        ahead_t[going], ahead_k[going] = beside[i, j], (side[i, j] + 1) % 3
        going = going[same[ahead_t[going], ahead_k[going]]]
    tails, heads = F[t, k], F[t, (k + 1) % 3]
    walks = cycles(number[ahead_t, ahead_k])
    region = fragments.label[t[[walk[0] for walk in walks]]]
    loops = [tails[walk] for walk in walks]
    sides = np.column_stack((tails, heads))
    borders, rim = np.unique(np.sort(sides, axis=1), axis=0), sides[beside[t, k] < 0]
    return _Loops(region, loops, borders, rim, _find_holes(fragments.x, region, loops))


def _find_holes(x: FloatArray, region: IntArray, loops: list[IntArray]) -> dict[int, IntArray]:
    """Return one inner loop of each region with several loops; the outer loop has the largest area."""
    several = np.flatnonzero(np.bincount(region)[region] > 1)
    enclosed = {}
    for i in several.tolist():
        z = complex_positions(x[loops[i]])
        enclosed[i] = float((z.conj() * np.roll(z, -1)).imag.sum())
    return {int(region[i]): loops[i] for i in sorted(enclosed, key=lambda i: -enclosed[i])}


def _assemble_grid(fragments: Fragments, loops: _Loops, spacing: float, euler: int) -> QuadGrid:
    """Build the grid; keep only vertices where lines meet or the boundary turns."""
    x, V = fragments.x, fragments.V
    degree = np.bincount(loops.borders.ravel(), minlength=len(x))
    kept = degree > 2
    tail, head = loops.rim.T
    before = np.full(len(x), -1)
    before[head] = tail
    a, b, c = before[tail], tail, head
    turns = np.zeros(len(b), dtype=bool)
    for points in (x, V):
        first, second = points[b] - points[a], points[c] - points[b]
        along = (first * second).sum(axis=1)
        total = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
        turns |= total - along > ROUNDING**2 * total + 4 * np.finfo(float).eps * total
    kept[b[turns]] = True
    number = np.cumsum(kept) - 1
    cell_area = np.bincount(fragments.label, signed_double_areas(complex_positions(x), fragments.F.T) / 2)
    polygons, whole = [], []
    for region, loop in zip(loops.region.tolist(), loops.vertices, strict=True):
        polygon = number[loop[kept[loop]]]
        if len(polygon) > 2:  # degenerate cells between the boundary and a line have two vertices
            polygons.append(polygon)
            whole.append(len(polygon) == 4 and abs(cell_area[region] - 1) < 1e-6)
    grid = QuadGrid(V[kept], x[kept] * spacing, tuple(polygons), np.array(whole, dtype=bool), spacing)
    if _compute_euler_characteristic(grid) != euler:
        raise MeshError(f"spacing {spacing:g} is too large for the surface: give a smaller spacing")
    return grid


def _compute_euler_characteristic(grid: QuadGrid) -> int:
    """Return the number of vertices minus edges plus faces."""
    sides = np.concatenate([np.column_stack((face, np.roll(face, -1))) for face in grid.faces])
    return len(grid.V) - len(np.unique(np.sort(sides, axis=1), axis=0)) + len(grid.faces)
