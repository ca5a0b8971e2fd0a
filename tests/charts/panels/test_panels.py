"""On surfaces with creases, seams follow creases, and developable surfaces are flattened exactly."""

from __future__ import annotations

import warnings

import igl
import numpy as np
import pytest
from conftest import load
from hard_surfaces import DEVELOPABLE, MACHINED, ROUNDED, box, pipe, plate_with_holes, rock, rounded_box
from nasty_meshes import concatenate_surfaces

from igl_linabf import Atlas, ChartOptions, MeshError, OutcomeWarning, Packing, cut, find_seams, unwrap
from igl_linabf.charts.seams import SeamSearch


def is_seam(edges: np.ndarray, atlas: Atlas) -> np.ndarray:
    """Return a mask of the edges, (#E, 2), that are seams."""
    seams = {tuple(pair) for pair in np.sort(atlas.seams, axis=1).tolist()}
    return np.array([tuple(pair) in seams for pair in np.sort(edges, axis=1).tolist()])


@pytest.mark.parametrize("charts", [None, ChartOptions(hide=[0, 0, -1]), ChartOptions(repair_overlaps=True)])
@pytest.mark.parametrize("name", DEVELOPABLE)
def test_surfaces_with_a_net_are_flattened_without_distortion(name: str, charts: ChartOptions | None) -> None:
    V, F = DEVELOPABLE[name]()
    atlas = unwrap(V, F, charts=charts)
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.01
    assert atlas.quality.conformal_distortion < 1.01
    assert atlas.quality.area_distortion < 0.01


@pytest.mark.parametrize("shape", [(4, 3, 0.1), (1, 1, 1), (1, 2, 3)])
def test_a_box_opens_on_the_side_that_hides_its_seams(shape: tuple[float, float, float]) -> None:
    V, F = box(*shape, 2)
    edges, _, sides = igl.edge_flaps(F)[:3]
    across = igl.per_face_normals(V, F, np.zeros(3))[sides]
    for axis in (*np.eye(3), *-np.eye(3)):
        atlas = unwrap(V, F, find_seams(V, F, hide=axis), charts=ChartOptions(hide=axis))
        on_seam = is_seam(edges, atlas)
        around = (across @ axis).min(axis=1) < -0.5, (across @ axis).max(axis=1) > 0.5
        shown, hidden = (
            np.linalg.norm(V[edges[on_seam & side, 0]] - V[edges[on_seam & side, 1]], axis=1).sum()
            for side in around
        )
        assert shown <= hidden * (1 + 1e-9)
        assert (
            shown < 1e-9 or np.ptp(V @ axis) > 1.5 * np.ptp(V, axis=0).min()
        )  # a long box has visible seams along its long sides; all other boxes have none


@pytest.mark.parametrize("charts", [None, ChartOptions(trade=30), ChartOptions(keep_holes=True)])
@pytest.mark.parametrize("holes", [[], [(0, 2, 0.4)], [(0, 1, 0.4), (1, 3, 0.5), (-2, 2, 0.6)]])
def test_the_seam_of_a_pipe_is_straight_and_passes_beside_its_holes(
    holes: list[tuple[float, float, float]], charts: ChartOptions | None
) -> None:
    V, F = pipe(holes)
    atlas = unwrap(V, F, charts=charts)
    assert len(atlas.charts) == 1 and atlas.quality.stretch_l2 < 1 + 1e-6
    assert np.ptp(V[atlas.seams][:, :, :2], axis=(0, 1)).max() < 1e-9
    assert np.isclose(atlas.seam_length, 4)
    of_holes = [loop for loop in igl.boundary_loop_all(F) if np.ptp(V[loop, 2]) > 0]
    assert len(of_holes) == len(holes)
    assert not np.isin(atlas.seams, np.concatenate([[], *of_holes])).any()


