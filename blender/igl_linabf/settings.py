"""Define the settings of the panel, for the next unwrap, and of the operator, for the last unwrap."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

NO_STRETCH_LIMIT = 10.0  # value of the setting Maximum Stretch that means no limit

METHODS = (
    ("isometric", "Isometric", "Keep lengths and areas: even checks everywhere, for textures"),
    ("linabf", "Linear ABF", "Keep angles; the fastest method without flips"),
    ("abf", "ABF", "Keep angles as well as possible"),
    ("lscm", "LSCM", "Blender's conformal method, for comparison"),
)
SEAMS = (
    (
        "MARKED",
        "Marked",
        "Cut along the edges that are marked as seams; a closed body without any gets found seams",
    ),
    ("FOUND", "Found", "Find seams, and mark them as Blender's seams, which can then be edited"),
)
HIDE = (
    ("NOWHERE", "Anywhere", "Seams may lie anywhere"),
    ("BACK", "On the Back", "On the side of each body with the least detail, such as the back of a head"),
    ("+Y", "+Y (behind)", "On faces that look to +Y, away from the front view"),
    ("-Y", "-Y (in front)", "On faces that look to -Y"),
    ("+X", "+X", "On faces that look to +X"),
    ("-X", "-X", "On faces that look to -X"),
    ("-Z", "-Z (below)", "On faces that look down"),
    ("+Z", "+Z (on top)", "On faces that look up"),
)
LAYERS = (
    ("ACTIVE", "Active", "Write to the active UV map"),
    ("SECOND", "Second", "Write to the second UV map, for lightmaps; the first one is not changed"),
)
PROPERTIES = {
    "method": EnumProperty(name="Method", items=METHODS, default="isometric"),
    "seams": EnumProperty(name="Seams", items=SEAMS, default="MARKED"),
    "extend": BoolProperty(
        name="Extend Seams",
        description="Add and mark the seams that the marked ones lack: on closed pieces and handles, and "
        "where the stretch is large",
        default=False,
    ),
    "trade": FloatProperty(
        name="Seam Length",
        description="Larger values: longer seams and less stretch. 0: the shortest seams",
        default=6.0,
        min=0.0,
        soft_max=60.0,
    ),
    "hide": EnumProperty(
        name="Hide Seams", description="Where seams that are found lie if possible", items=HIDE
    ),
    "max_stretch": FloatProperty(
        name="Maximum Stretch",
        description="Cut charts until the stretch of each is at most this value: 1 is none, 1.1 is a tenth. "
        f"{NO_STRETCH_LIMIT:g}: no limit, stretch is only weighed against the length of seams",
        default=NO_STRETCH_LIMIT,
        min=1.0,
        max=NO_STRETCH_LIMIT,
        soft_max=2.0,
        step=1,
    ),
    "keep_materials": BoolProperty(
        name="Keep Materials",
        description="Put faces of different materials into different charts",
        default=False,
    ),
    "cones": IntProperty(
        name="Matching Seams",
        description="Make both sides of each seam of a closed surface equally long, so that tiling textures "
        "match: end the seams at this number of points. 0: off. Needs the method Linear ABF or ABF",
        default=0,
        min=0,
        soft_max=64,
    ),
    "margin": IntProperty(
        name="Margin", description="Texels between charts", default=2, min=0, soft_max=64, subtype="PIXEL"
    ),
    "resolution": IntProperty(
        name="Texture Size",
        description="Width of the texture in texels, to which the margin refers",
        default=1024,
        min=16,
        soft_max=16384,
        subtype="PIXEL",
    ),
    "height": IntProperty(
        name="Texture Height",
        description="Height of a texture that is not square, in texels; 0: the same as its width",
        default=0,
        min=0,
        soft_max=16384,
        subtype="PIXEL",
    ),
    "texel_density": FloatProperty(
        name="Texel Density",
        description="Texels per unit of length; charts that do not fit continue on further UDIM tiles. "
        "0: charts are as large as the texture allows",
        default=0.0,
        min=0.0,
        soft_max=10000.0,
    ),
    "layer": EnumProperty(name="UV Map", items=LAYERS, default="ACTIVE"),
    "modifiers": BoolProperty(
        name="Use Modifiers",
        description="Unwrap the shape that modifiers produce, such as Subdivision Surface or Armature",
        default=False,
    ),
}


class LinabfSettings(bpy.types.PropertyGroup):
    """The settings of the panel, stored in the scene."""

    __annotations__ = dict(PROPERTIES)


def draw(layout: bpy.types.UILayout, chosen: object) -> None:
    """Draw the settings as rows of a panel."""
    layout.use_property_decorate = False
    split = layout.column()
    split.use_property_split = True
    split.prop(chosen, "method")
    split.row().prop(chosen, "seams", expand=True)
    if chosen.seams == "MARKED":
        split.prop(chosen, "extend")
    split.prop(chosen, "hide")
    split.prop(chosen, "keep_materials")
    # without `use_property_split`, names are inside the number fields, and fit into a narrow sidebar
    column = layout.column(align=True)
    for name in ("trade", "max_stretch", *(("cones",) if chosen.seams == "FOUND" else ())):
        column.prop(chosen, name)
    column = layout.column(align=True)
    for name in ("margin", "resolution", "height", "texel_density"):
        column.prop(chosen, name)
    split = layout.column()
    split.use_property_split = True
    split.prop(chosen, "layer")
    split.prop(chosen, "modifiers")


def copy_settings(chosen: LinabfSettings, button: bpy.types.OperatorProperties) -> None:
    """Copy the settings of the panel to a button or a menu entry."""
    for name in PROPERTIES:
        setattr(button, name, getattr(chosen, name))


def register() -> None:
    bpy.utils.register_class(LinabfSettings)
    bpy.types.Scene.linabf = PointerProperty(type=LinabfSettings)


def unregister() -> None:
    del bpy.types.Scene.linabf
    bpy.utils.unregister_class(LinabfSettings)
