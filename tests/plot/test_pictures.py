"""Pictures, tested by their pixels and meshes."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import pyvista as pv
from conftest import best_fit_distance, load, read_pixels
from pixels import count_square_changes, find_colour, locate_in_colour_map

from igl_linabf import Cones, MeshError, cut, distortion, flatten, linabf, unwrap
from igl_linabf.plot import (
    DARK,
    LIGHT,
    SEAM,
    WARNING,
    colour_scale,
    fit,
    plot_checkerboard,
    plot_compare,
    plot_distortion,
    plot_grid,
    plot_uv,
)
from igl_linabf.remesh import quad_grid


@pytest.fixture
def picture(tmp_path):
    def take(maps: dict[str, np.ndarray], V: np.ndarray, F: np.ndarray, **options: object) -> np.ndarray:
        path = tmp_path / "picture.png"
        plot_compare(
            V, F, maps, off_screen=True, screenshot=str(path), window_size=(800, 400), **options
        ).close()
        return read_pixels(path)

    return take


def test_compare_shows_the_checkerboard_on_surface_and_map(picture) -> None:
    V, F = load("bumps")
    image = picture({"linABF": linabf(V, F)}, V, F, frequency=10)
    surface, flat = image[:, :400], image[:, 400:]
    ours = flat[40:]  # without the caption
    light, dark = find_colour(ours, LIGHT).mean(), find_colour(ours, DARK).mean()
    assert 0.15 < light < 0.6
    assert 0.7 < light / dark < 1.4  # half of a checkerboard is light
    assert find_colour(flat, "black").any()  # the boundary of the map is drawn in black
    assert not find_colour(image, WARNING).any()
    assert 7 <= count_square_changes(flat) <= 10
    # the surface is shaded, and fills part of its panel
    assert 0.2 < (surface.astype(int).sum(axis=-1) < 720).mean() < 0.95
    assert np.unique(surface.reshape(-1, 3), axis=0).shape[0] > 100


def test_frequency_is_the_number_of_squares(picture) -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    few, many = (count_square_changes(picture({"": uv}, V, F, frequency=f)[:, 400:]) for f in (6, 18))
    assert 2.5 < many / few < 3.5


def test_flipped_triangles_are_red(picture) -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    vertex = int(np.argmin(np.linalg.norm(uv, axis=1)))
    uv[vertex] += 0.3 * np.ptp(uv)
    image = picture({"spoilt": uv}, V, F)
    assert find_colour(image[:, 400:], WARNING).sum() > 50


def test_compare_has_an_aligned_row_for_each_map(picture, tmp_path) -> None:
    V, F = load("bumps")
    ours, lscm = linabf(V, F), flatten(V, F, method="lscm").uv
    turned = ours @ np.array([[0.0, 5.0], [-5.0, 0.0]]) + 7
    path = tmp_path / "rows.png"
    plotter = plot_compare(
        V, F, {"linABF": ours, "turned": turned, "igl.lscm": lscm}, off_screen=True, show=False
    )
    assert plotter.shape == (3, 2)
    plotter.show(screenshot=str(path))
    image = read_pixels(path).astype(int)
    first, second, third = np.split(image, 3)
    assert np.abs(first[80:] - second[80:]).mean() < 1  # compare the rows without their captions
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


def test_pictures_can_be_added_to_a_given_plotter() -> None:
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


def shot(plotter: pv.Plotter, path) -> np.ndarray:
    plotter.show(screenshot=str(path))
    plotter.close()
    return read_pixels(path)


def off_screen() -> pv.Plotter:
    return pv.Plotter(off_screen=True, window_size=[400, 400])


def make_sheared_map() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a flat square, and a map that doubles the width of its right half."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21)))
    V = np.column_stack((x, y, 0 * x))
    F = pv.PolyData(V).delaunay_2d().regular_faces.astype(np.int64)
    return V, F, np.column_stack((np.where(x > 0, 2 * x, x), y))


def test_distortion_is_coloured_by_its_value_on_a_scale_around_zero(tmp_path) -> None:
    V, F, uv = make_sheared_map()
    options = {"lighting": False, "show_scalar_bar": False}
    for measure, name in (("conformal", "viridis"), ("area", "BrBG")):
        plotter = plot_distortion(V, F, uv, measure, plotter=off_screen(), **options)
        plotter.camera.tight(view="xy", adjust_render_window=False)
        place = locate_in_colour_map(shot(plotter, tmp_path / "map.png"), name)
        left, right = place[150:250, 100:180], place[150:250, 220:300]
        assert np.nanstd(left) < 1e-6
        assert np.nanstd(right) < 1e-6
        assert np.nanmean(left) < 0.01
        # relative to the total area, the left half of the map has 2/3 and the right half has 4/3 of its area
        expected = 1.0 if measure == "conformal" else 0.5 + 0.5 * np.log(4 / 3) / np.log(3 / 2)
        assert abs(np.nanmean(right) - expected) < 0.01


def test_compare_shares_one_scale_over_its_panels(tmp_path) -> None:
    V, F = load("bumps")
    ours = linabf(V, F)
    maps = {"linABF": ours, "sheared": ours @ np.array([[2.0, 0.0], [0.0, 1.0]])}
    path = tmp_path / "rows.png"
    plotter = plot_compare(V, F, maps, measure="conformal", off_screen=True, show=False)
    ranges = {
        actor.mapper.scalar_range
        for renderer in plotter.renderers
        for actor in renderer.actors.values()
        if isinstance(actor, pv.Actor) and actor.mapper.scalar_visibility
    }
    scale = colour_scale([distortion(V, F, uv, "conformal") for uv in maps.values()], "conformal")
    assert len(ranges) == 1
    assert np.allclose(ranges.pop(), scale["clim"])
    image = shot(plotter, path)
    low, high = (
        np.nanmedian(locate_in_colour_map(part[:560, 700:], "viridis")) for part in np.split(image, 2)
    )
    assert low < 0.2
    assert high > 0.7


def test_scalars_colour_the_flat_map(tmp_path) -> None:
    _, F, uv = make_sheared_map()
    for scalars in (uv[:, 0], uv[F, 0].mean(axis=1)):
        plotter = plot_uv(uv, F, scalars=scalars, plotter=off_screen(), cmap="viridis", show_scalar_bar=False)
        row = locate_in_colour_map(shot(plotter, tmp_path / "map.png"), "viridis")[200]
        seen = row[np.isfinite(row)]
        assert len(seen) > 200
        assert seen[0] < 0.05
        assert seen[-1] > 0.95
        assert (np.diff(seen) > -0.01).all()
    with pytest.raises(MeshError, match="one per vertex or one per face"):
        plot_uv(uv, F, scalars=[1.0, 2.0], plotter=off_screen())


def test_flipped_triangles_are_red_in_distortion_too(tmp_path) -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    uv[np.argmin(np.linalg.norm(uv, axis=1))] += 0.3 * np.ptp(uv)
    for measure in ("angle", "conformal", "stretch", "area"):
        plotter = plot_distortion(V, F, uv, measure, plotter=off_screen(), lighting=False)
        plotter.view_xy()
        assert find_colour(shot(plotter, tmp_path / "map.png"), WARNING).sum() > 10
    uv[:] = 0  # collapse all faces
    plotter = plot_distortion(V, F, uv, "angle", plotter=off_screen(), lighting=False)
    plotter.view_xy()
    assert find_colour(shot(plotter, tmp_path / "map.png"), WARNING).mean() > 0.2


def test_given_seams_are_dark_lines(tmp_path) -> None:
    V, F, _ = make_sheared_map()
    uv = V[:, :2].copy()
    middle = np.flatnonzero(np.abs(V[:, 0]) < 1e-9)
    middle = middle[np.argsort(V[middle, 1])]
    edges = np.column_stack((middle[:-1], middle[1:]))
    images = []
    for seams in (None, edges):
        plotter = plot_checkerboard(V, F, uv, seams=seams, plotter=off_screen(), lighting=False, frequency=7)
        plotter.camera.tight(view="xy", adjust_render_window=False)
        images.append(find_colour(shot(plotter, tmp_path / "board.png"), SEAM))
    assert not images[0].any()
    rows, columns = np.nonzero(images[1])
    assert len(np.unique(rows)) > 380
    assert (abs(columns - 200) < 5).all()
    with pytest.raises(MeshError, match="not edges of the mesh"):
        plot_checkerboard(V, F, uv, seams=[[0, 220]], plotter=off_screen())


def test_seams_of_an_atlas_are_drawn(tmp_path) -> None:
    ball = pv.Icosphere(nsub=3)
    V, F = ball.points.astype(float), ball.regular_faces.astype(np.int64)
    atlas = unwrap(V, F)
    plotter = plot_checkerboard(V, F, atlas, plotter=off_screen(), show_edges=False)
    lines = [a for a in plotter.actors.values() if a.mapper.dataset.n_lines]
    assert [a.mapper.dataset.n_lines for a in lines] == [len(atlas.seams)]
    assert len(plot_checkerboard(V, F, atlas, seams=[], plotter=off_screen()).actors) == 1
    V_cut, F_cut, _ = cut(V, F, atlas.seams)
    compared = plot_compare(V, F, {"linABF": atlas}, off_screen=True, show=False)
    assert find_colour(shot(compared, tmp_path / "atlas.png"), SEAM).sum() > 100
    with pytest.raises(MeshError, match="atlas has"):
        plot_checkerboard(V_cut, F_cut[:-1], atlas, plotter=off_screen())


@pytest.mark.filterwarnings("ignore:the mesh is repaired")
@pytest.mark.parametrize("face", [[1, 1, 2], [11, 12, 13], [13, 13, 14], [0, 0, 0]])
def test_faces_without_area_are_left_out_of_an_atlas_picture(face: list[int]) -> None:
    V, F = igl.icosahedron()
    V = np.vstack((V, [[9, 9, 9], [9, 9, 9], [8, 8, 8.0]]))  # two coincident vertices
    atlas = unwrap(V, [*F.tolist(), face])
    for plot in (plot_checkerboard, plot_distortion):
        drawn = plot(V, [*F.tolist(), face], atlas, plotter=off_screen())
        ends = np.reshape(drawn.bounds, (3, 2)).T
        assert np.allclose(ends, [V[:12].min(axis=0), V[:12].max(axis=0)], atol=0.05)
    assert plot_uv(atlas, atlas.FTC, plotter=off_screen()).actors


def test_a_grid_has_its_cells_on_the_surface_and_in_the_plane(tmp_path) -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    grid = quad_grid(V, F, uv, np.ptp(uv[:, 0]) / 9.5)
    image = shot(plot_grid(grid, flat=True, plotter=off_screen()), tmp_path / "grid.png")
    lines = np.count_nonzero(np.diff(find_colour(image, "black", 60)[200].astype(int)) > 0)
    assert 7 <= lines <= 10
    light, dark = find_colour(image, LIGHT).mean(), find_colour(image, DARK).mean()
    whole = grid.whole.sum() * grid.spacing**2 / (igl.doublearea(uv, F).sum() / 2)
    assert abs(light / (light + dark) - whole) < 0.05
    surface = shot(plot_grid(grid, plotter=off_screen()), tmp_path / "surface.png")
    assert 0.2 < (surface.astype(int).sum(axis=-1) < 720).mean() < 0.95


def test_pictures_follow_the_theme(tmp_path) -> None:
    V, F = load("bumps")
    path = tmp_path / "dark.png"
    theme = pv.themes.DarkTheme()
    options = {"off_screen": True, "window_size": (800, 400), "theme": theme}
    plot_compare(V, F, {"linABF": linabf(V, F)}, screenshot=str(path), **options).close()
    image = read_pixels(path)
    assert find_colour(image, theme.background.hex_rgb).mean() > 0.3
    # the caption has the font colour of the theme
    assert find_colour(image[:40, :400], theme.font.color.hex_rgb, 60).sum() > 100


def test_pictures_are_shown_and_saved_on_demand(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(pv, "OFF_SCREEN", True)
    V, F = load("bumps")
    uv = linabf(V, F)
    path = tmp_path / "shown.png"
    for draw, what in (
        (plot_checkerboard, (V, F, uv)),
        (plot_distortion, (V, F, uv)),
        (plot_uv, (uv, F)),
        (plot_grid, (quad_grid(V, F, uv),)),
    ):
        plotter = draw(*what, show=True, screenshot=str(path))
        image = read_pixels(path)
        path.unlink()
        assert 0.1 < (image[..., :3].astype(int).sum(axis=-1) < 720).mean() < 0.95
        plotter.close()


def test_a_surface_is_seen_from_its_front() -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    for faces, map_ in ((F, uv), (F[:, ::-1], uv * [1, -1])):
        plotter = plot_checkerboard(V, faces, map_)
        normal = igl.per_face_normals(V, faces, np.zeros(3)).sum(axis=0)
        assert normal @ np.array(plotter.camera.direction) < 0
        plotter.close()


def test_a_texture_has_the_period_of_the_atlas() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    atlas = unwrap(V, F, cones=Cones("auto", angles="quarter", period=1 / 50))
    for plotter in (
        plot_checkerboard(V, F, atlas, plotter=off_screen()),
        plot_uv(atlas, atlas.FTC, plotter=off_screen()),
    ):
        mesh = plotter.meshes[0]
        corners = mesh.active_texture_coordinates[mesh.regular_faces]
        np.testing.assert_allclose(corners / 50, atlas.TC[atlas.FTC], atol=1e-6)


def test_cones_are_spheres_and_both_sides_of_a_seam_have_the_same_colour() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    V /= np.linalg.norm(V, axis=1)[:, None]
    atlas = unwrap(V, F, cones=6)
    plotter = plot_checkerboard(V, F, atlas, plotter=off_screen())
    _, lines, balls = plotter.meshes
    assert lines.n_lines == len(atlas.seams)
    pieces = balls.connectivity()
    region = pieces.point_data["RegionId"]
    centres = [pieces.points[region == i].mean(axis=0) for i in range(6)]
    assert region.max() == 5
    assert np.abs(np.sort(centres, axis=0) - np.sort(V[atlas.report.cones], axis=0)).max() < 1e-3
    plotter = plot_uv(atlas, atlas.FTC, plotter=off_screen())
    sides = plotter.meshes[-1]
    assert sides.n_lines == 2 * len(atlas.seams)
    on_surface = np.unique(lines.cell_data["colour"], axis=0, return_counts=True)
    in_map = np.unique(sides.cell_data["colour"], axis=0, return_counts=True)
    assert len(on_surface[0]) > 3
    assert (in_map[0] == on_surface[0]).all() and (in_map[1] == 2 * on_surface[1]).all()
    start, end = sides.points[sides.lines.reshape(-1, 3)[:, 1:].T]
    length = np.linalg.norm(end - start, axis=1)
    for colour in in_map[0]:  # the two sides of each seam edge have the same length
        own = np.sort(length[(sides.cell_data["colour"] == colour).all(axis=1)])
        assert np.allclose(own[0::2], own[1::2], rtol=1e-6)