def test_hundreds_of_holes_of_a_pipe_are_joined_by_seams() -> None:
    """The memory for a map grows with the number of uncut holes."""
    around, rows = 144, 73
    V, F = pipe([], around, rows)
    column, row = np.arange(len(F)) % around, np.arange(len(F)) // around % (rows - 1)
    V, F = igl.remove_unreferenced(V, F[(column % 8 != 3) | (row % 4 != 1)])[:2]
    holes = igl.boundary_loop_all(F)
    assert len(holes) > 302
    atlas = unwrap(V, F, packing=Packing(cut_below=0))
    assert atlas.good and len(atlas.charts) == 1
    assert all(np.isin(loop, atlas.seams).any() for loop in holes)


def test_the_cost_of_a_seam_through_a_hole_is_the_price_of_its_edges() -> None:
    V, F = pipe([(0, 2, 0.5)])
    line = np.flatnonzero(np.isclose(V[:, 1], 0) & (V[:, 0] > 0))
    through = [pair for pair in igl.edges(F).tolist() if set(pair) <= set(line.tolist())]
    atlas = unwrap(V, F, through, packing=Packing(cut_below=0))
    size = np.sqrt(igl.doublearea(V, F).sum() / 2)
    assert np.isclose(atlas.cost.seams, atlas.seam_length / size / ChartOptions().trade, rtol=0.05)


@pytest.mark.parametrize(("method", "conformal"), [("linabf", 1.005), ("isometric", 1.02)])
def test_planes_and_cylinders_of_a_machine_part_are_flattened_isometrically(
    method: str, conformal: float
) -> None:
    V, F = load("closed__igl_fandisk.off")
    atlas = unwrap(V, F, method=method)
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.005
    assert atlas.quality.conformal_distortion < conformal


@pytest.mark.parametrize("height", [0.01, 2, 40])
def test_fine_boxes_in_single_precision_are_one_net(height: float) -> None:
    V, F = box(1, 1, height, 4)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    atlas = unwrap((V @ turn * np.sign(np.linalg.det(turn))).astype(np.float32), F)
    assert atlas.good
    assert len(atlas.charts) == 1
    assert max(atlas.quality.stretch_l2, atlas.quality.conformal_distortion) < 1.001


def test_many_open_boxes_and_tents_are_cut_to_their_nets_in_one_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rng, parts = np.random.default_rng(0), []
    tent = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]])
    V, F = box(1, 1, 1, 1)
    for _ in range(40):
        keep = ~(V[F][:, :, 2] == V[:, 2].min()).all(axis=1)
        parts.append((V * rng.uniform(0.5, 2, 3), F[keep]))
        parts.append((tent * rng.uniform(0.8, 2, 3), np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])))
    searches = []
    found = SeamSearch.find_seams
    monkeypatch.setattr(SeamSearch, "find_seams", lambda *a: searches.append(a) or found(*a))
    atlas = unwrap(*concatenate_surfaces(*parts))
    assert atlas.good
    assert len(searches) == 1
    assert atlas.quality.stretch_l2 < 1.001
    assert atlas.quality.conformal_distortion < 1.001


def test_an_open_plate_among_other_pieces_is_cut_to_its_net() -> None:
    V, F = box(8, 0.1, 2, 1)
    plate = F[~(V[F][:, :, 2] == V[:, 2].min()).all(axis=1)]  # a disk whose map has an L2 stretch of 6
    leaf = np.array([[0, 0, 9.0], [1, 0, 9], [0, 1, 9]])
    V_all = np.vstack((V, *(leaf + 2.0 * k for k in range(12))))
    leaves = len(V) + np.arange(36).reshape(-1, 3)
    for faces in (plate, np.vstack((plate, leaves))):
        atlas = unwrap(V_all, faces)
        assert atlas.good
        assert max(chart.quality.stretch_l2 for chart in atlas.charts) < 1.001
        assert len(atlas.charts) < len(faces) - len(plate) + 3


