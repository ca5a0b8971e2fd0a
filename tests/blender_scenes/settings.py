"""The panel, the menu entry, and the settings that choose seams and scales."""

from __future__ import annotations

import bpy
import numpy as np
from helpers import cut_edges, monkey, polygon_areas, prism, seams_of, set_scene, unwrap, uv_of

OPERATOR = bpy.ops.uv.linabf_unwrap


class Layout:
    """A stand-in for Blender's layout that records the items of a panel."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.buttons: list[object] = []

    def row(self, **options: object) -> Layout:
        return self

    column = row

    def prop(self, owner: object, name: str, **options: object) -> None:
        self.names.append(owner.bl_rna.properties[name].name)

    def separator(self) -> None:
        pass

    def operator(self, name: str, **options: object) -> object:
        self.buttons.append(type("Button", (), {})())
        return self.buttons[-1]


def test_the_panel_and_the_menu_entry_pass_the_settings_on() -> None:
    chosen = bpy.context.scene.linabf
    chosen.method, chosen.trade, chosen.seams = "abf", 3.0, "FOUND"
    assert bpy.types.VIEW3D_PT_linabf.poll(bpy.context)
    known = set(OPERATOR.get_rna_type().properties.keys()) - {"rna_type"}
    assert known == set(chosen.bl_rna.properties.keys()) - {"rna_type", "name"}
    layout = Layout()
    owner = type("Owner", (), {"layout": layout})()
    bpy.types.VIEW3D_PT_linabf.draw(owner, bpy.context)
    for entry in bpy.types.VIEW3D_MT_uv_map.draw._draw_funcs:
        if "linabf" in entry.__module__:
            entry(owner, bpy.context)
    assert len(layout.buttons) == 2
    for button in layout.buttons:
        assert vars(button) == {name: getattr(chosen, name) for name in known}
    for name in known:
        chosen.property_unset(name)


def test_artists_find_the_settings_by_their_names_and_isometric_first() -> None:
    layout, chosen = Layout(), bpy.context.scene.linabf
    for seams in ("FOUND", "MARKED"):
        chosen.seams = seams
        bpy.types.VIEW3D_PT_linabf.draw(type("Owner", (), {"layout": layout})(), bpy.context)
    expected = {"Method", "Seams", "Extend Seams", "Seam Length", "Matching Seams", "Texture Size"}
    expected |= {"Texture Height", "Texel Density", "Maximum Stretch", "Hide Seams", "Keep Materials"}
    expected |= {"Margin", "UV Map", "Use Modifiers"}
    assert set(layout.names) == expected
    methods = chosen.bl_rna.properties["method"]
    assert methods.enum_items[0].identifier == methods.default == "isometric"
    assert not chosen.bl_rna.properties["extend"].default


def test_charts_do_not_cross_materials_on_request() -> None:
    crossed = {}
    for keep in (False, True):
        obj = prism(12)
        for name in ("one", "two"):
            obj.data.materials.append(bpy.data.materials.new(name))
        material = np.arange(14) % 4 // 2
        obj.data.polygons.foreach_set("material_index", material)
        set_scene(obj)
        assert unwrap(seams="FOUND", keep_materials=keep) == {"FINISHED"}
        between = set()
        for edge in obj.data.edges:
            at = [material[face.index] for face in obj.data.polygons if edge.key in face.edge_keys]
            between |= {edge.index} if len(set(at)) > 1 else set()
        crossed[keep] = between - cut_edges(obj)
        assert cut_edges(obj) == seams_of(obj)
    assert crossed[False]
    assert not crossed[True]


def test_maximum_stretch_cuts_further() -> None:
    n_seams = []
    for limit in (10.0, 1.005):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
        obj = bpy.context.active_object
        set_scene(obj)
        assert unwrap(seams="FOUND", max_stretch=limit) == {"FINISHED"}
        n_seams.append(len(seams_of(obj)))
    assert n_seams[1] > n_seams[0]


def test_seams_are_hidden_on_the_chosen_side_of_the_world() -> None:
    # rotated and mirrored spheres, because `hide` refers to the axes of the world, not of the object
    for scale, turn in (((1, 1, 1), 0.0), ((1, 1, 1), 2.0), ((-1, 1, 1), 2.0)):
        for hide, axis, sign in (("+Y", 1, 1), ("-X", 0, -1), ("+X", 0, 1)):
            bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
            obj = bpy.context.active_object
            obj.scale, obj.rotation_euler = scale, (0.0, 0.0, turn)
            set_scene(obj)
            bpy.context.view_layer.update()
            assert unwrap(seams="FOUND", hide=hide) == {"FINISHED"}
            ends = [v for edge in seams_of(obj) for v in obj.data.edges[edge].vertices]
            at = np.array([obj.matrix_world @ obj.data.vertices[v].co for v in ends])
            assert (sign * at[:, axis] > -0.3).all(), (scale, turn, hide)


def test_texel_density_sets_the_scale_and_continues_on_udim_tiles() -> None:
    obj = monkey()
    set_scene(obj)
    assert unwrap(seams="FOUND", resolution=1024, texel_density=100.0) == {"FINISHED"}
    real = sum(face.area for face in obj.data.polygons)
    assert np.isclose(np.sqrt(polygon_areas(obj).sum() / real) * 1024, 100.0, rtol=0.01)
    assert uv_of(obj).max() <= 1
    assert unwrap(seams="FOUND", resolution=1024, texel_density=600.0) == {"FINISHED"}
    assert uv_of(obj).max() > 1
    assert (polygon_areas(obj) > 0).all()
