"""Images continue beyond their borders, tangents are averaged by angle, and charts grow into free texels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, map_coordinates

from igl_linabf import Packing, unwrap
from igl_linabf.textures import Picture, bake
from igl_linabf.textures.tangents import compute_tangent_frames

MODES = {"repeat": "grid-wrap", "mirror": "reflect", "clamp": "nearest"}  # names of these modes in SciPy


@pytest.mark.parametrize("across", MODES)
@pytest.mark.parametrize("down", MODES)
def test_images_are_wrapped_in_each_direction(across: str, down: str) -> None:
    pixels, uv = np.random.default_rng(0).random((5, 7)), np.random.default_rng(1).uniform(-3, 3, (500, 2))
    found = Picture(pixels[..., None], (across, down)).interpolate(uv)[:, 0]
    u, v = uv.T
    at = np.stack(
        ((1 - v) * 5 - 0.5, u * 7 - 0.5)
    )  # pixel centres are at half-integers; row 0 is the upper one
    # SciPy has one mode for both axes, so compare points that leave the image along one axis
    for rows, mode in (((v > 0.2) & (v < 0.8), MODES[across]), ((u > 0.2) & (u < 0.8), MODES[down])):
        assert rows.sum() > 30
        np.testing.assert_allclose(found[rows], map_coordinates(pixels, at[:, rows], order=1, mode=mode))


def test_tangents_are_weighted_by_angle() -> None:
    """The tangent at the centre of a fan does not change if one of its triangles is halved."""
    rng = np.random.default_rng(2)
    rim = np.array([[np.cos(a), np.sin(a), 0] for a in (0.0, 0.7, 2.6, 4.0, 5.5)])
    flat = rim[:, :2] + rng.uniform(-0.3, 0.3, (5, 2))
    flat *= 1 + rng.random((5, 1))
    fans = []
    for halved in (False, True):
        points, uv = ([*rows] for rows in (rim, flat))
        if halved:
            points.insert(2, (points[1] + points[2]) / 2)
            uv.insert(2, (uv[1] + uv[2]) / 2)
        pairs = [(i, (i + 1) % len(points)) for i in range(len(points))]
        P = np.array([[np.zeros(3), points[i], points[j]] for i, j in pairs])
        T = np.array([[np.zeros(2), uv[i], uv[j]] for i, j in pairs])
        frames = compute_tangent_frames(P, np.broadcast_to([0, 0, 1.0], P.shape), T)
        # all corners at the centre have the same tangent
        assert np.ptp(frames.tangent[:, 0], axis=0).max() < 1e-12
        fans.append(frames.tangent[0, 0])
    np.testing.assert_allclose(*fans, atol=1e-12)


@pytest.mark.parametrize("padding", [1, 2, 5])
def test_charts_grow_by_the_padding(padding: int) -> None:
    V = np.array([[0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0.0]])
    F = np.array([[0, 1, 2], [0, 2, 3]])
    atlas = unwrap(V, F, packing=Packing(resolution=64, padding=6))
    alone, grown = (
        np.isfinite(bake(V, F, atlas, V, 64, padding=k, background=np.nan)[..., 0]) for k in (0, padding)
    )
    assert (grown == binary_dilation(alone, np.ones((3, 3)), padding)).all()
    assert not grown.all()
