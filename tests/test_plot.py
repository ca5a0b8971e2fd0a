"""Pictures, by what is in them."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv
from conftest import best_fit_distance, load, pixels

from igl_linabf import flatten, linabf
from igl_linabf.plot import DARK, LIGHT, WARNING, fit, plot_checkerboard, plot_compare, plot_uv


def near(image: np.ndarray, colour: str, tolerance: int = 10) -> np.ndarray:
    """Which pixels have a colour."""
    return (np.abs(image[..., :3].astype(int) - pv.Color(colour).int_rgb) <= tolerance).all(axis=-1)


def squares(image: np.ndarray) -> int:
    """Changes between light and dark along the middle row, which count a board's squares."""
    row = image[len(image) // 2]
    seen = np.where(near(row, LIGHT), 1, np.where(near(row, DARK), -1, 0))
    seen = seen[seen != 0]
    return int(np.count_nonzero(np.diff(seen)))


@pytest.fixture
def picture(tmp_path):
    def take(maps: dict[str, np.ndarray], V: np.ndarray, F: np.ndarray, **options: object) -> np.ndarray:
        path = tmp_path / "picture.png"
        plot_compare(
            V, F, maps, off_screen=True, screenshot=str(path), window_size=(800, 400), **options
        ).close()
        return pixels(path)

    return take


def test_board_on_the_surface_and_the_flat_map_beside_it(picture) -> None:
    V, F = load("bumps")
    image = picture({"linABF": linabf(V, F)}, V, F, frequency=10)
    surface, flat = image[:, :400], image[:, 400:]
    ours = flat[40:]  # below the caption
    light, dark = near(ours, LIGHT).mean(), near(ours, DARK).mean()
    assert 0.15 < light < 0.6
    assert 0.7 < light / dark < 1.4  # a checkerboard is half and half
    assert near(flat, "black").any()  # the boundary
    assert not near(image, WARNING).any()
    assert 7 <= squares(flat) <= 10
    # the surface is shaded, and not white
    assert 0.2 < (surface.astype(int).sum(axis=-1) < 720).mean() < 0.95
    assert np.unique(surface.reshape(-1, 3), axis=0).shape[0] > 100


def test_frequency_is_the_number_of_squares(picture) -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    few, many = (squares(picture({"": uv}, V, F, frequency=f)[:, 400:]) for f in (6, 18))
    assert 2.5 < many / few < 3.5


def test_flipped_triangles_are_red(picture) -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    vertex = int(np.argmin(np.linalg.norm(uv, axis=1)))
    uv[vertex] += 0.3 * np.ptp(uv)
    image = picture({"spoilt": uv}, V, F)
    assert near(image[:, 400:], WARNING).sum() > 50


def test_compare_has_a_row_for_each_map_turned_alike(picture, tmp_path) -> None:
    V, F = load("bumps")
    ours, lscm = linabf(V, F), flatten(V, F, "lscm").uv
    turned = ours @ np.array([[0.0, 5.0], [-5.0, 0.0]]) + 7
    path = tmp_path / "rows.png"
    plotter = plot_compare(
        V, F, {"linABF": ours, "turned": turned, "igl.lscm": lscm}, off_screen=True, show=False
    )
    assert plotter.shape == (3, 2)
    plotter.show(screenshot=str(path))
    image = pixels(path).astype(int)
    first, second, third = np.split(image, 3)
    assert np.abs(first[80:] - second[80:]).mean() < 1  # but for the caption
    assert np.abs(first[80:] - third[80:]).mean() > 1
    plotter.close()


def test_fit_undoes_a_similarity_and_keeps_nan() -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    moved = uv @ np.array([[0.0, 2.0], [-2.0, 0.0]]) + [1, 2]
    moved[3] = np.nan
    back = fit(moved, uv)
    assert np.isnan(back[3]).all()
    kept = np.arange(len(uv)) != 3
    assert np.allclose(back[kept], uv[kept])
    assert best_fit_distance(back[kept], uv[kept]) < 1e-12


def test_parts_can_be_put_into_a_plotter_of_ones_own() -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    plotter = pv.Plotter(off_screen=True, shape=(1, 2))
    plotter.subplot(0, 0)
    assert plot_checkerboard(V, F, uv, plotter=plotter, opacity=0.9) is plotter
    plotter.subplot(0, 1)
    plot_uv(uv, F, plotter=plotter)
    assert len(plotter.renderers[0].actors) == 1
    assert len(plotter.renderers[1].actors) == 2
    plotter.close()
