"""Draw pictures of a surface and its flat map: checkerboards, distortion, grids.

All functions add to a given or a new pyvista `Plotter`, and return it. With `show=True`, the plotter is also
shown, and `screenshot` saves the picture, as in `Plotter.show`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import ArrayLike

from .._types import FloatArray
from ..charts import Atlas
from ..measures import Measure, format_pair_count, quality
from ..remesh import QuadGrid
from ..surface import vertex_array
from .scene import (
    DARK,
    LIGHT,
    Scene,
    add_flat,
    add_seams,
    add_surface,
    build_board_options,
    build_distortion_options,
    build_flat_scene,
    build_scene,
    face_camera,
    look_at_plane,
)

CAPTION_SIZE = 14  # font size of captions, points


def plot_checkerboard(
    V: ArrayLike,
    F: ArrayLike,
    uv: ArrayLike | Atlas,
    *,
    seams: ArrayLike | None = None,
    frequency: float = 30.0,
    texture: pv.Texture | None = None,
    plotter: pv.Plotter | None = None,
    show: bool = False,
    screenshot: str | bool = False,
    **kwargs: Any,
) -> pv.Plotter:
    """Add the surface, textured with a checkerboard by its flat map, to a plotter.

    Parameters
    ----------
    V, F : (#V, 3) float and (#F, 3) int
    uv : (#V, 2) float, or Atlas
        The map, or the result of `unwrap(V, F)`. Flipped faces are red.
    seams : (#E, 2) int or (#F, 3) bool, optional
        Edges of F to draw as dark lines; by default the seams of the atlas. `[]` draws no seams. Cones of an
        atlas are drawn as spheres, and the arcs of the seam between them in different colours.
    frequency : float
        Number of squares of the checkerboard along the longer side of the map. An atlas with a `period` has
        two squares per period instead.
    texture : pyvista.Texture, optional
        A texture instead of the checkerboard, repeated every two squares.
    plotter : pyvista.Plotter, optional
        Plotter to which the picture is added, at its active subplot; by default a new plotter.
    show : bool
        Also show the plotter.
    screenshot : str or bool
        Where to save the picture when it is shown.
    **kwargs
        Options of `Plotter.add_mesh`.

    Returns
    -------
    pyvista.Plotter

    Raises
    ------
    MeshError
        The arrays do not match, or a seam is not an edge of F.

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
    colours = {**build_board_options(frequency, texture), **kwargs}
    return _plot_surface(build_scene(V, F, uv, seams), colours, plotter, show, screenshot)


def plot_uv(
    uv: ArrayLike | Atlas,
    F: ArrayLike,
    *,
    scalars: ArrayLike | None = None,
    frequency: float = 30.0,
    texture: pv.Texture | None = None,
    plotter: pv.Plotter | None = None,
    show: bool = False,
    screenshot: str | bool = False,
    **kwargs: Any,
) -> pv.Plotter:
    """Add the flat map with its boundary to a plotter, with flipped triangles in red.

    Parameters
    ----------
    uv : (#V, 2) float, or Atlas
        The map; for an atlas its `TC`, or the atlas itself. With the atlas itself, both sides of a seam
        through cones have the same colour.
    F : (#F, 3) int
        Triangles; `atlas.FTC` for an atlas.
    scalars : (#F,) or (#V,) float, optional
        Values to show as colours instead of the checkerboard. `cmap`, `clim`, `log_scale` and
        `scalar_bar_args` are passed to `Plotter.add_mesh`.
    frequency, texture, plotter, show, screenshot, **kwargs : see `plot_checkerboard`
        As in `plot_checkerboard`.

    Returns
    -------
    pyvista.Plotter

    Raises
    ------
    MeshError
        The arrays do not match.

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
    drawn = build_flat_scene(uv, F)
    uv, F = (uv.flat, uv.triangles) if isinstance(uv, Atlas) else (uv, F)
    target, _ = _get_plotter(plotter)
    colours = (
        build_board_options(frequency, texture)
        if scalars is None
        else {"scalars": _select_scalars(scalars, uv, F)}
    )
    add_flat(target, drawn, **{**colours, **kwargs})
    return _show_if_requested(target, show, screenshot)


def plot_distortion(
    V: ArrayLike,
    F: ArrayLike,
    uv: ArrayLike | Atlas,
    measure: Measure = "angle",
    *,
    seams: ArrayLike | None = None,
    plotter: pv.Plotter | None = None,
    show: bool = False,
    screenshot: str | bool = False,
    **kwargs: Any,
) -> pv.Plotter:
    """Add the surface, coloured by the distortion of each triangle in the flat map, to a plotter.

    Parameters
    ----------
    V, F, uv : see `plot_checkerboard`
        As in `plot_checkerboard`.
    measure : {"angle", "conformal", "stretch", "area"}
        As in `igl_linabf.distortion`. Angles and stretch have a logarithmic colour scale, areas a
        diverging colour scale around 0. Flipped and collapsed triangles are red.
    seams, plotter, show, screenshot : see `plot_checkerboard`
        As in `plot_checkerboard`.
    **kwargs
        Options of `Plotter.add_mesh`. `clim`, `cmap` and `log_scale` change the colour scale. By default it
        extends from the 2nd to the 98th percentile.

    Returns
    -------
    pyvista.Plotter

    Raises
    ------
    MeshError
        The arrays do not match or are not finite, or a face has no area.

    Examples
    --------
    >>> import igl, pyvista, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> atlas = igl_linabf.unwrap(V, F)
    >>> plotter = plot_distortion(V, F, atlas, "area", plotter=pyvista.Plotter(off_screen=True))
    >>> [mesh.n_cells for mesh in plotter.meshes] == [20, len(atlas.seams)]
    True
    >>> plotter.close()
    """
    drawn = build_scene(V, F, uv, seams)
    (colours,) = build_distortion_options([drawn], measure)
    return _plot_surface(drawn, {**colours, **kwargs}, plotter, show, screenshot)


def plot_grid(
    grid: QuadGrid,
    *,
    flat: bool = False,
    plotter: pv.Plotter | None = None,
    show: bool = False,
    screenshot: str | bool = False,
    **kwargs: Any,
) -> pv.Plotter:
    """Add a quad grid to a plotter: whole cells are light, cells cut by the boundary are dark.

    Parameters
    ----------
    grid : QuadGrid
        Result of `igl_linabf.remesh.quad_grid`.
    flat : bool
        Draw the grid in the flat map instead of on the surface.
    plotter, show, screenshot, **kwargs : see `plot_checkerboard`
        As in `plot_checkerboard`.

    Returns
    -------
    pyvista.Plotter

    Examples
    --------
    >>> import igl, pyvista, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> grid = igl_linabf.remesh.quad_grid(V, F[1:], igl_linabf.linabf(V, F[1:]))
    >>> plotter = plot_grid(grid, plotter=pyvista.Plotter(off_screen=True))
    >>> sum(mesh.n_cells for mesh in plotter.meshes) == len(grid.faces)
    True
    >>> plotter.close()
    """
    target, alone = _get_plotter(plotter)
    points = np.insert(grid.uv, 2, 0.0, axis=1) if flat else grid.V
    options = {"show_edges": True, "edge_color": "black", "lighting": not flat}
    for chosen, colour in ((grid.whole, LIGHT), (~grid.whole, DARK)):
        faces = [grid.faces[i] for i in np.flatnonzero(chosen)]
        if faces:
            cells = pv.PolyData.from_irregular_faces(points, faces)
            target.add_mesh(cells, color=colour, **options, **kwargs)
    if flat:
        look_at_plane(target)
    elif alone:
        fans = [(face[0], face[i], face[i + 1]) for face in grid.faces for i in range(1, len(face) - 1)]
        face_camera(target, grid.V, np.array(fans))
    return _show_if_requested(target, show, screenshot)


def plot_compare(
    V: ArrayLike,
    F: ArrayLike,
    maps: Mapping[str, ArrayLike | Atlas],
    *,
    measure: Measure | None = None,
    seams: ArrayLike | None = None,
    frequency: float = 30.0,
    texture: pv.Texture | None = None,
    off_screen: bool | None = None,
    window_size: tuple[int, int] | None = None,
    screenshot: str | bool = False,
    show: bool = True,
    **kwargs: Any,
) -> pv.Plotter:
    """Show flat maps of one surface in rows, each with the textured surface and the map beside it.

    Parameters
    ----------
    V, F : (#V, 3) float and (#F, 3) int
    maps : mapping of name to (#V, 2) float, or to Atlas
        Maps by name. Each row has the name, F/3nt, and the numbers of flipped triangles and of pairs that
        overlap. All maps except atlases are rotated, scaled and translated to fit the first one, so that the
        checkerboards can be compared.
    measure : {"angle", "conformal", "stretch", "area"}, optional
        Distortion to show instead of the checkerboard, with the same colour scale for all maps.
    seams, frequency, texture : see `plot_checkerboard`
        As in `plot_checkerboard`.
    off_screen : bool, optional
        If True, do not open a window; by default `pyvista.OFF_SCREEN`.
    window_size : (int, int), optional
        Width and height in pixels.
    screenshot : str or bool
        Where to save the picture when it is shown.
    show : bool
        If False, return the plotter without showing it.
    **kwargs
        Options of `pyvista.Plotter`: `theme`, `notebook`, `title`, ...

    Returns
    -------
    pyvista.Plotter

    Raises
    ------
    MeshError
        The arrays do not match.
    ValueError
        `maps` is empty.

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
    if not maps:
        raise ValueError("maps is empty: give at least one flat map with its name")
    scenes = [build_scene(V, F, uv, seams) for uv in maps.values()]
    single = [i for i, uv in enumerate(maps.values()) if not isinstance(uv, Atlas)]
    for i in single[1:]:
        scenes[i] = scenes[i].fit_map(scenes[single[0]])
    options = {"window_size": list(window_size or (1400, 700 * len(maps))), "border": False, **kwargs}
    with pv.vtk_verbosity("error"):  # VTK warns without a display, and continues
        plotter = pv.Plotter(shape=(len(maps), 2), off_screen=off_screen, **options)
        board_colours = build_board_options(frequency, texture)
        colours = (
            [board_colours] * len(maps) if measure is None else build_distortion_options(scenes, measure)
        )
        for row, (name, drawn) in enumerate(zip(maps, scenes, strict=True)):
            measured = quality(drawn.V, drawn.F, drawn.uv)
            plotter.subplot(row, 0)
            add_surface(
                plotter, drawn, **colours[row], show_scalar_bar=False
            )  # the map beside the surface has the scalar bar
            add_seams(plotter, drawn)
            face_camera(plotter, drawn.V, drawn.F)
            caption = f"{name}: F/3nt {measured.angle_distortion:.3g}, {measured.flips} flipped"
            if measured.overlaps:
                caption += f", {format_pair_count(measured.overlaps)} pairs overlap"
            plotter.add_text(caption, font_size=CAPTION_SIZE)
            plotter.subplot(row, 1)
            add_flat(plotter, drawn.flat_scene, **colours[row])
        return _show_if_requested(plotter, show, screenshot)


def _plot_surface(
    drawn: Scene, colours: dict[str, Any], plotter: pv.Plotter | None, show: bool, screenshot: str | bool
) -> pv.Plotter:
    """Add the surface with its seams to the given plotter or a new one."""
    target, alone = _get_plotter(plotter)
    add_surface(target, drawn, **colours)
    add_seams(target, drawn)
    if alone:
        face_camera(target, drawn.V, drawn.F)
    return _show_if_requested(target, show, screenshot)


def _select_scalars(scalars: ArrayLike, uv: ArrayLike, F: ArrayLike) -> FloatArray:
    """Return the scalars as an array; omit values at vertices that no face uses."""
    values = np.asarray(scalars, dtype=np.float64).ravel()
    n = len(vertex_array(uv, 2, "uv"))
    return values[np.unique(np.asarray(F))] if len(values) == n != len(np.asarray(F)) else values


def _get_plotter(plotter: pv.Plotter | None) -> tuple[pv.Plotter, bool]:
    """Return the given plotter or a new one, and whether it is new."""
    if plotter is not None:
        return plotter, False
    with pv.vtk_verbosity("error"):  # VTK warns without a display, and continues
        return pv.Plotter(), True


def _show_if_requested(plotter: pv.Plotter, show: bool, screenshot: str | bool) -> pv.Plotter:
    """Show the plotter if requested, and return it."""
    if show:
        with pv.vtk_verbosity("error"):
            plotter.show(screenshot=screenshot)
        # prevent a notebook from displaying the plotter again as the value of the cell
        plotter._repr_png_ = lambda: None
    return plotter
