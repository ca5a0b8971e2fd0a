"""Choice of the faces to unwrap: selections, objects in edit mode, instances, and linked objects."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np
from helpers import (
    assert_refused,
    cut_edges,
    grid,
    monkey,
    new_object,
    polygon_areas,
    prism,
    seams_of,
    select_only,
    set_scene,
    unwrap,
    uv_of,
)


def sphere() -> bpy.types.Object:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    return bpy.context.active_object


def test_only_selected_faces_change_in_edit_mode() -> None:
    obj = monkey()
    set_scene(obj)
    before = uv_of(obj)
    chosen = np.arange(len(obj.data.polygons)) < 40
    select_only(obj, chosen)
    assert unwrap(seams="FOUND") == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH"
    bpy.ops.object.mode_set(mode="OBJECT")
    loops = np.repeat(chosen, [face.loop_total for face in obj.data.polygons])
    assert np.array_equal(uv_of(obj)[~loops], before[~loops])
    assert not np.allclose(uv_of(obj)[loops], before[loops])


def test_seams_are_marked_exactly_where_the_map_is_cut_also_around_a_selection() -> None:
    for chosen in (slice(None), slice(0, 500)):
        obj = sphere()
        obj.data.edges.foreach_set("use_seam", np.arange(len(obj.data.edges)) % 7 == 0)
        set_scene(obj)
        assert unwrap(seams="FOUND") == {"FINISHED"}
        assert seams_of(obj) == cut_edges(obj)
        mask = np.zeros(len(obj.data.polygons), dtype=bool)
        mask[chosen] = True
        select_only(obj, mask)
        assert unwrap(seams="FOUND") == {"FINISHED"}
        bpy.ops.object.mode_set(mode="OBJECT")
        faces_at = {}
        for face in obj.data.polygons:
            for key in face.edge_keys:
                faces_at.setdefault(key, []).append(mask[face.index])
        edges = {edge.index: faces_at[edge.key] for edge in obj.data.edges}
        border = {edge for edge, inside in edges.items() if any(inside) and not all(inside)}
        inner = {edge for edge, inside in edges.items() if all(inside)}
        assert len(border) == (0 if chosen == slice(None) else len(border))
        assert border <= seams_of(obj)
        assert seams_of(obj) & inner == cut_edges(obj) & inner


def test_marked_seams_outside_the_selection_do_not_matter() -> None:
    plain = grid(6, bump=0.3)
    set_scene(plain)
    chosen = np.arange(36) < 18
    select_only(plain, chosen)
    assert unwrap() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    loops = np.repeat(chosen, 4)
    expected = uv_of(plain)[loops]
    obj = grid(6, bump=0.3)
    n = len(obj.data.vertices)
    obj.data.vertices.add(2)
    obj.data.edges.add(1)
    obj.data.edges[-1].vertices = (n, n + 1)  # a loose edge
    outside = {key for face in obj.data.polygons[24:] for key in face.edge_keys} | {(n, n + 1)}
    for edge in obj.data.edges:
        edge.use_seam = edge.key in outside
    set_scene(obj)
    hidden = np.arange(36) >= 30
    select_only(obj, chosen)
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.polygons.foreach_set("hide", hidden)
    bpy.ops.object.mode_set(mode="EDIT")
    assert unwrap() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.allclose(uv_of(obj)[loops], expected, atol=1e-6)
    assert unwrap() == {"FINISHED"}  # in object mode, all faces are unwrapped, in spite of the loose edge


def test_complete_marked_seams_stay_the_only_ones() -> None:
    obj = sphere()
    set_scene(obj)
    unwrap(seams="FOUND", trade=0.0)  # the seam is a single path from pole to pole
    path = seams_of(obj)
    assert unwrap() == {"FINISHED"}
    assert seams_of(obj) == path
    assert cut_edges(obj) <= path
    assert unwrap(extend=True, trade=30.0) == {"FINISHED"}
    assert seams_of(obj) > path
    obj.data.edges.foreach_set("use_seam", np.zeros(len(obj.data.edges), dtype=bool))
    assert unwrap() == {"FINISHED"}  # seams are found, because none are marked
    assert seams_of(obj)


def test_an_empty_selection_is_reported() -> None:
    obj = prism()
    set_scene(obj)
    obj.select_set(False)
    assert_refused("no mesh object is selected", seams="FOUND")
    empty = new_object("empty", np.zeros((1, 3)), [])
    set_scene(empty)
    assert_refused("the objects have no faces", seams="FOUND")


def test_other_selected_objects_stay_in_object_mode() -> None:
    edited, other, unselected = prism(), monkey(), prism(5)
    bpy.ops.object.select_all(action="DESELECT")
    set_scene(edited, other, unselected)
    before = uv_of(other)
    for obj in (other, unselected):
        obj.select_set(False)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    other.select_set(True)
    edited.select_set(False)
    assert unwrap(seams="FOUND") == {"FINISHED"}
    assert [obj.mode for obj in (edited, other, unselected)] == ["EDIT", "OBJECT", "OBJECT"]
    assert [obj.select_get() for obj in (edited, other, unselected)] == [False, True, False]
    assert bpy.context.active_object is edited
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(uv_of(other), before)


def test_instances_share_a_map_at_the_scale_of_the_largest() -> None:
    small, rival = prism(), prism()
    rival.scale = (2.0, 2.0, 2.0)
    large = bpy.data.objects.new("large", small.data)
    large.scale = (4.0, 4.0, 4.0)
    set_scene(small, rival, large)
    bpy.context.view_layer.update()
    large.select_set(False)
    for same in (True, False):
        assert unwrap(seams="FOUND") == {"FINISHED"}
        ratio = polygon_areas(small).sum() / polygon_areas(rival).sum()
        assert np.isclose(ratio, (4 / 2) ** 2 if same else (8 / 2) ** 2, rtol=0.02)
        if same:  # in the second round, the largest instance is part of an instanced collection
            collection = bpy.data.collections.new("instanced")
            collection.objects.link(bpy.data.objects.new("hidden", small.data))
            instancer = bpy.data.objects.new("instancer", None)
            instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
            instancer.scale = (8.0, 8.0, 8.0)
            bpy.context.scene.collection.objects.link(instancer)
            bpy.context.view_layer.update()


def test_linked_meshes_are_left_out_and_reported() -> None:
    path = str(Path(tempfile.mkdtemp()) / "library.blend")
    bpy.data.libraries.write(path, {prism(7).data})
    with bpy.data.libraries.load(path, link=True) as (there, here):
        here.meshes = there.meshes
    linked = bpy.data.objects.new("linked", here.meshes[0])
    own = prism()
    set_scene(linked)
    assert_refused("linked is linked from another file", seams="FOUND")
    assert not linked.data.uv_layers
    set_scene(linked, own)
    assert unwrap(seams="FOUND") == {"FINISHED"}
    assert not linked.data.uv_layers
    assert (polygon_areas(own) > 0).all()
