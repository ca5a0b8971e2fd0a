"""Add the operator UV > Unwrap (Linear ABF) to Blender.

The operator unwraps selected faces or whole objects, along the seams marked in Blender or along seams that it
finds. It writes the UV layers, and marks the seams that it finds.
"""

from . import operators, panel, settings

MODULES = settings, operators, panel


def register() -> None:
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
