"""Pictures: a checkerboard on the surface, and the flat map beside it. Needs pyvista."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .mesh import (
    compact,
    complex_positions,
    coordinates,
    face_array,
    signed_double_areas,
    vertex_array,
)
from .quality import quality
from .topology import FloatArray, IntArray

try:
    import pyvista as pv
except ImportError as error:
    raise ImportError("igl_linabf.plot needs pyvista: pip install 'igl-linabf[viz]'") from error

LIGHT, DARK, WARNING = "#f4f1e8", "#2f6690", "#d1242f"


def checker_texture(light: str = LIGHT, dark: str = DARK, resolution: int = 64) -> pv.Texture:
    """A repeating checkerboard of two by two squares.

    Parameters
    ----------
    light, dark : str
        Colours.
    resolution : int
        Pixels of a square's side.

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


def plot_checkerboard(
    V: ArrayLike,
    F: ArrayLike,
    uv: ArrayLike,
    *,
    frequency: float = 30.0,
    texture: pv.Texture | None = None,
    plotter: pv.Plotter | None = None,
    **kwargs: Any,
) -> pv.Plotter:
    """Add the surface, with a checkerboard pulled back from its flat map, to a plotter.

    Parameters
    ----------
    V, F : (#V, 3) float and (#F, 3) int
    uv : (#V, 2) float
    frequency : float
        Squares of the board along the longer side of the map.
    texture : pyvista.Texture, optional
        Another picture than the checkerboard, repeated every two squares.
    plotter : pyvista.Plotter, optional
        Where to add it, in its active renderer; a new one by default.
    **kwargs
        For `Plotter.add_mesh`.

    Returns
    -------
    pyvista.Plotter

    Examples
    --------
    >>> import igl, pyvista, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> plotter = pyvista.Plotter(off_screen=True)
    >>> plotter = plot_checkerboard(V, F[1:], igl_linabf.linabf(V, F[1:]), plotter=plotter, show_edges=True)
    >>> plotter.screenshot(return_img=True, window_size=(300, 200)).shape
    (200, 300, 3)
    >>> plotter.close()
    """
    points, faces, map_ = _used(V, F, uv)
    return _add(points, faces, map_, frequency, texture, plotter, **kwargs)


def plot_uv(
    uv: ArrayLike,
    F: ArrayLike,
    *,
    frequency: float = 30.0,
    texture: pv.Texture | None = None,
    plotter: pv.Plotter | None = None,
    **kwargs: Any,
) -> pv.Plotter:
    """Add the flat map with its checkerboard and its boundary to a plotter, flipped triangles in red.

    Parameters
    ----------
    uv : (#V, 2) float
    F : (#F, 3) int
    frequency, texture, plotter, **kwargs
        As in `plot_checkerboard`.

    Returns
    -------
    pyvista.Plotter

    Examples
    --------
    >>> import igl, pyvista, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> uv = igl_linabf.linabf(V, F[1:])
    >>> plotter = plot_uv(uv, F[1:], frequency=10, plotter=pyvista.Plotter(off_screen=True))
    >>> [mesh.n_cells for mesh in plotter.meshes]  # triangles, and edges of the boundary
    [19, 3]
    >>> plotter.close()
    """
    flat, faces, map_ = _used(np.insert(vertex_array(uv, 2, "uv"), 2, 0.0, axis=1), F, uv)
    plotter = _add(flat, faces, map_, frequency, texture, plotter, **{"lighting": False, **kwargs})
    sides = np.sort(np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])), axis=1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    outline = pv.PolyData(flat, lines=np.insert(edges[count == 1], 0, 2, axis=1).ravel())
    plotter.add_mesh(outline, color="black", line_width=2)
    flipped = ~(signed_double_areas(complex_positions(map_), faces.T) > 0)
    if flipped.any():
        above = flat + np.array([0, 0, 1e-3 * np.ptp(flat, axis=0).max()])
        marked = pv.PolyData.from_regular_faces(above, faces[flipped])
        plotter.add_mesh(marked, color=WARNING, lighting=False)
        plotter.add_mesh(marked, style="wireframe", color=WARNING, lighting=False, line_width=3)
    plotter.camera.tight(padding=0.08, view="xy", adjust_render_window=False)
    return plotter


