"""Tests of the extension in the Python of Blender: `python blender_scenes.py EXTENSION.zip`.

The script installs the extension with its wheels from the archive, runs all test functions, and prints the
failures as JSON.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Any

os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="igl_linabf-blender-")

import bpy
import numpy as np


def set_scene(*objects: bpy.types.Object, edit: bool = False) -> None:
    """Remove all other objects from the scene, select these, and make the first one active."""
    for obj in list(bpy.context.scene.collection.objects):
        if obj not in objects:
            bpy.data.objects.remove(obj)
    for obj in objects:
        if obj.name not in bpy.context.scene.collection.objects:
            bpy.context.scene.collection.objects.link(obj)
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]
    if edit:
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")


def new_object(name: str, V: object, F: object) -> bpy.types.Object:
    data = bpy.data.meshes.new(name)
    data.from_pydata(np.asarray(V).tolist(), [], [list(row) for row in F])
    return bpy.data.objects.new(name, data)


def monkey() -> bpy.types.Object:
    """Return Suzanne: 500 triangles and quadrangles in three pieces."""
    bpy.ops.mesh.primitive_monkey_add()
    return bpy.context.active_object


def prism(sides: int = 6) -> bpy.types.Object:
    """Return a closed prism with an n-gon at each end."""
    turn = np.arange(sides) * 2 * np.pi / sides
    ring = np.column_stack((np.cos(turn), np.sin(turn)))
    V = np.vstack([np.column_stack((ring, np.full(sides, z))) for z in (0.0, 2.0)])
    quads = [[i, (i + 1) % sides, sides + (i + 1) % sides, sides + i] for i in range(sides)]
    return new_object("prism", V, [list(range(sides))[::-1], list(range(sides, 2 * sides)), *quads])


def uv_of(obj: bpy.types.Object, layer: str | None = None) -> np.ndarray:
    uv_layer = obj.data.uv_layers[layer] if layer else obj.data.uv_layers.active
    values = np.empty(2 * len(obj.data.loops), dtype=np.float32)
    uv_layer.uv.foreach_get("vector", values)
    return values.reshape(-1, 2).astype(float)


def polygon_areas(obj: bpy.types.Object) -> np.ndarray:
    """Return the signed areas of the faces in the map."""
    uv, areas = uv_of(obj), []
    for face in obj.data.polygons:
        x, y = uv[face.loop_start : face.loop_start + face.loop_total].T
        areas.append((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)
    return np.array(areas)


def covered_shape(obj: bpy.types.Object) -> Any:
    """Return the union of the faces in the map, as a shape of shapely, which the extension includes."""
    import shapely

    uv = uv_of(obj)
    faces = [uv[face.loop_start : face.loop_start + face.loop_total] for face in obj.data.polygons]
    return shapely.union_all([shapely.Polygon(corners).buffer(0) for corners in faces])


def seams_of(obj: bpy.types.Object) -> set[int]:
    return {edge.index for edge in obj.data.edges if edge.use_seam}


def unwrap(**settings: object) -> set[str]:
    return bpy.ops.uv.linabf_unwrap(**settings)


def test_found_seams_are_marked_and_unwrapping_along_them_again_keeps_them() -> None:
    obj = monkey()
    set_scene(obj)
    assert unwrap(seams="FOUND") == {"FINISHED"}
    found, first = seams_of(obj), uv_of(obj)
    assert found
    assert (polygon_areas(obj) > 0).all()
    assert first.min() >= 0
    assert first.max() <= 1
    # the first map keeps the layout of charts that were cut further; along marked seams, each chart is
    # flattened
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
    assert np.isclose(areas[0].sum() / real[0], areas[1].sum() / real[1], rtol=0.1)  # one scale
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


def test_a_mirrored_object_and_one_with_a_scale() -> None:
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
    )  # 1 x 6 rectangles, and a hexagon of side 1


def test_modifiers_that_keep_the_vertices_count_and_others_are_refused() -> None:
    obj = prism()
    obj.modifiers.new("cast", "CAST").factor = 0.7
    set_scene(obj)
    unwrap(seams="FOUND", modifiers=False)
    base = uv_of(obj)
    assert unwrap(seams="FOUND", modifiers=True) == {"FINISHED"}
    assert not np.allclose(uv_of(obj), base, atol=1e-3)
    obj.modifiers.new("subdivision", "SUBSURF")
    assert_refused("vertices of 12", modifiers=True)


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
    assert unwrap(seams="FOUND", layer="SECOND", method="isometric") == {"FINISHED"}
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
    assert_refused("prism: 3 faces have a vertex at no place", seams="FOUND")
    chosen = {face.index for face in obj.data.polygons if face.select}
    assert chosen == {face.index for face in obj.data.polygons if 3 in face.vertices}
    set_scene(prism(), edit=True)
    bpy.ops.mesh.select_all(action="DESELECT")
    assert_refused("no faces are selected", seams="FOUND")
    bpy.ops.object.mode_set(mode="OBJECT")
    set_scene(prism())
    assert_refused("Extend Seams", seams="MARKED", extend=False)  # a closed body without seams


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
    assert unwrap(seams="FOUND", cones=6) == {"FINISHED"}
    assert (polygon_areas(obj) > 0).all()
    loose = [0] * len(obj.data.vertices)
    for edge in obj.data.edges:
        for vertex in edge.vertices if edge.use_seam else ():
            loose[vertex] += 1
    assert loose.count(1) <= 6  # the seams are a tree whose leaves are cones


def test_the_margin_is_in_texels() -> None:
    gaps = []
    for margin in (2, 24):
        obj = monkey()
        set_scene(obj)
        unwrap(seams="FOUND", margin=margin, resolution=256)
        gaps.append(polygon_areas(obj).sum())
    assert gaps[0] > gaps[1]


def test_the_panel_passes_its_settings_on() -> None:
    chosen = bpy.context.scene.linabf
    chosen.method, chosen.trade = "isometric", 3.0
    assert bpy.types.VIEW3D_PT_linabf.poll(bpy.context)
    names = set(bpy.ops.uv.linabf_unwrap.get_rna_type().properties.keys()) - {"rna_type"}
    assert names == set(chosen.bl_rna.properties.keys()) - {"rna_type", "name"}


def test_the_recipe_writes_the_layer_of_the_active_object() -> None:
    obj = monkey()
    set_scene(obj)
    recipe = Path(__file__).parents[1] / "recipes" / "blender_python.py"
    runpy.run_path(str(recipe))  # the recipe contains assertions
    assert (np.abs(polygon_areas(bpy.context.active_object)) > 0).all()


def assert_refused(text: str, **settings: object) -> None:
    """Assert that the operator reports an error with this text, which Blender raises in Python."""
    try:
        unwrap(**settings)
    except RuntimeError as error:
        assert text in str(error), str(error)
        return
    raise AssertionError(f"not refused: {text}")


def main() -> int:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(
        filepath=sys.argv[1], repo="user_default", enable_on_install=True
    )
    failed = {}
    tests = {name: function for name, function in globals().items() if name.startswith("test_")}
    for name, function in tests.items():
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            function()
        except BaseException:
            failed[name] = traceback.format_exc()
    print(json.dumps({"run": list(tests), "failed": failed}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
