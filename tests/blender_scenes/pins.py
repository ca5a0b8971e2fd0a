"""Pinned texture coordinates do not change."""

from __future__ import annotations

import bpy
import numpy as np
from helpers import (
    assert_refused,
    grid,
    new_object,
    pin,
    polygon_areas,
    select_only,
    set_scene,
    unwrap,
    uv_of,
)

METHODS = "isometric", "linabf", "abf", "lscm"


def two_grids() -> bpy.types.Object:
    """Return two separate bumpy squares in one object."""
    one = grid(8, bump=0.3)
    V = np.array([vertex.co for vertex in one.data.vertices])
    F = np.array([list(face.vertices) for face in one.data.polygons])
    return new_object("grids", np.vstack((V, np.add(V, (3, 0, 0)))), np.vstack((F, F + len(V))))


def corner_loops(obj: bpy.types.Object, vertices: list[int]) -> np.ndarray:
    """Return all corners at the given vertices."""
    return np.array([loop.index for loop in obj.data.loops if loop.vertex_index in vertices])


def assert_apart(uv: np.ndarray, first: slice, second: slice) -> None:
    """Assert that the faces of two ranges of corners do not overlap in the map."""
    import shapely

    one, other = (shapely.union_all(shapely.polygons(uv[part].reshape(-1, 4, 2))) for part in (first, second))
    assert one.intersection(other).area < 1e-9


def test_pins_stay_and_their_chart_follows_without_flips() -> None:
    for method in METHODS:
        obj = two_grids()
        set_scene(obj)
        corners = {0: (0.1, 0.1), 8: (0.1, 0.42), 80: (0.45, 0.4), 72: (0.4, 0.12)}
        loops = corner_loops(obj, list(corners))
        goal = np.array([corners[obj.data.loops[i].vertex_index] for i in loops])
        pin(obj, loops, goal)
        assert unwrap(method=method) == {"FINISHED"}
        uv, half = uv_of(obj), len(obj.data.loops) // 2
        assert np.array_equal(uv[loops], goal.astype(np.float32)), method
        assert (polygon_areas(obj) > 0).all()
        assert np.unique(np.column_stack((uv[:half], loops_vertices(obj)[:half])), axis=0).shape[0] == 81
        assert uv.min() >= 0
        assert uv.max() <= 1
        assert_apart(uv, slice(0, half), slice(half, None))
        areas = polygon_areas(obj)
        # both squares have the same texel density
        assert np.isclose(areas[:64].sum(), areas[64:].sum(), rtol=0.1)


def loops_vertices(obj: bpy.types.Object) -> np.ndarray:
    return np.array([loop.vertex_index for loop in obj.data.loops])


def test_two_pins_place_a_chart_and_one_pin_translates_it() -> None:
    for pins in ({0: (0.2, 0.3)}, {0: (0.2, 0.3), 80: (0.5, 0.5)}):
        obj = grid(8)
        set_scene(obj)
        loops = corner_loops(obj, list(pins))
        pin(obj, loops, np.array([pins[obj.data.loops[i].vertex_index] for i in loops]))
        assert unwrap() == {"FINISHED"}
        areas = polygon_areas(obj)
        assert np.allclose(areas, areas[0], rtol=1e-3)  # a flat square keeps its shape
        if len(pins) == 2:
            assert np.isclose(areas.sum(), (0.3**2 + 0.2**2) / 2, rtol=1e-3)
        assert np.allclose(uv_of(obj)[loops[0]], (0.2, 0.3))


def test_a_completely_pinned_island_is_locked_and_others_are_packed_beside_it() -> None:
    obj = two_grids()
    set_scene(obj)
    assert unwrap(margin=8) == {"FINISHED"}
    half = len(obj.data.loops) // 2
    locked = uv_of(obj)[:half] * 0.7
    locked[:, 0] = 0.7 - locked[:, 0]  # mirrored, unlike the map of any method
    pin(obj, np.arange(half), locked)
    for seams in ("MARKED", "FOUND"):
        assert unwrap(seams=seams, margin=8) == {"FINISHED"}
        uv = uv_of(obj)
        assert np.array_equal(uv[:half], locked.astype(np.float32))
        assert_apart(uv, slice(0, half), slice(half, None))
        assert (polygon_areas(obj)[64:] > 0).all()
    pin(obj, np.arange(2 * half))
    assert_refused("all UVs are pinned")


def test_charts_without_room_go_to_the_next_tile() -> None:
    obj = two_grids()
    set_scene(obj)
    square = np.array([vertex.co[:2] for vertex in obj.data.vertices])[loops_vertices(obj)]
    half = len(square) // 2
    pin(obj, np.arange(half), (square[:half] + 1) / 2)
    assert unwrap() == {"FINISHED"}
    uv = uv_of(obj)
    assert uv[half:, 0].min() >= 1
    assert uv[half:, 0].max() <= 2


def test_pins_at_two_places_of_one_point_are_refused() -> None:
    obj = grid(4)
    set_scene(obj)
    loops = corner_loops(obj, [12])  # the middle vertex, where four faces meet
    pin(obj, loops, np.array([[0.1, 0.1], [0.1, 0.1], [0.8, 0.1], [0.1, 0.1]]))
    assert_refused("mark the seam there, or unpin one side")


def test_pins_outside_the_selection_and_of_other_layers_do_not_matter() -> None:
    obj = grid(6, bump=0.2)
    obj.data.uv_layers.new(name="UVMap")
    obj.data.uv_layers.new(name="Lightmap")
    set_scene(obj)
    pin(obj, np.arange(100, 144))
    select_only(obj, np.arange(36) < 18)
    assert unwrap(layer="SECOND") == {"FINISHED"}
    assert unwrap() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert (polygon_areas(obj)[:18] > 0).all()
    assert np.isclose(uv_of(obj)[:72].max(), 1, atol=0.01)  # the whole square is used


def test_pins_that_force_flips_stay_and_are_reported() -> None:
    obj = grid(6)
    set_scene(obj)
    place = {8: (0.6, 0.5), 10: (0.4, 0.5), 0: (0.1, 0.1), 6: (0.1, 0.9), 42: (0.9, 0.1), 48: (0.9, 0.9)}
    loops = corner_loops(obj, list(place))
    goal = np.array([place[obj.data.loops[i].vertex_index] for i in loops])
    pin(obj, loops, goal)
    assert unwrap(method="lscm") == {"FINISHED"}
    assert np.array_equal(uv_of(obj)[loops], goal.astype(np.float32))
    assert not (polygon_areas(obj) > 0).all()
    assert all(face.select for face in obj.data.polygons)
    mirrored = grid(6)  # its boundary is pinned in clockwise order
    set_scene(mirrored)
    rim = {i: (1 - i // 7 / 6, i % 7 / 6) for i in range(49) if {i // 7, i % 7} & {0, 6}}
    loops = corner_loops(mirrored, list(rim))
    pin(mirrored, loops, np.array([rim[mirrored.data.loops[i].vertex_index] for i in loops]))
    assert_refused("mirror", method="linabf")