@pytest.mark.parametrize("name", ["cuboid", "pencil", "cylinder", "plate with holes", "rounded box"])
def test_find_seams_returns_the_seams_along_which_unwrap_cuts(name: str) -> None:
    V, F = (DEVELOPABLE | ROUNDED)[name]()
    seams = find_seams(V, F)
    found, made = ({tuple(edge) for edge in np.sort(e, axis=1).tolist()} for e in (seams, unwrap(V, F).seams))
    if unwrap(V, F, seams).fill > 0.5:
        assert made == found
    else:
        assert made >= found  # charts may be cut further to fill the page


@pytest.mark.parametrize("keep_holes", [False, True])
def test_planes_keep_their_holes(keep_holes: bool) -> None:
    V, F = plate_with_holes(6)
    atlas = unwrap(V, F, charts=ChartOptions(keep_holes=keep_holes))
    assert atlas.good
    assert sum(len(chart.result.holes) for chart in atlas.charts) == 2 * 6
    assert max(atlas.quality.stretch_l2, atlas.quality.conformal_distortion) < 1.001


def make_similar_surfaces(V: np.ndarray, F: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """Return a surface moved and scaled, renumbered, and in single precision, each with its scale."""
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    order = rng.permutation(len(V))
    place = np.argsort(order)
    return [
        (1e3 * V @ turn + 50, F, 1e3),
        (V[order], place[F][rng.permutation(len(F))][:, [1, 2, 0]], 1),
        (V.astype(np.float32), F, 1),
    ]


def test_a_net_does_not_depend_on_position_size_or_numbering() -> None:
    V, F = box(1, 1.3, 2, 2)
    length = unwrap(V, F).seam_length
    for V_other, F_other, scale in make_similar_surfaces(V, F):
        atlas = unwrap(V_other, F_other)
        assert atlas.quality.stretch_l2 < 1.001
        assert atlas.seam_length == pytest.approx(scale * length, rel=1e-5)


def test_a_plate_is_cut_along_sharp_creases_and_once_along_each_tube() -> None:
    V, F = plate_with_holes(12)
    atlas = unwrap(V, F)
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.001
    # two planes and twelve tubes; most tubes are merged with a plane
    assert 1 < len(atlas.charts) < 2 * 12 + 2
    edges, _, sides = igl.edge_flaps(F)[:3]
    normal = igl.per_face_normals(V, F, np.zeros(3))
    bend = np.arccos(np.clip((normal[sides[:, 0]] * normal[sides[:, 1]]).sum(axis=1), -1, 1))
    degrees = np.rad2deg(bend[is_seam(edges, atlas)])
    assert np.count_nonzero((degrees > 1) & (degrees < 40)) <= 12
    assert not np.count_nonzero(degrees < 1)


@pytest.mark.filterwarnings("ignore::igl_linabf.FallbackWarning")  # SCAF fails on long strips
@pytest.mark.parametrize("repair_overlaps", [False, True])
@pytest.mark.parametrize("name", ROUNDED)
def test_a_body_is_cut_along_its_fillets_and_flattened_nearly_exactly(
    name: str, repair_overlaps: bool
) -> None:
    V, F = ROUNDED[name]()
    atlas = unwrap(V, F, charts=ChartOptions(repair_overlaps=repair_overlaps))
    assert atlas.good
    assert not atlas.quality.overlaps
    assert atlas.quality.stretch_l2 < 1.005
    # moving parts of a map apart shears the map
    assert atlas.quality.conformal_distortion < (1.08 if repair_overlaps else 1.03)
    area, normal = igl.doublearea(V, F), igl.per_face_normals(V, F, np.zeros(3))
    edges, _, sides = igl.edge_flaps(F)[:3]
    a, b = sides.T
    in_plane = (normal[a] * normal[b]).sum(axis=1) > 1 - 1e-9
    large = in_plane & (area[[a, b]].min(axis=0) > 0.02 * area.sum())
    assert not is_seam(edges[large], atlas).any()


def test_a_rounded_box_becomes_the_net_of_the_box_in_any_position() -> None:
    V, F = rounded_box(3, 2, 1, 0.1)
    shortest = 4 * 1 + 2 * 2 + 3  # seven edges of the box
    for V_other, F_other, scale in [(V, F, 1), *make_similar_surfaces(V, F)]:
        atlas = unwrap(V_other, F_other)
        assert len(atlas.charts) == 1
        assert atlas.quality.stretch_l2 < 1.005
        assert atlas.seam_length < 1.25 * scale * shortest


def test_a_small_trade_cuts_a_body_with_fillets_as_a_smooth_one() -> None:
    V, F = ROUNDED["rounded plate, finer"]()
    # the page is so large that no chart is cut to fill it
    options = {"method": "linabf", "packing": Packing(resolution=2048, texel_density=1)}
    many, few = (unwrap(V, F, charts=ChartOptions(trade=trade), **options) for trade in (6, 0.05))
    assert few.good
    assert few.seam_length < many.seam_length / 2
    assert len(few.charts) == 1


@pytest.mark.filterwarnings("ignore:.* edges are cut in addition to the given seams")
@pytest.mark.parametrize("name", ["pial", "nut", "double_torus", "ball", "ant", "cuboid, fine"])
def test_given_seams_are_extended(name: str) -> None:
    V, F = DEVELOPABLE[name]() if name in DEVELOPABLE else load(name)
    found = find_seams(V, F)
    for mine in (found[:0], F[:1, :2], found[: len(found) // 3], ring(V, F)):
        atlas = unwrap(V, F, mine, charts=ChartOptions(extend=True))
        assert atlas.good
        assert atlas.quality.stretch_l2 < 1.5
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OutcomeWarning)
            try:
                alone = unwrap(V, F, mine)
            except MeshError as refused:
                assert "extend=True" in str(refused)
            else:
                stretched = any(chart.quality.stretch_l2 > 10 for chart in alone.charts)
                assert bool(alone.troubles) >= stretched


def ring(V: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Return the edges between the faces above and below the median height."""
    above = V[F].mean(axis=1)[:, 2] > np.median(V[:, 2])
    sides = [np.sort(F[part][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1) for part in (above, ~above)]
    upper, lower = ({tuple(pair) for pair in side.tolist()} for side in sides)
    return np.array(sorted(upper & lower))


def test_a_net_is_the_shortest_tree_through_the_corners() -> None:
    V, F = box(1, 1, 2, 2)
    a, b = V[find_seams(V, F).T]
    # the net cuts six short edges and a long one
    assert np.linalg.norm(a - b, axis=1).sum() == pytest.approx(8)
    assert len(igl.boundary_loop_all(cut(V, F, find_seams(V, F))[1])) == 1


@pytest.mark.parametrize("roughness", [0.4, 0.6])
def test_facets_of_a_subdivided_body_are_not_cut_apart(roughness: float) -> None:
    coarse = unwrap(*rock(roughness))
    for times in (1, 2):
        fine = unwrap(*rock(roughness, times))
        assert len(fine.charts) == len(coarse.charts)
        assert fine.seam_length < 1.3 * coarse.seam_length


@pytest.mark.parametrize("name", ["washer", "bevelled disk", "rounded plate, finer"])
@pytest.mark.parametrize("packing", [None, Packing(resolution=1024, padding=4)])
def test_flat_faces_keep_their_holes_fillets_and_chamfers(name: str, packing: Packing | None) -> None:
    V, F = (ROUNDED | MACHINED)[name]()
    atlas = unwrap(V, F, packing=packing)
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.001
    top = np.ptp(V[:, 2]) / 2 - 1e-9 < np.abs(V[:, 2] - (V[:, 2].min() + V[:, 2].max()) / 2)
    edges, _, sides = igl.edge_flaps(F)[:3]
    beside_plane = top[F].all(axis=1)[sides].any(axis=1)
    assert not is_seam(edges[beside_plane & top[edges].any(axis=1)], atlas).any() or name == "bevelled disk"
    assert sum(len(chart.result.holes) for chart in atlas.charts) == (0 if name == "bevelled disk" else 2)
