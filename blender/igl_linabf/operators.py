"""The operator, which unwraps the chosen faces of all chosen objects into one atlas."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise

import bpy
import numpy as np

from .scene import CannotUnwrapError, Part, mark_seams, read_part, select_faces, write_uv
from .settings import PROPERTIES, draw


class UV_OT_linabf_unwrap(bpy.types.Operator):
    """Unwrap the selected faces, or whole objects, by linear angle based flattening"""

    bl_idname = "uv.linabf_unwrap"
    bl_label = "Unwrap (Linear ABF)"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  # Blender requires a set
    __annotations__ = dict(PROPERTIES)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.active_object is not None and context.active_object.type == "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        draw(self.layout, self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        objects, selected = _choose_objects(context)
        modifiers = context.evaluated_depsgraph_get() if self.modifiers else None
        with _object_mode(context, selected), _progress(context) as progress:
            try:
                found = (read_part(obj, selected, modifiers) for obj in objects)
                parts = [part for part in found if part is not None]
                if not parts:
                    what = "no faces are selected" if selected else "the objects have no faces"
                    raise CannotUnwrapError(f"{what}: select some")
                return self._unwrap(parts, progress)
            except CannotUnwrapError as error:
                if error.mesh is not None and error.faces:
                    select_faces(error.mesh, error.faces)
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}

    def _unwrap(self, parts: list[Part], progress: object) -> set[str]:
        # imported here, because the import of SciPy is slow
        from igl_linabf import ChartOptions, MeshError, Packing, unwrap

        vertices = np.cumsum([0, *(len(part.V) for part in parts)])
        faces = np.cumsum([0, *(len(part.F) for part in parts)])
        F = [
            [v + first for v in row]
            for part, first in zip(parts, vertices.tolist(), strict=False)
            for row in part.F
        ]
        marked = self.seams == "MARKED"
        edges = np.concatenate([part.seams + first for part, first in zip(parts, vertices, strict=False)])
        if marked:
            seams, charts = edges, ChartOptions(trade=self.trade, extend=self.extend)
        else:
            seams, charts = None, None if self.cones else ChartOptions(trade=self.trade)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                atlas = unwrap(
                    np.concatenate([part.V for part in parts]),
                    F,
                    seams,
                    charts=charts,
                    method=self.method,
                    cones=self.cones if charts is None else None,
                    packing=Packing(
                        resolution=(self.resolution, self.height or self.resolution), padding=self.margin
                    ),
                    progress=progress,
                )
            except MeshError as error:
                helps = "; Extend Seams finds the missing seams" if marked and not self.extend else ""
                raise CannotUnwrapError(f"{error}{helps}") from None
        uv = atlas.TC[np.concatenate([np.asarray(row) for row in atlas.FTC])]
        corners = np.cumsum([0, *(len(part.loops) for part in parts)])
        for part, (a, b), first in zip(parts, pairwise(corners), vertices, strict=False):
            write_uv(part, uv[a:b], second=self.layer == "SECOND")
            if not marked or self.extend:
                own = (atlas.seams >= first).all(axis=1) & (atlas.seams < first + len(part.V)).all(axis=1)
                mark_seams(part, atlas.seams[own] - first, keep=marked)
        for warning in caught:
            self.report({"WARNING"}, str(warning.message))
        self._select_bad_charts(atlas, parts, faces)
        if atlas.good:
            self.report({"INFO"}, f"{len(atlas.charts)} charts, L2 stretch {atlas.quality.stretch_l2:.3f}")
        return {"FINISHED"}

    def _select_bad_charts(self, atlas: object, parts: list[Part], faces: np.ndarray) -> None:
        """Select the faces of all charts that overlap or have a bad outcome."""
        if atlas.good:
            return
        bad = np.zeros(faces[-1], dtype=bool)
        for chart in atlas.charts:
            bad[chart.faces] |= bool(chart.overlapping) or not chart.result.outcome.good
        for part, (a, b) in zip(parts, pairwise(faces), strict=True):
            if bad[a:b].any():
                select_faces(part.obj.data, part.polygons[bad[a:b]].tolist())


def _choose_objects(context: bpy.types.Context) -> tuple[list[bpy.types.Object], bool]:
    """Return the objects, each mesh once, and whether only selected faces are unwrapped (edit mode)."""
    selected = context.mode == "EDIT_MESH"
    objects = context.objects_in_mode_unique_data if selected else context.selected_objects
    meshes = {obj.data: obj for obj in reversed(objects) if obj.type == "MESH"}
    return list(reversed(meshes.values())), selected


@contextmanager
def _object_mode(context: bpy.types.Context, editing: bool) -> Iterator[None]:
    """Leave edit mode, because arrays of a mesh are accessible in object mode only."""
    if editing:
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if editing:
            bpy.ops.object.mode_set(mode="EDIT")


@contextmanager
def _progress(context: bpy.types.Context) -> Iterator[object]:
    """Yield a callback of `unwrap` that drives the progress cursor of Blender."""
    manager = context.window_manager
    manager.progress_begin(0.0, 1.0)
    try:
        yield lambda stage, fraction: manager.progress_update(fraction)
    finally:
        manager.progress_end()


def register() -> None:
    bpy.utils.register_class(UV_OT_linabf_unwrap)


def unregister() -> None:
    bpy.utils.unregister_class(UV_OT_linabf_unwrap)
