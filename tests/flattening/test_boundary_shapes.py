"""Prescribed boundaries: circles, rectangles and angles, and the errors for impossible shapes."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import DISKS, best_fit_distance, bumps, load
from high_curvature import rings
from holed_surfaces import plate
from holed_surfaces import surface as holed
from own_measures import measure_circle_error
from scipy.spatial import Delaunay

import igl_linabf
from igl_linabf import ABF, LinABF, MeshError, abf, compare, flatten, flatten_many, linabf, quality
from igl_linabf.flattening import Outcome
from igl_linabf.surface import Submesh, find_chords, label_face_components, planar_mesh, split_chords

Surface = tuple[np.ndarray, np.ndarray]
SHAPES = ("circle", "rectangle")


def grid(n: int, m: int) -> Surface:
    """Return a flat rectangle of n by m halved unit squares; two of its corners are ears."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(m + 1.0), indexing="ij")
    V = np.column_stack((x.ravel(), y.ravel(), 0 * x.ravel()))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    a, b, c, d = (p * (m + 1) + q for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    return V, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


def rim(V: np.ndarray, F: np.ndarray, i: int = 0) -> np.ndarray:
    mesh = planar_mesh(V, F)
    return mesh.vertices[mesh.topology.loops[i]]


def measure_rectangle_error(uv: np.ndarray, loop: np.ndarray, corners: np.ndarray) -> float:
    """Return the distance of a loop from the upright rectangle with the given corners, by its diagonal."""
    low, high = uv[corners].min(axis=0), uv[corners].max(axis=0)
    distance = np.minimum(np.abs(uv[loop] - low), np.abs(uv[loop] - high)).min(axis=1)
    outside = np.maximum(uv[loop] - high, low - uv[loop]).max()
    return float(max(distance.max(), outside) / np.linalg.norm(high - low))


def sum_angles(uv: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Return the angle sum of the map at each vertex."""
    angle = igl.internal_angles(np.insert(uv, 2, 0.0, axis=1), F)
    return np.bincount(F.ravel(), weights=angle.ravel(), minlength=len(uv))


@pytest.mark.parametrize("name", DISKS)
def test_the_boundary_is_the_circle_or_the_rectangle_without_flips(name: str) -> None:
    # an ear cannot lie along a straight side, and becomes a sliver on a circle
    V, F = split_chords(*load(name))
    loop = rim(V, F)
    for shape in SHAPES:
        result = flatten(V, F, boundary=shape)
        assert result.outcome is Outcome.CONVERGED, (shape, result.message)
        assert quality(V, F, result.uv).flips == 0
        assert result.report.boundary == shape
        if shape == "circle":
            assert measure_circle_error(result.uv[loop]) < 1e-6
        else:
            assert measure_rectangle_error(result.uv, loop, result.report.corners) < 1e-6
            assert result.after.largest < 1e-8
            sums = np.bincount(F.ravel(), weights=result.angles.ravel(), minlength=len(V))
            assert np.abs(sums[result.report.corners] - np.pi / 2).max() < 1e-8
            assert (
                np.abs(
                    np.delete(sums[loop], np.flatnonzero(np.isin(loop, result.report.corners))) - np.pi
                ).max()
                < 1e-8
            )
            inside = np.setdiff1d(np.arange(len(V)), loop)
            assert np.abs(sums[inside] - 2 * np.pi).max() < 1e-8


def test_gauss_bonnet_holds_for_the_angles_of_every_shape() -> None:
    V, F = bumps()
    loop = rim(V, F)
    free = sum_angles(linabf(V, F), F)
    asked = np.full(len(V), np.nan)
    asked[loop] = free[loop] + 0.05 * np.sin(np.arange(len(loop)))
    asked[loop] += ((len(loop) - 2) * np.pi - asked[loop].sum()) / len(loop)
    for shape in ("circle", "rectangle", asked):
        W, G = (V, F) if shape is asked else split_chords(V, F)
        sums = sum_angles(linabf(W, G, boundary=shape), G)
        assert np.abs(sums[np.setdiff1d(np.arange(len(W)), loop)] - 2 * np.pi).max() < 1e-8
        assert abs((np.pi - sums[loop]).sum() - 2 * np.pi) < 1e-8
    assert np.abs(sums[loop] - asked[loop]).max() < 1e-8


def test_angles_can_be_prescribed_at_some_vertices_only() -> None:
    V, F = bumps()
    loop, own = rim(V, F), sum_angles(linabf(*bumps()), bumps()[1])
    asked = np.full(len(V), np.nan)
    asked[loop[:10]] = own[loop[:10]] + 0.1
    result = flatten(V, F, boundary=asked)
    assert result.report.boundary == "angles"
    assert quality(V, F, result.uv).flips == 0
    assert np.abs(sum_angles(result.uv, F) - asked)[loop[:10]].max() < 1e-8


@pytest.mark.parametrize("method", ["linabf", "abf", LinABF(iterations=12), LinABF(solver="direct")])
def test_a_flat_rectangle_is_reproduced(method: str | LinABF) -> None:
    V, F = grid(12, 5)
    rng = np.random.default_rng(0)
    inside = ~np.isin(np.arange(len(V)), rim(V, F))
    V[inside, :2] += 0.2 * rng.uniform(-1, 1, (inside.sum(), 2))
    turned = V @ np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]])
    result = flatten(turned, F, method=method, boundary="rectangle")
    assert sorted(result.report.corners) == [0, 5, 72, 77]
    assert best_fit_distance(result.uv, V[:, :2]) < 1e-6
    assert (
        np.abs(np.ptp(result.uv, axis=0) - [12, 5]).max() < 1e-6
    )  # upright, with the longer side at the bottom


@pytest.mark.parametrize("first", range(4))
def test_the_side_after_the_first_given_corner_points_to_the_right(first: int) -> None:
    V, F = grid(12, 5)
    corners = np.roll([0, 72, 77, 5], -first)
    result = flatten(V, F, boundary="rectangle", corners=corners)
    a, b, c, d = result.uv[corners]
    length, height = (12, 5) if first % 2 == 0 else (5, 12)
    assert np.abs(b - a - [length, 0]).max() < 1e-6 and np.abs(d - a - [0, height]).max() < 1e-6
    assert np.abs(c - d - [length, 0]).max() < 1e-6


def test_an_ear_on_more_than_half_of_a_circle_is_reproduced() -> None:
    """The centre of the circle and the ear lie on the same side of the chord."""
    z = np.append(np.exp(1j * np.deg2rad([0, 110, 200, 280])), 0.55 * np.exp(1j * np.deg2rad(275)))
    V = np.column_stack((z.real, z.imag, 0 * z.real))
    F = np.array([[0, 1, 2], [0, 2, 4], [2, 3, 4], [3, 0, 4]])
    assert best_fit_distance(linabf(V, F, boundary="circle"), V[:, :2]) < 1e-9


def test_a_flat_disk_is_reproduced_on_a_circle() -> None:
    V, F = rings(20, lambda z: 0 * z.real)
    assert best_fit_distance(linabf(V, F, boundary="circle"), V[:, :2]) < 1e-6


def test_a_flat_disk_with_ears_is_reproduced_on_a_circle() -> None:
    rng = np.random.default_rng(1)
    at = np.sort(rng.uniform(0, 2 * np.pi, 24)) + np.array(
        [[0.0], [0.03], [0.01]]
    )  # corners, ears, and ears that are attached to ears
    z = np.concatenate((np.exp(1j * at).ravel(), 0.2 * rng.normal(size=(8, 2)) @ [1, 1j]))
    V = np.column_stack((z.real, z.imag, 0 * z.real))
    kept = np.r_[:24, 72:80]
    i = np.arange(5, 12)
    layers = [(i, 24 + i, i + 1), (i, 48 + i, 24 + i)]
    F = np.concatenate((kept[Delaunay(V[kept, :2]).simplices], *(np.column_stack(layer) for layer in layers)))
    F = F[np.argsort(rng.uniform(size=len(F)))]
    used = np.unique(F)
    V, F = V[used], np.searchsorted(used, F)
    apex = int(np.flatnonzero(np.bincount(F.ravel()) == 1)[0])
    assert best_fit_distance(linabf(V, F, boundary="circle"), V[:, :2]) < 1e-6
    pinned = linabf(V, F, [apex, 7], [[0, 0], [1, 0]], boundary="circle")
    assert np.abs(pinned[[apex, 7]] - [[0, 0], [1, 0]]).max() < 1e-12
    assert measure_circle_error(pinned[rim(V, F)]) < 1e-12


@pytest.mark.parametrize("method", ["linabf", "abf"])
def test_ears_on_a_circle_do_not_flip_or_change_the_map_of_other_faces(method: str) -> None:
    V, F = load("disk__igl_snail.obj")
    ears = (np.bincount(F.ravel())[F] == 1).any(axis=1)
    assert np.count_nonzero(ears) == 2
    used = np.unique(F[~ears])
    whole = flatten(V, F, method=method, boundary="circle")
    rest = flatten(V[used], np.searchsorted(used, F[~ears]), method=method, boundary="circle")
    assert quality(V, F, whole.uv).flips == 0
    assert measure_circle_error(whole.uv[rim(V, F)]) < 1e-6
    assert best_fit_distance(whole.uv[used], rest.uv) < 1e-9 * np.ptp(rest.uv)
    assert np.abs(whole.angles[~ears] - rest.angles).max() == 0
    assert np.abs(whole.angles.sum(axis=1) - np.pi).max() < 1e-9


def test_ragged_disks_are_mapped_to_a_circle_or_the_message_names_a_remedy() -> None:
    rng, mapped = np.random.default_rng(0), 0
    for _ in range(30):
        points = rng.uniform(-1, 1, (int(rng.integers(30, 600)), 2))
        F, height = Delaunay(points).simplices, rng.uniform(0, 1)
        V = np.column_stack(
            (points, height * np.sin(rng.uniform(1, 4) * points[:, 0]) * np.cos(3 * points[:, 1]))
        )
        at = points[F].mean(axis=1)
        F = F[np.abs(np.sin(3 * at[:, 0] + rng.uniform(0, 6)) + at[:, 1]) < rng.uniform(0.5, 2)]
        if len(F) < 4:
            continue
        label = label_face_components(F, len(V))
        V, F, *_ = igl.remove_unreferenced(V, F[label == np.bincount(label).argmax()])
        try:
            result = flatten(V, F, boundary="circle")
        except MeshError:
            continue  # the part is not a disk, because some faces share only a vertex
        mapped += 1
        if result.outcome is not Outcome.CONVERGED:
            assert "split_chords" in result.message
            V, F = split_chords(V, F)
            result = flatten(V, F, boundary="circle")
        assert result.outcome is Outcome.CONVERGED and measure_circle_error(result.uv[rim(V, F)]) < 1e-6
    assert mapped > 15


def test_the_rectangle_has_the_given_corners() -> None:
    V, F = split_chords(*bumps())
    loop = rim(V, F)
    corners = loop[[5, 12, 30, 41]]
    result = flatten(V, F, boundary="rectangle", corners=corners[[1, 3, 2, 0]])
    # the report lists the corners in the order of the loop, starting at the first given corner
    assert result.report.corners.tolist() == np.roll(corners, -1).tolist()
    assert measure_rectangle_error(result.uv, loop, result.report.corners) < 1e-6
    low = result.uv.min(axis=0)
    assert np.abs(result.uv[result.report.corners[0]] - low).max() < 1e-9 * np.ptp(result.uv)


@pytest.mark.parametrize("shape", SHAPES)
def test_pins_move_the_shape_as_a_whole(shape: str) -> None:
    V, F = split_chords(*bumps())
    ends, places = [3, 40], [[0.0, 0.0], [0.0, 2.0]]
    free, pinned = (flatten(V, F, *pins, boundary=shape) for pins in ((), (ends, places)))
    assert np.abs(pinned.uv[[3, 40]] - places).max() < 1e-12
    scale = np.linalg.norm(free.uv[3] - free.uv[40]) / 2
    assert best_fit_distance(pinned.uv * scale, free.uv) < 1e-9


@pytest.mark.parametrize("shape", SHAPES)
def test_maps_do_not_depend_on_rigid_motion_scale_or_numbering(shape: str) -> None:
    V, F = split_chords(*bumps())
    uv = linabf(V, F, boundary=shape)
    rng = np.random.default_rng(3)
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    Q *= np.sign(np.linalg.det(Q))
    order = rng.permutation(len(V))
    G = np.argsort(order)[F][rng.permutation(len(F))]
    moved = linabf(7.0 * V[order] @ Q.T + 3.0, G, boundary=shape)
    assert best_fit_distance(moved / 7.0, uv[order]) < 1e-5 * np.ptp(uv)  # the inner solver stops at 1e-6


@pytest.mark.parametrize("shape", SHAPES)
def test_converged_abf_has_the_shape_and_the_least_change_of_angles(shape: str) -> None:
    V, F = split_chords(*load("disk__flipfree_camelhead_small.obj"))
    loop = rim(V, F)
    linear, least = flatten(V, F, boundary=shape), flatten(V, F, method=ABF(tol=1e-7), boundary=shape)
    assert least.outcome is Outcome.CONVERGED
    assert least.after.largest < 1e-6
    assert quality(V, F, least.uv).angle_distortion < 1.001 * quality(V, F, linear.uv).angle_distortion
    off = (
        measure_circle_error(least.uv[loop])
        if shape == "circle"
        else measure_rectangle_error(least.uv, loop, least.report.corners)
    )
    assert off < 1e-6


@pytest.mark.parametrize("name", ["wavy plate", "hemisphere", "crown"])
def test_holes_can_be_mapped_to_circles_as_well(name: str) -> None:
    V, F = holed(name)
    result = flatten(V, F, boundary="circles")
    assert result.outcome is Outcome.CONVERGED, result.message
    assert quality(V, F, result.uv).flips == 0
    for i in range(len(result.holes) + 1):
        assert measure_circle_error(result.uv[rim(V, F, i)]) < 1e-6


@pytest.mark.parametrize("shape", SHAPES)
def test_with_holes_the_outer_loop_has_the_shape(shape: str) -> None:
    V, F = plate(5, 0.15)
    result = flatten(V, F, boundary=shape)
    loop = rim(V, F)
    assert result.outcome is Outcome.CONVERGED and quality(V, F, result.uv).flips == 0
    off = (
        measure_circle_error(result.uv[loop])
        if shape == "circle"
        else measure_rectangle_error(result.uv, loop, result.report.corners)
    )
    assert off < 1e-6
    assert max(hole.largest for hole in result.holes) < 1e-6


def test_an_ear_on_a_straight_side_is_named_and_its_chord_can_be_split() -> None:
    V, F = grid(6, 4)
    loop = rim(V, F)  # the ears of the grid are vertices 4 and 30, both at corners
    assert 4 in loop and 30 in loop
    with pytest.raises(MeshError, match=r"vertices 30 .* ears, with one face.*split_chords"):
        linabf(V, F, boundary="rectangle", corners=[0, 2, 34, 4])
    W, G = split_chords(V, F)
    assert (W[: len(V)] == V).all() and len(W) == len(V) + 2
    assert not len(find_chords(Submesh.from_input(W, G).topology))
    assert abs(igl.doublearea(W, G).sum() - igl.doublearea(V, F).sum()) < 1e-12
    result = flatten(W, G, boundary="rectangle", corners=[0, 2, 34, 4])
    assert quality(W, G, result.uv).flips == 0
    assert measure_rectangle_error(result.uv, rim(W, G), result.report.corners) < 1e-6


def test_a_part_cut_off_from_a_straight_side_is_named() -> None:
    V, F = grid(6, 4)
    ear = int(np.flatnonzero((F == 30).any(axis=1))[0])
    a, b, c = F[ear]
    V = np.vstack((V, V[F[ear]].mean(axis=0)))  # vertex 30 has two faces, both cut off by one edge
    F = np.vstack((np.delete(F, ear, axis=0), [[a, b, 35], [b, c, 35], [c, a, 35]]))
    with pytest.raises(MeshError, match=r"edges between boundary vertices \[25, 31\] cut off .*split_chords"):
        linabf(V, F, boundary="rectangle", corners=[0, 2, 34, 4])
    W, G = split_chords(V, F)
    assert quality(W, G, linabf(W, G, boundary="rectangle", corners=[0, 2, 34, 4])).flips == 0


def test_every_pattern_of_split_sides_keeps_the_surface() -> None:
    V = np.array([[0.0, 0, 0], [2, 0, 0], [1, 2, 0], [1, -1, 0], [3, 2, 0], [-1, 2, 0]])
    for n in (2, 3, 4):  # a triangle with one to three ears at its sides
        F = np.array([[0, 1, 2], [1, 0, 3], [2, 1, 4], [0, 2, 5]])[:n]
        W, G = split_chords(V[: F.max() + 1], F)
        assert len(G) == n + 2 * (n - 1)
        assert not len(find_chords(Submesh.manifold_from_input(W, G).topology))
        assert (np.cross(W[G[:, 1]] - W[G[:, 0]], W[G[:, 2]] - W[G[:, 0]])[:, 2] > 0).all()
        assert abs(igl.doublearea(W, G).sum() - igl.doublearea(V, F).sum()) < 1e-12


def test_impossible_angle_sums_are_refused_with_the_correct_sum() -> None:
    V, F = bumps()
    loop, m = rim(V, F), len(rim(V, F))
    angles = np.full(len(V), np.nan)

    def refused(match: str, **values: object) -> None:
        with pytest.raises(MeshError, match=match):
            flatten(V, F, **({"boundary": angles} | values))

    angles[loop] = np.pi
    refused(rf"sum to {m * np.pi:.6f} rad.* \({m} - 2\) pi = {(m - 2) * np.pi:.6f}: add {-2 * np.pi / m:.6f}")
    angles[loop[0]] = -0.5
    refused(r"angles of -0.5 rad at vertices .*positive")
    angles[loop[:2]] = np.nan  # the other angles leave a sum of -pi for these two vertices
    angles[loop[2:]] = np.pi * (1 + 1 / (m - 2))
    refused(r"which leaves -3.14\d* for the free vertices")
    angles[loop] = np.nan
    angles[np.setdiff1d(np.arange(len(V)), loop)[:2]] = 6.0
    refused(r"inside the mesh: set them to NaN")
    refused(r"shape \(3,\): pass one angle per vertex", boundary=[1.0, 2.0, 3.0])
    refused(r"neither a name nor an array", boundary=[["a"]])
    inside = int(np.setdiff1d(np.arange(len(V)), loop)[0])
    refused(rf"corners {inside} are not on the outer", boundary="rectangle", corners=[inside, *loop[:3]])
    refused(r"four different vertices", boundary="rectangle", corners=[*loop[:3], loop[0]])
    refused(r"not all within", boundary="rectangle", corners=[*loop[:3], len(V)])
    for options, match in (
        ({"boundary": "square"}, "use one of 'free'"),
        ({"boundary": "circle", "corners": loop[:4]}, "corners does not apply"),
        ({"boundary": "circle", "method": "lscm"}, "'lscm' has a free boundary"),
    ):
        with pytest.raises(ValueError, match=match):
            flatten(V, F, **options)


def test_the_guarantee_keeps_the_shape() -> None:
    V, F = grid(80, 3)  # on a circle, the ends of the strip are too small for double precision
    result = flatten(V, F, method=LinABF(guarantee="injective"), boundary="circle")
    assert quality(V, F, result.uv).flips == 0
    assert result.report.layout == "embedding"
    assert measure_circle_error(result.uv[rim(V, F)]) < 1e-6


def test_compare_and_flatten_many_take_shapes() -> None:
    V, F = split_chords(*bumps())
    loop = rim(V, F)
    table = compare(V, F, ("lscm", "linabf", "abf"), repeat=1, others=False, boundary="circle")
    assert [measure_circle_error(uv[loop]) < 1e-6 for uv in table.maps.values()] == [False, True, True]
    many = flatten_many([(V, F), igl.icosahedron()], boundary="circle", errors="return")
    assert np.array_equal(many[0].uv, linabf(V, F, boundary="circle"))
    assert isinstance(many[1], MeshError)


def test_a_single_triangle_takes_every_possible_shape() -> None:
    V, F = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])
    assert best_fit_distance(abf(V, F, boundary="circle"), V[:, :2]) < 1e-9
    asked = [np.pi / 3] * 3
    sides = np.linalg.norm(np.diff(linabf(V, F, boundary=asked), axis=0, append=0), axis=1)
    assert igl_linabf.quality(V, F, linabf(V, F, boundary=asked)).flips == 0
    assert len(sides) == 3
    with pytest.raises(MeshError, match="four corners"):
        linabf(V, F, boundary="rectangle")


@pytest.mark.filterwarnings("ignore::igl_linabf.FallbackWarning")
def test_converged_abf_on_a_circle_falls_back_to_linear_abf_beyond_double_precision() -> None:
    V, F = load("disk__igl_camel_b.obj")
    made = flatten(V, F, method="abf", boundary="circle")
    assert made.outcome is Outcome.NOT_CONVERGED and "this is the map of linear ABF" in str(made)
    assert [attempt.name for attempt in made.report.attempts] == [
        "converged abf",
        "feasible abf",
        "active set",
    ]
    linear = linabf(V, F, boundary="circle")
    assert quality(V, F, made.uv).flips == 0 and np.allclose(made.uv, linear, atol=1e-6 * np.ptp(linear))
