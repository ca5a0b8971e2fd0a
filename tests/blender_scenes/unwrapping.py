"""Whole objects: seams, layers, scales, textures and modifiers."""

from __future__ import annotations

import runpy
from pathlib import Path

import bpy
import numpy as np
from helpers import (
    assert_refused,
    covered_shape,
    monkey,
    polygon_areas,
    prism,
    seams_of,
    set_scene,
    unwrap,
    uv_of,
)


def test_found_seams_are_marked_and_unwrapping_along_them_again_keeps_them() -> None:
    obj = monkey()
    set_scene(obj)
    assert unwrap(seams="FOUND") == {"FINISHED"}
    found, first = seams_of(obj), uv_of(obj)
    assert found
    assert (polygon_areas(obj) > 0).all()
    assert first.min() >= 0
    assert first.max() <= 1
    # both maps may differ: with found seams, charts are laid out before they are split; along marked seams,
    # each chart is flattened separately
    assert unwrap(seams="MARKED", extend=False) == {"FINISHED"}
    assert seams_of(obj) == found
    own = uv_of(obj)
    assert (polygon_areas(obj) > 0).all()
    assert unwrap(seams="MARKED", extend=False) == {"FINISHED"}
    assert seams_of(obj) == found
    assert np.allclose(uv_of(obj), own, atol=1e-5)


def test_several_objects_share_the_square_and_other_layers_stay() -> None:
    objects = monkey(), prism()
    objects[1].data.uv_layers.new(name="lightmap")
    objects[1].data.uv_layers.new(name="texture").active = True
    before = uv_of(objects[1], "lightmap")
    set_scene(*objects)
    assert unwrap(seams="FOUND", method="isometric") == {"FINISHED"}
    assert np.array_equal(uv_of(objects[1], "lightmap"), before)
    assert objects[1].data.uv_layers.active.name == "texture"
    areas = [polygon_areas(obj) for obj in objects]
    assert all((area > 0).all() for area in areas)
    real = [sum(face.area for face in obj.data.polygons) for obj in objects]
    # both objects have the same texel density
    assert np.isclose(areas[0].sum() / real[0], areas[1].sum() / real[1], rtol=0.1)
    first, second = (covered_shape(obj) for obj in objects)
    assert first.distance(second) > 1 / 1024


def test_only_selected_faces_change_in_edit_mode() -> None:
    obj = monkey()
    bpy.ops.object.mode_set(mode="OBJECT")
    before = uv_of(obj)
    set_scene(obj, edit=True)
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    chosen = np.arange(len(obj.data.polygons)) < 40
    obj.data.polygons.foreach_set("select", chosen)
    bpy.ops.object.mode_set(mode="EDIT")
    assert unwrap(seams="FOUND") == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH"
    bpy.ops.object.mode_set(mode="OBJECT")
    loops = np.repeat(chosen, [face.loop_total for face in obj.data.polygons])
    assert np.array_equal(uv_of(obj)[~loops], before[~loops])
    assert not np.allclose(uv_of(obj)[loops], before[loops])


def test_mirrored_and_scaled_objects_are_unwrapped_by_their_shape_in_the_world() -> None:
    plain, mirrored = prism(), prism()
    mirrored.scale = (-1.0, 1.0, 1.0)
    set_scene(plain)
    unwrap(seams="FOUND")
    expected = np.sort(polygon_areas(plain))
    set_scene(mirrored)
    bpy.context.view_layer.update()
    assert unwrap(seams="FOUND") == {"FINISHED"}
    assert np.allclose(np.sort(polygon_areas(mirrored)), expected, rtol=1e-4)
    stretched = prism()
    stretched.scale = (1.0, 1.0, 3.0)
    set_scene(stretched)
    bpy.context.view_layer.update()
    unwrap(seams="FOUND", method="isometric")
    area = polygon_areas(stretched)
    hexagon, side = area[:2].mean(), area[2:].mean()
    assert np.isclose(
        side / hexagon, 6.0 / (1.5 * np.sqrt(3)), rtol=0.05
    )  # the prism has sides of 1 x 6 and hexagons of side 1


def test_modifiers_that_keep_the_vertices_count_and_others_are_refused() -> None:
    obj = prism()
    obj.modifiers.new("cast", "CAST").factor = 0.7
    set_scene(obj)
    unwrap(seams="FOUND", modifiers=False)
    base = uv_of(obj)
    assert unwrap(seams="FOUND", modifiers=True) == {"FINISHED"}
    assert not np.allclose(uv_of(obj), base, atol=1e-3)
    obj.modifiers.new("bevel", "BEVEL")
    assert_refused("(cast, bevel) remove or reorder vertices", modifiers=True)
    assert not [attribute.name for attribute in obj.data.attributes if "linabf" in attribute.name]


def test_a_subdivided_cage_gets_even_texels_on_the_smooth_surface() -> None:
    obj = monkey()
    set_scene(obj)
    unwrap(seams="FOUND")
    obj.modifiers.new("mirror", "MIRROR").use_axis = (False, False, False)
    subdivision = obj.modifiers.new("subdivision", "SUBSURF")
    subdivision.levels, subdivision.uv_smooth = 2, "NONE"
    spread = {}
    for modifiers in (False, True):
        assert unwrap(modifiers=modifiers) == {"FINISHED"}
        assert (polygon_areas(obj) > 0).all()
        spread[modifiers] = texel_spread(obj)
    assert spread[True] < 0.85 * spread[False]