def plot_compare(
    V: ArrayLike,
    F: ArrayLike,
    maps: Mapping[str, ArrayLike],
    *,
    frequency: float = 30.0,
    texture: pv.Texture | None = None,
    off_screen: bool | None = None,
    window_size: tuple[int, int] | None = None,
    screenshot: str | bool = False,
    show: bool = True,
    **kwargs: Any,
) -> pv.Plotter:
    """Show flat maps of one surface in rows: checkerboard on the surface, and the map beside it.

    Parameters
    ----------
    V, F : (#V, 3) float and (#F, 3) int
    maps : mapping of name to (#V, 2) float
        One row each, under its name, F/3nt and number of flipped triangles. Each is turned, scaled
        and moved to fit the first, so that the boards can be compared.
    frequency, texture
        As in `plot_checkerboard`.
    off_screen, window_size, **kwargs
        For `pyvista.Plotter`.
    screenshot : str or bool
        Where to save the picture when it is shown.
    show : bool
        False returns the plotter to go on with.

    Returns
    -------
    pyvista.Plotter

    Examples
    --------
    >>> import igl, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> V[:, 2] *= 2
    >>> maps = {"linABF": igl_linabf.linabf(V, F[1:]), "igl.lscm": igl_linabf.lscm(V, F[1:])}
    >>> plotter = plot_compare(V, F[1:], maps, off_screen=True)  # a window, without off_screen
    >>> plotter.shape
    (2, 2)
    >>> plotter.close()
    """
    with pv.vtk_verbosity("error"):  # VTK warns where it finds no display, and goes on without
        plotter = _rows(V, F, maps, frequency, texture, off_screen, window_size, kwargs)
        if show:
            plotter.show(screenshot=screenshot)
    return plotter


def _rows(
    V: ArrayLike,
    F: ArrayLike,
    maps: Mapping[str, ArrayLike],
    frequency: float,
    texture: pv.Texture | None,
    off_screen: bool | None,
    window_size: tuple[int, int] | None,
    options: dict[str, Any],
) -> pv.Plotter:
    size = window_size or (1400, 700 * len(maps))
    plotter = pv.Plotter(
        shape=(len(maps), 2), off_screen=off_screen, window_size=list(size), border=False, **options
    )
    first = vertex_array(next(iter(maps.values())), 2, "uv")
    board: dict[str, Any] = {"frequency": frequency, "texture": texture, "plotter": plotter}
    for row, (name, uv) in enumerate(maps.items()):
        measured = quality(V, F, uv)
        fitted = fit(uv, first)
        plotter.subplot(row, 0)
        plot_checkerboard(V, F, fitted, **board)
        _face_the_camera(plotter, *_used(V, F, fitted)[:2])
        caption = f"{name}: F/3nt {measured.angle_distortion:.3g}, {measured.flips} flipped"
        plotter.add_text(caption, font_size=14, color="black")
        plotter.subplot(row, 1)
        plot_uv(fitted, F, **board)
    plotter.background_color = "white"
    return plotter


def fit(uv: ArrayLike, onto: ArrayLike) -> FloatArray:
    """The map turned, scaled and moved to lie on another one as well as a similarity can.

    Parameters
    ----------
    uv, onto : (#V, 2) float
        NaN rows are left out, and stay.

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
    return coordinates(ratio * (z - z0) + w0)


def _used(points: ArrayLike, F: ArrayLike, uv: ArrayLike) -> tuple[FloatArray, IntArray, FloatArray]:
    """Points, faces and map without the vertices that no face refers to."""
    array = vertex_array(points)
    vertices, faces = compact(face_array(F), len(array))
    return array[vertices], faces, vertex_array(uv, 2, "uv")[vertices]


def _add(
    points: FloatArray,
    faces: IntArray,
    uv: FloatArray,
    frequency: float,
    texture: pv.Texture | None,
    plotter: pv.Plotter | None,
    **kwargs: Any,
) -> pv.Plotter:
    plotter = pv.Plotter() if plotter is None else plotter
    surface = pv.PolyData.from_regular_faces(points, faces)
    low = uv.min(axis=0)
    # a texture is two squares wide
    surface.active_texture_coordinates = (uv - low) * (frequency / 2 / np.ptp(uv, axis=0).max())
    options = {"smooth_shading": True, "texture": checker_texture() if texture is None else texture}
    plotter.add_mesh(surface, **{**options, **kwargs})
    return plotter


def _face_the_camera(plotter: pv.Plotter, points: FloatArray, faces: IntArray) -> None:
    """Look along the coordinate axis of the least extent, from the side that more area faces.

    y is up, unless the picture would be much higher than wide.
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
    # `tight` leaves the camera close to the middle, where it would cut the surface open
    back = np.linalg.norm(np.ptp(points, axis=0))
    camera = plotter.camera
    camera.position = np.array(camera.focal_point) - back * np.array(camera.direction)
    plotter.reset_camera_clipping_range()
