"""Define the operator, which unwraps the chosen faces of all chosen objects into one atlas."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy
import numpy as np

from .objects import CannotUnwrapError, choose_objects, find_largest_frames, object_mode
from .pins import keep_pins, pack_beside, split_locked
from .scene import Part, mark_seams, read_part, select_faces, write_uv
from .settings import PROPERTIES, draw
from .shapes import read_positions
from .surface import Surface, make_atlas, mirrored_axis


class UV_OT_linabf_unwrap(bpy.types.Operator):
    """Unwrap the selected faces, or whole objects, without flips and overlaps"""

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
        selected = context.mode == "EDIT_MESH"
        with _progress(context) as progress:
            try:
                objects, linked = choose_objects(context)
                with object_mode(context):
                    try:
                        self._report_linked(objects, linked)
                        parts, locked = self._read_parts(context, objects, selected)
                        return self._unwrap(Surface.of(parts), locked, progress)
                    except CannotUnwrapError as error:
                        if error.mesh is not None and error.faces:
                            select_faces(error.mesh, error.faces)
                        raise
            except CannotUnwrapError as error:
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}

    def _report_linked(self, objects: list[bpy.types.Object], linked: list[str]) -> None:
        """Warn that linked objects, whose meshes belong to another file, are left out."""
        if not linked:
            return
        text = f"the mesh of {', '.join(linked)} is linked from another file, where changes would be lost"
        help_ = "make it local (Object > Relations > Make Local > Selected Objects and Data)"
        if not objects:
            raise CannotUnwrapError(f"{text}: {help_}")
        self.report({"WARNING"}, f"{text}; it is left out: {help_}")

    def _read_parts(
        self, context: bpy.types.Context, objects: list[bpy.types.Object], selected: bool
    ) -> tuple[list[Part], list[Part]]:
        """Return, for each object, the faces to unwrap, and the faces of completely pinned UV islands."""
        axis, second = mirrored_axis(self.hide), self.layer == "SECOND"
        frames = find_largest_frames(context.evaluated_depsgraph_get(), objects)
        split = []
        for obj, frame in zip(objects, frames, strict=True):
            V = read_positions(obj, frame, context, self.modifiers, axis)
            split.append(split_locked(read_part(obj, V, selected, second)))
        parts, locked = ([part for part in each if len(part.polygons)] for each in zip(*split, strict=True))
        if not parts and locked:
            raise CannotUnwrapError("all UVs are pinned: unpin those that may move")
        if not parts:
            raise CannotUnwrapError(
                "no faces are selected: select some" if selected else "the objects have no faces: add some"
            )
        return parts, locked

    def _unwrap(self, surface: Surface, locked: list[Part], progress: object) -> set[str]:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            atlas, found = self._make_atlas(surface, progress)
            rows = np.concatenate([np.ravel(row) for row in atlas.FTC])
            TC, faulty = self._place_pinned(surface, locked, atlas, rows)
        for part, own in surface.split_corners(rows):
            uv = TC[own]
            uv[part.pinned] = part.uv[part.pinned]
            write_uv(part, uv, second=self.layer == "SECOND")
            if found:
                mark_seams(part, own, keep=self.seams == "MARKED")
        for warning in caught:
            self.report({"WARNING"}, str(warning.message))
        self._select_faulty_charts(surface, atlas, faulty)
        if atlas.good and not faulty.any():
            summary = f"{len(atlas.charts)} charts, L2 stretch {atlas.quality.stretch_l2:.3f}"
            unmarked = found and self.seams == "MARKED" and not self.extend
            self.report({"INFO"}, summary + "; no seams were marked, and seams were found" * unmarked)
        return {"FINISHED"}

    def _make_atlas(self, surface: Surface, progress: object) -> tuple[Any, bool]:
        """Return the atlas, and whether it has automatic seams.

        If no seams are marked, automatic seams are used only if the faces cannot be unwrapped without them,
        for example the faces of a closed surface.
        """
        if self.seams == "FOUND" or self.extend:
            return make_atlas(surface, self, self.seams == "MARKED", progress), True
        try:
            return make_atlas(surface, self, False, progress), False
        except CannotUnwrapError:
            if len(surface.join("seams")):
                raise
        return make_atlas(surface, self, True, progress), True

    def _place_pinned(
        self, surface: Surface, locked: list[Part], atlas: Any, rows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return texture coordinates that keep all pins, and a mask of the charts with flips or overlaps."""
        faulty = np.array(
            [bool(chart.overlapping) or not chart.result.outcome.good for chart in atlas.charts], dtype=bool
        )
        if not (locked or surface.join("pinned").any()):
            return atlas.TC, faulty
        pinned = keep_pins(surface, atlas, rows, self.method)
        if pack_beside(surface, atlas, pinned, rows, locked, self):
            self.report(
                {"WARNING"}, "the pinned charts leave no room: the other charts are on the next UDIM tile"
            )
        if pinned.faulty.any():
            self.report(
                {"WARNING"},
                f"the pins of {np.count_nonzero(pinned.faulty)} charts force flips or overlaps; the charts "
                "are selected: move or remove pins",
            )
        return pinned.TC, (faulty & ~pinned.fixed) | pinned.faulty

    def _select_faulty_charts(self, surface: Surface, atlas: Any, faulty: np.ndarray) -> None:
        """Select the faces of all charts that have flips or overlaps."""
        if faulty.any():
            bad = np.isin(np.asarray(atlas.chart), np.flatnonzero(faulty))
            for part, chosen in surface.split_faces(bad):
                if chosen.any():
                    select_faces(part.obj.data, part.polygons[chosen])


@contextmanager
def _progress(context: bpy.types.Context) -> Iterator[object]:
    """Yield a progress callback for `unwrap` that updates Blender's progress cursor."""
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
