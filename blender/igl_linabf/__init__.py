"""UV > Unwrap (Linear ABF): igl_linabf in Blender.

In: selected faces or whole objects, with Blender's seams or without. Out: their UV layers, and found seams
marked as Blender's.
"""

from . import operators, panel, settings

MODULES = settings, operators, panel


def register() -> None:
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
