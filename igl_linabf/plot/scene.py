"""Build the parts of pictures: textures, colour scales, cameras, lines."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import igl
import numpy as np
import pyvista as pv
from numpy.typing import ArrayLike

from .._core import signed_double_areas
from .._types import BoolArray, FloatArray, IntArray
from ..charts import Atlas
from ..errors import MeshError, format_count
from ..measures import Measure, distortion
from ..surface import (
    complex_positions,
    drop_unused_vertices,
    face_array,
    make_seam_mask,
    map_array,
    vertex_array,
)
from .cones import SeamSides, add_cones, choose_arc_colours, find_seam_sides

SCALAR_BAR_HEIGHT = 0.12  # height of a scalar bar, relative to the height of the window
LIGHT, DARK, WARNING, SEAM = "#f4f1e8", "#2f6690", "#d1242f", "#16161d"
LABEL_FORMAT = "{:.3g}" if pv.vtk_version_info >= (9, 6) else "%.3g"  # VTK 9.6 changed its format syntax


@dataclass(frozen=True, eq=False)
class Scene:
    """A surface and its flat map, without the vertices that no face uses.

    Attributes
    ----------
    V : (#v, 3) float64
    F : (#F, 3) int64
    uv : (#v, 2) float64
    seams : (#E, 2, 3) float64
        Ends of the seam edges on the surface.
    cones : (#C, 3) float64
        Positions of the cones.
    sides : SeamSides or None
        Both sides of the seam, for an atlas with cones.
    period : float or None
        Period of the texture that the atlas is made for.
    """

    V: FloatArray
    F: IntArray
    uv: FloatArray
    seams: FloatArray
    cones: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    sides: SeamSides | None = None
    period: float | None = None

    @property
    def is_flipped(self) -> BoolArray:
        """Mask of the faces that are flipped or collapsed in the map, (#F,)."""
        return ~(signed_double_areas(complex_positions(self.uv), self.F.T) > 0)

    @property
    def flat_scene(self) -> Scene:
        """The scene of the map as a surface in the plane z = 0."""
        return replace(build_flat_scene(self.uv, self.F), sides=self.sides, period=self.period)

    def fit_map(self, onto: Scene) -> Scene:
        """Return the scene with its map rotated, scaled and translated to fit the map of another scene."""
        return replace(self, uv=fit(self.uv, onto.uv), period=None)


def build_scene(V: ArrayLike, F: ArrayLike, uv: ArrayLike | Atlas, seams: ArrayLike | None = None) -> Scene:
    """Build the scene of a surface and its map or atlas, by default with the seams of the atlas."""
    points = vertex_array(V)
    if isinstance(uv, Atlas):
        return _build_atlas_scene(points, F, uv, seams)
    faces, map_ = face_array(F), map_array(uv, len(points))
    lines = points[_find_seam_edges(() if seams is None else seams, faces, len(points))]
    vertices, faces = drop_unused_vertices(faces, len(points))
    return Scene(points[vertices], faces, map_[vertices], lines)


def _build_atlas_scene(points: FloatArray, F: ArrayLike, atlas: Atlas, seams: ArrayLike | None) -> Scene:
    given = face_array(F) if atlas.report.split is None else atlas.report.split.F
    if len(atlas.triangles) != len(given) or atlas.origin.max() >= len(points):
        raise MeshError(
            f"the atlas has {format_count(len(atlas.FTC), 'face')}, and F has {len(given)}: pass the "
            "unwrapped V and F"
        )
    edges = atlas.seams if seams is None else _find_seam_edges(seams, given, len(points))
    vertices, faces = drop_unused_vertices(atlas.drawn, len(atlas.TC))
    at = points[atlas.origin[vertices]]
    drawn = Scene(at, faces, atlas.flat[vertices], points[edges], period=atlas.report.period)
    if len(atlas.report.cones) and seams is None:
        drawn = replace(drawn, cones=points[atlas.report.cones], sides=find_seam_sides(atlas))
    return drawn


def _find_seam_edges(seams: ArrayLike, F: IntArray, n: int) -> IntArray:
    """Return the vertices of each seam edge, (#E, 2)."""
    f, k = np.nonzero(make_seam_mask(seams, F, n))
    return np.unique(np.sort(np.column_stack((F[f, k], F[f, (k + 1) % 3])), axis=1), axis=0)


def build_flat_scene(uv: ArrayLike | Atlas, F: ArrayLike) -> Scene:
    """Build the scene of a map as a surface in the plane z = 0."""
    if isinstance(uv, Atlas):
        flat = replace(build_flat_scene(uv.flat, uv.drawn), period=uv.report.period)
        return replace(flat, sides=find_seam_sides(uv)) if len(uv.report.cones) else flat
    return build_scene(np.insert(vertex_array(uv, 2, "uv"), 2, 0.0, axis=1), F, uv)


def build_board_options(frequency: float, texture: pv.Texture | None = None) -> dict[str, Any]:
    """Return the options of `add_surface` that show a checkerboard, or the given texture."""
    texture = checker_texture() if texture is None else texture
    return {"frequency": frequency, "texture": texture, "smooth_shading": True}


def build_distortion_options(scenes: Iterable[Scene], measure: Measure) -> list[dict[str, Any]]:
    """Return, for each scene, the options of `add_surface` that show distortion on a common scale."""
    values = [distortion(one.V, one.F, one.uv, measure) for one in scenes]
    scale = colour_scale(values, measure)
    return [{"scalars": of, **scale} for of in values]


def checker_texture(light: str = LIGHT, dark: str = DARK, resolution: int = 64) -> pv.Texture:
    """Return a repeating checkerboard of two by two squares.

    Parameters
    ----------
    light, dark : str
        Colours.
    resolution : int
        Pixels along the side of a square.

    Returns
    -------
    pyvista.Texture

    Examples
    --------
    >>> checker_texture("white", "#802020", resolution=32).dimensions
    (64, 64)
    """
    colours = np.array([pv.Color(light).int_rgb, pv.Color(dark).int_rgb], dtype=np.uint8)
    squares = np.kron([[0, 1], [1, 0]], np.ones((resolution, resolution), dtype=int))
    texture = pv.Texture(colours[squares])
    texture.repeat = texture.interpolate = texture.mipmap = True
    return texture


def add_surface(plotter: pv.Plotter, drawn: Scene, **options: Any) -> None:
    """Add the faces of a scene to a plotter, with flipped faces in the warning colour.

    The options are the same as for `Plotter.add_mesh`. `scalars` are values at vertices or faces, and
    `frequency` is the number of squares of the checkerboard along the map.
    """
    flipped = drawn.is_flipped
    surface = pv.PolyData.from_regular_faces(drawn.V, drawn.F[~flipped])
    frequency, scalars = options.pop("frequency", None), options.pop("scalars", None)
    if scalars is not None:
        values = np.asarray(scalars, dtype=np.float64).ravel()
        if len(values) not in (len(drawn.V), len(drawn.F)):
            raise MeshError(
                f"scalars has {len(values)} values for {format_count(len(drawn.V), 'vertex')} and "
                f"{format_count(len(drawn.F), 'face')}: "
                "pass one per vertex or one per face"
            )
        by_face = len(values) == len(drawn.F)
        if options.get("log_scale") and options.get("clim") is not None:
            values = np.maximum(values, options["clim"][0])
        options["scalars"] = values[~flipped] if by_face else values
        options["preference"] = "cell" if by_face else "point"
        if options.get("lighting", True):
            options.setdefault("ambient", 0.2)  # so that shadows are not mistaken for low values
    elif options.get("texture") is not None:
        corner, size = drawn.uv.min(axis=0), np.ptp(drawn.uv, axis=0).max()
        # the texture is two squares wide, and the longer side of the map is `frequency` squares long
        surface.active_texture_coordinates = (
            (drawn.uv - corner) * (frequency / 2 / size) if drawn.period is None else drawn.uv / drawn.period
        )
    if surface.n_cells:
        plotter.add_mesh(surface, **options)
    if flipped.any():
        marked = pv.PolyData.from_regular_faces(drawn.V, drawn.F[flipped])
        plotter.add_mesh(marked, color=WARNING, lighting=False, reset_camera=options.get("reset_camera"))


def add_flat(plotter: pv.Plotter, drawn: Scene, **options: Any) -> None:
    """Add the flat map with its boundary and its flipped faces on top, and point the camera at it."""
    bar = "scalars" in options and options.get("show_scalar_bar", True)
    add_surface(plotter, drawn, **{"lighting": False, **options})
    edges, *_ = igl.boundary_facets(drawn.F)
    outline = pv.PolyData(drawn.V, lines=np.insert(edges, 0, 2, axis=1).ravel())
    plotter.add_mesh(outline, color=plotter.theme.font.color, line_width=2)
    if drawn.sides is not None:
        add_lines(plotter, np.insert(drawn.sides.side, 2, 0.0, axis=2), drawn.sides.arc_of_side)
    if drawn.is_flipped.any():
        above = drawn.V + np.array([0, 0, 1e-3 * np.ptp(drawn.V, axis=0).max()])
        marked = pv.PolyData.from_regular_faces(above, drawn.F[drawn.is_flipped])
        plotter.add_mesh(marked, color=WARNING, lighting=False)
        plotter.add_mesh(marked, style="wireframe", color=WARNING, lighting=False, line_width=3)
    look_at_plane(plotter, bar)


def look_at_plane(plotter: pv.Plotter, bar: bool = False) -> None:
    """Point the camera at the plane z = 0 so that the map fills the window, above an optional scalar bar."""
    camera = plotter.camera
    camera.tight(padding=0.08, view="xy", adjust_render_window=False)
    if bar:
        camera.parallel_scale *= 1 + SCALAR_BAR_HEIGHT
        down = np.array([0, SCALAR_BAR_HEIGHT * camera.parallel_scale, 0])
        camera.position, camera.focal_point = camera.position - down, camera.focal_point - down
    _move_camera_back(plotter, 2 * camera.parallel_scale)


def add_seams(plotter: pv.Plotter, drawn: Scene, **options: Any) -> None:
    """Add the seams and the cones on the surface; if there are cones, each arc has its own colour."""
    add_lines(plotter, drawn.seams, None if drawn.sides is None else drawn.sides.arc, **options)
    add_cones(plotter, drawn.cones, float(np.linalg.norm(np.ptp(drawn.V, axis=0))), **options)


def add_lines(plotter: pv.Plotter, segments: FloatArray, arcs: IntArray | None, **options: Any) -> None:
    """Add line segments, (#E, 2, 3), in a dark colour or in the colours of their arcs."""
    if len(segments):
        lines = pv.line_segments_from_points(segments.reshape(-1, 3))
        look: dict[str, Any] = {"color": SEAM, "line_width": 5}
        if arcs is not None:
            lines.cell_data["colour"] = choose_arc_colours(arcs)
            look = {"scalars": "colour", "rgb": True, "line_width": 6}
        plotter.add_mesh(lines, **{**look, "render_lines_as_tubes": True, "lighting": False, **options})


def colour_scale(values: Iterable[FloatArray], measure: Measure) -> dict[str, Any]:
    """Return the colour scale of a distortion: `cmap`, `clim`, `log_scale` and `scalar_bar_args`.

    The limits are the 2nd and the 98th percentile, so that a few outliers do not dominate the scale. Areas
    have a diverging colour map with 0 in the middle.

    Parameters
    ----------
    values : iterable of (#F,) float
        Distortion of each map. All maps share the scale.
    measure : {"angle", "conformal", "stretch", "area"}
        The measure of distortion.

    Returns
    -------
    dict
        Keyword arguments of `Plotter.add_mesh`.

    Examples
    --------
    >>> scale = colour_scale([np.array([1.0, 1.1]), np.array([1.0, 1.3])], "conformal")
    >>> scale["cmap"], scale["log_scale"]
    ('viridis', False)
    """
    every = np.concatenate([np.ravel(v) for v in values])
    every = every[np.isfinite(every)]
    low, high = np.quantile(every, (0.02, 0.98)) if len(every) else (0.0, 0.0)
    most = max(abs(low), abs(high), 0.01)
    title, clim = {
        "angle": ("squared relative angle error", (max(low, 1e-4 * max(high, 1e-8)), max(high, 1e-8))),
        "conformal": ("conformal distortion", (1.0, max(high, 1.001))),
        "stretch": ("L2 stretch", (min(low, 0.99), max(high, 1.01))),
        "area": ("log of the area ratio", (-most, most)),
    }[measure]
    return {
        "cmap": "BrBG" if measure == "area" else "viridis",
        "clim": clim,
        "log_scale": measure in ("angle", "stretch"),
        "scalar_bar_args": {
            "title": f"{title}\n",  # an empty line between title and labels
            "n_labels": 3,
            "fmt": LABEL_FORMAT,
            "unconstrained_font_size": True,
            "title_font_size": 20,
            "label_font_size": 18,
            "position_x": 0.2,
            "position_y": 0.02,
            "width": 0.6,
            "height": SCALAR_BAR_HEIGHT,
        },
    }


def fit(uv: ArrayLike, onto: ArrayLike) -> FloatArray:
    """Rotate, scale and translate a map to fit another one in the least-squares sense.

    Parameters
    ----------
    uv, onto : (#V, 2) float
        The map, and the map to fit. Rows with NaN are ignored and stay NaN.

    Returns
    -------
    uv : (#V, 2) float64

    Examples
    --------
    >>> fit([[0, 0], [0, 2], [0, 4]], [[5, 5], [6, 5], [7, 5]]).round(12).tolist()
    [[5.0, 5.0], [6.0, 5.0], [7.0, 5.0]]
    """
    z, w = (complex_positions(vertex_array(m, 2, "uv")) for m in (uv, onto))
    both = np.isfinite(z) & np.isfinite(w)
    z0, w0 = z[both].mean(), w[both].mean()
    ratio = np.vdot(z[both] - z0, w[both] - w0) / np.vdot(z[both] - z0, z[both] - z0)
    moved = ratio * (z - z0) + w0
    return np.column_stack((moved.real, moved.imag))


def face_camera(plotter: pv.Plotter, points: FloatArray, faces: IntArray) -> None:
    """Look along the coordinate axis with the smallest extent, from the side that shows more front faces.

    The y axis points up, unless the picture would be much higher than wide.
    """
    a, b, c = points[faces.T]
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    centre = (a + b + c) / 3
    spread = area @ (centre - area @ centre / area.sum()) ** 2
    thin, upward, across = np.argsort(spread, kind="stable")
    if thin != 1 and spread[1] < 1.5 * spread[across]:
        across, upward = 2 - thin, 1
    plane = "xyz"[across] + "xyz"[upward]
    for negative in (False, True):
        plotter.camera.tight(padding=0.08, view=plane, negative=negative, adjust_render_window=False)
        if normal.sum(axis=0) @ np.array(plotter.camera.direction) <= 1e-6 * area.sum():
            break
    _move_camera_back(plotter, float(np.linalg.norm(np.ptp(points, axis=0))))


def _move_camera_back(plotter: pv.Plotter, distance: float) -> None:
    """Move the camera away from its focal point, because `camera.tight` leaves it inside the surface."""
    camera = plotter.camera
    camera.position = np.array(camera.focal_point) - distance * np.array(camera.direction)
    plotter.reset_camera_clipping_range()
