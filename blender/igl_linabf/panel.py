"""Add panels to the sidebars of the 3D view and of the UV editor, and entries to the UV menus."""

from __future__ import annotations

import bpy

from .operators import UV_OT_linabf_unwrap
from .settings import copy_settings, draw


class _Panel:
    bl_label = "Linear ABF"
    bl_category = "UV"
    bl_region_type = "UI"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return UV_OT_linabf_unwrap.poll(context)

    def draw(self, context: bpy.types.Context) -> None:
        chosen = context.scene.linabf
        draw(self.layout, chosen)
        copy_settings(chosen, self.layout.operator(UV_OT_linabf_unwrap.bl_idname, text="Unwrap"))


class VIEW3D_PT_linabf(_Panel, bpy.types.Panel):
    bl_space_type = "VIEW_3D"


class IMAGE_PT_linabf(_Panel, bpy.types.Panel):
    bl_space_type = "IMAGE_EDITOR"


CLASSES = VIEW3D_PT_linabf, IMAGE_PT_linabf
MENUS = "VIEW3D_MT_uv_map", "IMAGE_MT_uvs_unwrap"


def _draw_entry(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    copy_settings(context.scene.linabf, menu.layout.operator(UV_OT_linabf_unwrap.bl_idname))


def register() -> None:
    for panel_class in CLASSES:
        bpy.utils.register_class(panel_class)
    for name in MENUS:
        getattr(bpy.types, name).append(_draw_entry)


def unregister() -> None:
    for name in MENUS:
        getattr(bpy.types, name).remove(_draw_entry)
    for panel_class in reversed(CLASSES):
        bpy.utils.unregister_class(panel_class)