def texel_spread(obj: bpy.types.Object) -> float:
    """Return the standard deviation of the log texel density on the surface after all modifiers."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    area = np.array([face.area for face in mesh.polygons])
    density = np.log(np.abs(polygon_areas(mesh=mesh)) / area)
    evaluated.to_mesh_clear()
    mean = np.average(density, weights=area)
    return float(np.sqrt(np.average((density - mean) ** 2, weights=area)))


def test_a_second_layer_is_created_and_the_first_is_kept() -> None:
    obj = monkey()
    set_scene(obj)
    before, active = uv_of(obj), obj.data.uv_layers.active.name
    assert unwrap(seams="FOUND", layer="SECOND") == {"FINISHED"}
    assert [layer.name for layer in obj.data.uv_layers] == [active, "Lightmap"]
    assert np.array_equal(uv_of(obj, active), before)
    assert obj.data.uv_layers.active.name == active
    second = uv_of(obj, "Lightmap")
    assert not np.allclose(second, before)
    assert unwrap(seams="FOUND", layer="SECOND", method="linabf") == {"FINISHED"}
    assert len(obj.data.uv_layers) == 2
    assert not np.allclose(uv_of(obj, "Lightmap"), second)


def test_a_texture_that_is_not_square_keeps_the_shapes() -> None:
    obj = prism()
    set_scene(obj)
    assert unwrap(seams="FOUND", method="isometric", resolution=2048, height=1024) == {"FINISHED"}
    assert uv_of(obj).max() <= 1
    areas = polygon_areas(obj)
    # areas in texels are proportional to areas in space: 1 x 2 rectangles, and a hexagon of side 1
    assert np.isclose(areas[2:].mean() / areas[:2].mean(), 2.0 / (1.5 * np.sqrt(3)), rtol=0.05)
    uv = uv_of(obj)[obj.data.polygons[2].loop_start :][:4] * [2048, 1024]
    sides = np.linalg.norm(uv - np.roll(uv, -1, axis=0), axis=1)
    assert np.isclose(max(sides) / min(sides), 2.0, rtol=0.05)


def test_undo_restores_the_map_and_the_seams() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    before = uv_of(monkey())
    bpy.ops.ed.undo_push(message="before")
    assert unwrap(seams="FOUND") == {"FINISHED"}
    assert seams_of(bpy.data.objects[0])
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert np.array_equal(uv_of(bpy.data.objects[0]), before)
    assert not seams_of(bpy.data.objects[0])


def test_faults_are_reported_and_selected() -> None:
    obj = prism()
    obj.data.vertices[3].co = (float("nan"), 0.0, 0.0)
    set_scene(obj)
    assert_refused("prism: 3 faces have a vertex without a position", seams="FOUND")
    chosen = {face.index for face in obj.data.polygons if face.select}
    assert chosen == {face.index for face in obj.data.polygons if 3 in face.vertices}
    set_scene(prism(), edit=True)
    bpy.ops.mesh.select_all(action="DESELECT")
    assert_refused("no faces are selected", seams="FOUND")
    bpy.ops.object.mode_set(mode="OBJECT")
    obj = prism()
    obj.data.edges[0].use_seam = True
    set_scene(obj)
    assert_refused("Extend Seams", seams="MARKED", extend=False)  # a closed body with too few seams
    assert_refused("padding is 64 texels", seams="FOUND", resolution=128, margin=64)


def test_marked_seams_are_completed_and_kept() -> None:
    obj = prism(12)
    obj.data.edges[0].use_seam = True
    set_scene(obj)
    assert unwrap(seams="MARKED", extend=True) == {"FINISHED"}
    assert 0 in seams_of(obj)
    assert len(seams_of(obj)) > 1
    assert (polygon_areas(obj) > 0).all()


def test_cones_end_the_seams_of_a_closed_body() -> None:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
    obj = bpy.context.active_object
    set_scene(obj)
    assert unwrap(seams="FOUND", cones=6, method="linabf") == {"FINISHED"}
    assert (polygon_areas(obj) > 0).all()
    loose = [0] * len(obj.data.vertices)
    for edge in obj.data.edges:
        for vertex in edge.vertices if edge.use_seam else ():
            loose[vertex] += 1
    assert loose.count(1) <= 6  # the seams are a tree whose leaves are cones
    assert_refused("needs the method Linear ABF or ABF", seams="FOUND", cones=6)
    assert_refused("cannot respect Hide Seams", seams="FOUND", cones=6, method="abf", hide="BACK")


def test_the_margin_is_in_texels() -> None:
    gaps = []
    for margin in (2, 24):
        obj = monkey()
        set_scene(obj)
        unwrap(seams="FOUND", margin=margin, resolution=256)
        gaps.append(polygon_areas(obj).sum())
    assert gaps[0] > gaps[1]


def test_the_recipe_writes_the_layer_of_the_active_object() -> None:
    obj = monkey()
    set_scene(obj)
    recipe = Path(__file__).parents[2] / "recipes" / "blender_python.py"
    runpy.run_path(str(recipe))  # the recipe contains assertions
    assert (np.abs(polygon_areas(bpy.context.active_object)) > 0).all()
