"""Reference for the packing functions of the core, cell by cell and edge by edge."""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

FREE = -1


def winding(start, end, weight, point):
    """Compute the winding number of an outline around a point from the sides that cross the ray to +x."""
    rise = end.imag - start.imag
    crossed = (start.imag <= point.imag) != (end.imag <= point.imag)
    x = start.real + (point.imag - start.imag) / np.where(crossed, rise, 1) * (end.real - start.real)
    return int((np.sign(rise) * weight)[crossed & (x > point.real)].sum())


def meets(start, end, low, high):
    """Return True for sides that meet the rectangle from `low` to `high` (Liang, Barsky 1984)."""
    first, last = np.zeros(len(start)), np.ones(len(start))
    for part in (np.real, np.imag):
        a, by = part(start), part(end) - part(start)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.sort(np.stack(((part(low) - a) / by, (part(high) - a) / by)), axis=0)
        beside = (by == 0) & ((a < part(low)) | (a > part(high)))
        first = np.where(by == 0, np.where(beside, np.inf, first), np.maximum(first, t[0]))
        last = np.where(by == 0, last, np.minimum(last, t[1]))
    return first <= last


def mask(start, end, weight, half):
    """Return the corner of the cell grid of an outline, and a mask (rows, columns) of the touched cells.

    A cell is touched if the outline winds around its centre, or if a side is within `half` in u and in v.
    """
    corner = complex(start.real.min() - half, start.imag.min() - half)
    a, b = start - corner, end - corner
    columns, rows = (int(part(a).max() + half) + 1 for part in (np.real, np.imag))
    touched = np.zeros((rows, columns), dtype=bool)
    widened = half * (1 + 1j)
    for row, column in np.ndindex(rows, columns):
        low = column + 1j * row
        touched[row, column] = winding(a, b, weight, low + 0.5 + 0.5j) != 0 or bool(
            meets(a, b, low - widened, low + 1 + 1j + widened).any()
        )
    return corner, touched


def cells_of(shape, blocks):
    """Return the cells of a mask as the union of rectangular blocks, which must not overlap."""
    cells = np.zeros(shape, dtype=np.int64)
    for row, column, length, high in blocks:
        cells[row : row + high, column : column + length] += 1
    assert cells.max(initial=0) <= 1
    return cells > 0


def place(taken, extent, masks):
    """Return the mask and position (x, y) with the smallest bounding square, then nearest to the origin.

    `extent` is the width and the height of the occupied part.
    """
    side, best = len(taken), (np.inf, np.inf, FREE, FREE, FREE)
    for k, cells in masks.items():
        high, wide = cells.shape
        for y, x in np.ndindex(max(side - high + 1, 0), max(side - wide + 1, 0)):
            if not (taken[y : y + high, x : x + wide] & cells).any():
                far = (x + wide / 2) ** 2 + (y + high / 2) ** 2
                best = min(best, (max(x + wide, y + high, *extent), far, k, y, x))
    return best[2], best[4], best[3]


def place_masks(side, most, spans, cells):
    """Place charts in order; return mask, page, x and y of each (-1 if impossible), and the page extents."""
    places, pages = np.full((len(spans), 4), FREE), []
    for chart, (first, after) in enumerate(spans):
        page = 0
        while places[chart, 0] == FREE:
            if page == len(pages):
                if page == most or (pages and pages[-1][1] == [0, 0]):
                    return places, np.array([extent for _, extent in pages])
                pages.append((np.zeros((side, side), dtype=bool), [0, 0]))
            taken, extent = pages[page]
            k, x, y = place(taken, extent, {k: cells[k] for k in range(first, after)})
            if k != FREE:
                high, wide = cells[k].shape
                taken[y : y + high, x : x + wide] |= cells[k]
                extent[:] = max(extent[0], x + wide), max(extent[1], y + high)
                places[chart] = k, page, x, y
            page += 1
    return places, np.array([extent for _, extent in pages])


def pack_shelves(sizes, taken):
    """Place rectangles on shelves, in the gaps between occupied cells; return their lower left corners."""
    side, places, first, bottom = len(taken), [], 0, 0.0
    while first < len(sizes) and bottom + sizes[first, 1] <= side:
        height, before = sizes[first, 1], first
        free = ~taken[int(bottom) : int(np.ceil(bottom + height))].any(axis=0)
        change = np.flatnonzero(np.diff(np.concatenate(([False], free, [False]))))
        for left, right in change.reshape(-1, 2):
            x = left
            while first < len(sizes) and x + sizes[first, 0] <= right:
                places.append((x, bottom))
                x, first = x + sizes[first, 0], first + 1
        bottom = bottom + height if first > before else np.floor(bottom) + 1
    return np.array(places).reshape(-1, 2)


def rectangle(z):
    """Return the area of the axis-aligned bounding rectangle of points."""
    return np.ptp(z.real) * np.ptp(z.imag)


def least_rectangle(z):
    """Return the smallest area of a bounding rectangle with a side parallel to a line through two points."""
    ways = np.unique((z[:, None] - z).ravel())
    return min(rectangle(z * way.conj() / abs(way)) for way in ways[ways != 0])


def evaluate_cut_lines(points, ends, length, outer, normal, offset, outwards):
    """Return, for each dividing line, the area of the hulls, the longest diagonal, and the cut length."""
    made = []
    for side, to in zip(normal, offset, strict=True):
        beyond = points @ side > to
        cut = beyond[ends[:, 0]] != beyond[ends[:, 1]]
        near = outer.copy()
        near[ends[cut]] = True
        kept, n = ends[~cut], len(points)
        graph = sparse.coo_array((np.ones(len(kept)), kept.T), (n, n))
        label, hulls, widest = connected_components(graph, directed=False)[1], 0.0, 0.0
        for part in np.unique(label[near]):
            own = points[near & (label == part)]
            x, y = own[(own @ outwards).argmax(axis=0)].T
            hulls += float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
            widest = max(widest, float(np.hypot(*np.ptp(own, axis=0))))
        made.append((hulls, widest, length[cut].sum()))
    return np.array(made).T
