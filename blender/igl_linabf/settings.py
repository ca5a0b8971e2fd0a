"""Settings of the panel, for the next unwrap, and of the operator, for the last unwrap."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

METHODS = (
    ("linabf", "Linear ABF", "Keeps angles; the fastest without flips"),
    ("abf", "ABF", "Keeps angles as well as they can be"),
    ("isometric", "Isometric", "Keeps lengths: even checks everywhere, for textures"),
    ("lscm", "LSCM", "Blender's conformal method, for comparison"),
)
SEAMS = (
    ("MARKED", "Marked", "Cut along the edges that are marked as seams"),
    ("FOUND", "Found", "Find seams, and mark them as seams, so that you can edit them"),
)
LAYERS = (
    ("ACTIVE", "Active", "Write into the active UV map"),
    ("SECOND", "Second", "Write into the second UV map, as lightmaps need it; the first one stays"),
)
PROPERTIES = {
    "method": EnumProperty(name="Method", items=METHODS, default="linabf"),
    "seams": EnumProperty(name="Seams", items=SEAMS, default="MARKED"),
    "extend": BoolProperty(
        name="Extend Seams",
        description="Find and mark the seams that the marked ones leave missing: on closed pieces, handles, "
        "and where the stretch is large",
        default=True,
    ),
    "trade": FloatProperty(
        name="Trade",
        description="Larger: longer seams for less stretch. 0: the shortest seams",
        default=6.0,
        min=0.0,
        soft_max=60.0,
    ),
    "cones": IntProperty(
        name="Cones",
        description="End the seams of closed surfaces at this many cones, so that both sides of each seam "
        "are equally long; 0: no cones",
        default=0,
        min=0,
        soft_max=64,
    ),
    "margin": IntProperty(
        name="Margin", description="Texels between charts", default=2, min=0, soft_max=64, subtype="PIXEL"
    ),
    "resolution": IntProperty(
        name="Texture Size",
        description="Width of the texture, in texels, for which the margin is",
        default=1024,
        min=16,
        soft_max=16384,
        subtype="PIXEL",
    ),
    "height": IntProperty(
        name="Height",
        description="Of the texture, where it is not square; 0: as its width",
        default=0,
        min=0,
        soft_max=16384,
        subtype="PIXEL",
    ),
    "layer": EnumProperty(name="UV Map", items=LAYERS, default="ACTIVE"),
    "modifiers": BoolProperty(
        name="Use Modifiers",
        description="Unwrap the shape that the modifiers make, as long as they keep the vertices",
        default=False,
    ),
}


class LinabfSettings(bpy.types.PropertyGroup):
    """The settings of the panel, stored in the scene."""

    __annotations__ = dict(PROPERTIES)


def draw(layout: bpy.types.UILayout, chosen: object) -> None:
    """Draw the settings as rows of a panel."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(chosen, "method")
    layout.prop(chosen, "seams", expand=True)
    if chosen.seams == "MARKED":
        layout.prop(chosen, "extend")
    layout.prop(chosen, "trade")
    if chosen.seams == "FOUND":
        layout.prop(chosen, "cones")
    column = layout.column(align=True)
    column.prop(chosen, "margin")
    column.prop(chosen, "resolution")
    column.prop(chosen, "height")
    layout.prop(chosen, "layer")
    layout.prop(chosen, "modifiers")


def register() -> None:
    bpy.utils.register_class(LinabfSettings)
    bpy.types.Scene.linabf = PointerProperty(type=LinabfSettings)


def unregister() -> None:
    del bpy.types.Scene.linabf
    bpy.utils.unregister_class(LinabfSettings)
