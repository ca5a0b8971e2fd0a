"""Tests of the extension in the Python of Blender: `python blender_scenes EXTENSION.zip [TEST ...]`.

The script installs the extension with its wheels from the archive, runs all test functions of the modules in
this folder, or the named scenes, and prints the failures as JSON.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import traceback

os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="igl_linabf-blender-")

import bpy
import pins
import selections
import settings
import unwrapping

MODULES = unwrapping, selections, settings, pins


def main() -> int:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(
        filepath=sys.argv[1], repo="user_default", enable_on_install=True
    )
    failed = {}
    tests = {
        name: function
        for module in MODULES
        for name, function in vars(module).items()
        if name.startswith("test_") and (not sys.argv[2:] or name in sys.argv[2:])
    }
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
