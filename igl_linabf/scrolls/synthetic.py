"""Make a synthetic scroll segment for tests, examples and benchmarks."""

import numpy as np
import scipy.ndimage

from ..io import Segment

POINT_DISTANCE = 20.0  # distance between neighbouring points, in voxels
WINDING_DISTANCE = 200.0  # distance between neighbouring windings, in voxels
INNER_RADIUS = 1500.0  # radius at the start of the spiral, in voxels
NOISE = 1.0  # standard deviation of coordinates, in voxels
MIN_Z = 1000.0  # smallest z, in voxels


def synthetic_segment(rows: int, columns: int, seed: int = 0) -> Segment:
    """Make a synthetic segment of a spiral sheet, with the defects of real segments.

    The sheet has noise, bulges, a ragged border, holes, coincident neighbours, a part that is connected by a
    thin bridge, and a second piece.

    Parameters
    ----------
    rows, columns : int
        Size of the grid, at least 20 by 20. The rows run along the axis of the scroll, from high to low z.
    seed : int
        Seed of the random numbers.

    Returns
    -------
    Segment
        With a distance of 20 voxels between neighbouring points.

    Raises
    ------
    ValueError
        The grid is too small.

    Examples
    --------
    >>> synthetic_segment(60, 200).points.shape
    (60, 200, 3)
    """
    if min(rows, columns) < 20:
        raise ValueError(f"the grid has {rows} x {columns} points: give at least 20 x 20")
    rng = np.random.default_rng(seed)
    row, column = np.mgrid[:rows, :columns].astype(float)
    along, up = POINT_DISTANCE * column, POINT_DISTANCE * (rows - 1 - row)
    grow = WINDING_DISTANCE / (2 * np.pi)  # increase of the radius per radian
    turn = (
        np.sqrt(INNER_RADIUS**2 + 2 * grow * along) - INNER_RADIUS
    ) / grow  # angle of the spiral at arc length `along`
    radius = INNER_RADIUS + grow * turn + 0.2 * WINDING_DISTANCE * np.sin(up / 400) * np.sin(along / 600)
    points = np.stack((radius * np.cos(turn), radius * np.sin(turn), up), axis=2)
    centre = 1.5 * radius.max()
    points += rng.normal(0, NOISE, points.shape) + np.array([centre, centre, MIN_Z])
    twice = rng.random((rows, columns - 1)) < 0.002
    points[:, 1:][twice] = points[:, :-1][twice]  # make neighbours coincident
    missing = np.abs(column - 0.8 * columns) < 1.5
    missing[rows // 2 - 1 : rows // 2 + 1] = False  # leave a bridge of one cell
    missing |= np.abs(column - 0.93 * columns) < 1.5  # a gap that cuts off the second piece
    for radius_of_hole in (1.0, 3.0):
        seeds = rng.random((rows, columns)) < 1 / 3000
        missing |= scipy.ndimage.distance_transform_edt(~seeds) < radius_of_hole
    missing |= row < 2 * rng.random(columns)  # make the border ragged
    points[missing] = np.nan
    return Segment(points, (1 / POINT_DISTANCE, 1 / POINT_DISTANCE), {"type": "seg", "name": "synthetic"})
