"""Open a window with a surface and its flat map side by side.

A click marks the same point on the surface and on the map, or draws a seam. Sliders and keys change the
method, its iterations, the trade of seam length for stretch, and the colours.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pyvista as pv
from numpy.typing import ArrayLike

from .._types import FloatArray
from ..errors import MeshError, format_count
from ..flattening import METHODS, BoundaryName
from ..io import replacing, unit_square, write_mesh
from ..measures import MEASURES, Measure
from ..surface import face_array, vertex_array
from .constants import MARKER_RADIUS
from .displays import NO_DISPLAY, has_display
from .drawn_seams import DrawnSeams
from .map_cache import MapCache, MapRequest, Shown
from .picking import pick_face
from .scene import (
    SEAM,
    add_flat,
    add_seams,
    add_surface,
    build_board_options,
    build_distortion_options,
    face_camera,
)
from .sliders import add_sliders

PANEL_HEIGHT = 130  # height of the row with the sliders and the help, pixels
MAX_CLICK_MOVEMENT = 4  # maximum mouse movement during a click, pixels
SEAM_END_RADIUS = 0.009  # radius of spheres at the ends of seams, relative to the diagonal of the surface

METHOD_NAMES = {"lscm": "igl.lscm", "linabf": "linABF", "abf": "ABF"}
MARK = "#e815c4"
HELP = (
    """\
click  marks a point on both
s      draws seams by clicks;
       its end again: ends it
z      undoes a click""",
    """\
m    igl.lscm, linABF, ABF
] [  more, fewer iterations
d    board, angle, ... area
> <  more, fewer squares (arrows)""",
    """\
x    seams on, off
p w  save picture, mesh
h    help on, off
q    quit""",
)


@dataclass
class DisplayOptions:
    """The display options of the window.

    Attributes
    ----------
    frequency : float
        Number of squares of the checkerboard along the longer side of the map.
    measure : {"angle", "conformal", "stretch", "area"} or None
        Distortion shown instead of the checkerboard.
    seams, help : bool
        Whether the seams and the help are shown.
    """

    frequency: float
    measure: Measure | None
    seams: bool = True
    help: bool = True


class Viewer:
    """The state of the window, and the actions of its keys.

    Parameters
    ----------
    V, F : (#V, 3) float and (#F, 3) int
        Any oriented manifold surface. Surfaces other than disks (with or without holes) are unwrapped.
    method : {"linabf", "lscm", "abf"} or another method of `flatten`
        Method of the first map.
    frequency : float
        Number of squares of the checkerboard along the longer side of the map.
    measure : {"angle", "conformal", "stretch", "area"}, optional
        Distortion to show instead of the checkerboard.
    boundary : {"free", "circle", "circles", "rectangle"}
        Shape of the boundary, for methods that support it, as in `flatten`.
    cones : int or "auto", optional
        Number of cones in each component, for methods that support cones, as in `unwrap`. Cones are removed
        when the trade is changed or seams are drawn.
    off_screen : bool
        If True, do not open a window.
    window_size : (int, int)
        Width and height in pixels, including 130 pixels for the sliders and the help.
    save_as : path
        Prefix of the names of saved files, such as igl_linabf-1.png and igl_linabf-1.obj.
    **options
        Options of `pyvista.Plotter`.

    Attributes
    ----------
    plotter : pyvista.Plotter
    iterations : int
        Number of iterations of linABF; 0 stands for its default, "auto".
    trade : float or None
        Trade of seam length for stretch; None leaves a disk uncut.
    picked : (int, (3,) float64) or None
        Face and barycentric coordinates of the marked point.
    drawn : DrawnSeams
        The drawn seams.
    look : Look
        The display options.
    """

    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
        *,
        method: str = "linabf",
        frequency: float = 30.0,
        measure: Measure | None = None,
        boundary: BoundaryName = "free",
        cones: int | Literal["auto"] | None = None,
        off_screen: bool = False,
        window_size: tuple[int, int] = (1400, 700 + PANEL_HEIGHT),
        save_as: str | os.PathLike[str] = "igl_linabf",
        **options: Any,
    ) -> None:
        if method not in METHODS:
            raise ValueError(f"method is {method!r}: use one of {', '.join(map(repr, METHODS))}")
        self.methods = list(dict.fromkeys((*METHOD_NAMES, method)))
        self.method, self.iterations, self.look = method, 0, DisplayOptions(frequency, measure)
        self.trade: float | None = None
        self.picked: tuple[int, FloatArray] | None = None
        self._maps = MapCache(vertex_array(V), face_array(F), boundary, cones)
        self.drawn = DrawnSeams(self._maps.V, self._maps.F)
        self._save_as, self._message = Path(save_as), ""
        self._pressed: tuple[int, int] = (0, 0)
        shown = self.shown
        with pv.vtk_verbosity("error"):
            options = {"window_size": list(window_size), "border": False, **options}
            rows = [max(int(options["window_size"][1]) - PANEL_HEIGHT, 1), PANEL_HEIGHT]
            self.plotter = pv.Plotter(
                shape=(2, 2), groups=[(1, slice(None))], row_weights=rows, off_screen=off_screen, **options
            )
        kind = self.plotter.render_window.GetClassName()
        if not off_screen and ("EGL" in kind or "OSOpenGL" in kind):
            self.plotter.close()
            raise OSError(NO_DISPLAY)
        self.draw()
        self.plotter.subplot(0, 0)
        face_camera(self.plotter, shown.drawn.V, shown.drawn.F)
        self.plotter.camera.zoom(0.92)  # leave room for the caption
        if not off_screen:
            add_sliders(self)
            self._connect_events()

    @property
    def drawing(self) -> bool:
        """Whether clicks draw seams."""
        return self.drawn.active

    @property
    def shown(self) -> Shown:
        """The map for the current settings, computed at its first use."""
        iterations = self.iterations if self.method == "linabf" else 0
        return self._maps.get_map(MapRequest(self.method, iterations, self.trade, self.drawn.edges))

    def draw(self) -> None:
        """Redraw the surface and the map without moving the camera of the surface."""
        drawn = self.shown.drawn
        look = self.look
        colours = (
            build_board_options(look.frequency)
            if look.measure is None
            else build_distortion_options([drawn], look.measure)[0]
        )
        self.plotter.suppress_rendering = True  # render once at the end
        for title in tuple(self.plotter.scalar_bars.keys()):
            self.plotter.remove_scalar_bar(title)
        for side in (0, 1):  # surface and map; the sliders do not change
            self.plotter.renderers[side].clear_actors()
        self.plotter.subplot(0, 0)
        add_surface(self.plotter, drawn, **colours, show_scalar_bar=False, reset_camera=False)
        if self.look.seams:
            add_seams(self.plotter, drawn, reset_camera=False)
        self.plotter.add_text(self.caption, font_size=10)
        self.plotter.subplot(0, 1)
        add_flat(self.plotter, drawn.flat_scene, **colours)
        self.plotter.subplot(1, 0)
        for i, column in enumerate(HELP):
            self.plotter.add_text(
                column if self.look.help else "",
                font_size=7,
                font="courier",
                position=(0.43 + 0.2 * i, 0.2),
                viewport=True,
                name=f"help {i}",
            )
        self._draw_marks()
        self.plotter.suppress_rendering = False

    @property
    def caption(self) -> str:
        """The caption of the window."""
        q, name = self.shown.quality, METHOD_NAMES.get(self.method, self.method)
        if self.method == "linabf" and self.iterations:
            name += f", {format_count(self.iterations, 'iteration')}"
        text = f"{name}: F/3nt {q.angle_distortion:.3g}, L2 stretch {q.stretch_l2:.3g}, {q.flips} flipped"
        if self.shown.charts > 1:
            text += f", {format_count(self.shown.charts, 'chart')}"
        if self.picked is not None:
            face, weights = self.picked
            drawn = self.shown.drawn
            u, v = weights @ drawn.uv[drawn.F[face]]
            x, y, z = weights @ self._maps.V[self._maps.F[face]]
            text += f"\nface {face}: ({x:.4g}, {y:.4g}, {z:.4g}) -> ({u:.4g}, {v:.4g})"
        if self.drawing:
            text += "\ndrawing a seam: click vertices; s ends the seam, z undoes a click"
        return f"{text}\n{self._message}" if self._message else text

    def next_method(self) -> None:
        """Show the map of the next method."""
        self.method = self.methods[(self.methods.index(self.method) + 1) % len(self.methods)]
        self.draw()

    def iterate(self, more: int) -> None:
        """Increase the iterations of linABF by `more`; below 1, use the default number."""
        self.method, self.iterations = "linabf", max(0, self.iterations + more)
        self.draw()

    def refine(self, factor: float) -> None:
        """Multiply the number of squares of the checkerboard by `factor`."""
        self.look.frequency = float(np.clip(self.look.frequency * factor, 1, 1000))
        self.draw()

    def next_measure(self) -> None:
        """Show the next measure of distortion, or the checkerboard after the last measure."""
        every = (None, *MEASURES)
        self.look.measure = every[(every.index(self.look.measure) + 1) % len(every)]
        self.draw()

    def toggle_seams(self) -> None:
        """Show or hide the seams."""
        self.look.seams = not self.look.seams
        self.draw()

    def toggle_help(self) -> None:
        """Show or hide the help."""
        self.look.help = not self.look.help
        self.draw()

    def set_trade(self, trade: float | None) -> None:
        """Find seams with another trade of seam length for stretch; None leaves a disk uncut."""
        self.trade = trade
        self.draw()

    def toggle_drawing(self) -> None:
        """Switch between clicks that draw seams and clicks that mark points."""
        self.drawn.active, self.drawn.end = not self.drawing, None
        self.draw()

    def take_back(self) -> None:
        """Undo the last click of a drawn seam."""
        self.drawn.remove_last_path()
        self.draw()

    def save_picture(self) -> Path:
        """Save a picture of the window as a new PNG file, and return its path."""
        path = self._find_free_path(".png")
        with replacing(path) as temporary:
            self.plotter.screenshot(temporary)
        return self._report_saved(path)

    def save_mesh(self) -> Path:
        """Save the surface with its map as a new OBJ file, and return its path."""
        path = self._find_free_path(".obj")
        write_mesh(path, self._maps.V, self._maps.F, unit_square(self.shown.uv), self.shown.corners)
        return self._report_saved(path)

    def _find_free_path(self, suffix: str) -> Path:
        numbered = (Path(f"{self._save_as}-{i}{suffix}") for i in count(1))
        return next(path for path in numbered if not path.exists())

    def _report_saved(self, path: Path) -> Path:
        self._message = f"saved {path}"
        self.draw()
        self._message = ""
        return path

    def pick(self, x: int, y: int) -> None:
        """Mark the point under a pixel on surface and map, or draw a seam to the nearest vertex.

        Pixels are counted from the lower left corner.
        """
        if y < PANEL_HEIGHT:
            return
        drawn = self.shown.drawn
        side = int(x >= self.plotter.window_size[0] / 2)
        hit = pick_face(self.plotter.renderers[side], drawn.flat_scene.V if side else drawn.V, drawn.F, x, y)
        if hit is not None:
            face, weights = hit
            if self.drawing:
                self.drawn.add_vertex(int(self._maps.F[face, np.argmax(weights)]))
            else:
                self.picked = face, weights
            self.draw()

    def _draw_marks(self) -> None:
        """Draw the marked point, and the vertex where the current seam continues."""
        drawn = self.shown.drawn
        if self.picked is not None:
            face, weights = self.picked
            for side, points in enumerate((drawn.V, drawn.flat_scene.V)):
                self._add_ball(side, points, weights @ points[drawn.F[face]], MARKER_RADIUS, MARK, "mark")
        if self.drawing and self.drawn.end is not None:
            self._add_ball(0, self._maps.V, self._maps.V[self.drawn.end], SEAM_END_RADIUS, SEAM, "end")

    def _add_ball(
        self, side: int, points: FloatArray, at: FloatArray, share: float, colour: str, name: str
    ) -> None:
        self.plotter.subplot(0, side)
        ball = pv.Sphere(radius=share * np.linalg.norm(np.ptp(points, axis=0)), center=at)
        self.plotter.add_mesh(ball, color=colour, lighting=False, name=name, reset_camera=False)
        self.plotter.renderer.reset_camera_clipping_range()

    def _connect_events(self) -> None:
        keys = {
            "m": self.next_method,
            "bracketright": lambda: self.iterate(1),
            "bracketleft": lambda: self.iterate(-1),
            "Right": lambda: self.refine(1.25),
            "Left": lambda: self.refine(0.8),
            "d": self.next_measure,
            "x": self.toggle_seams,
            "h": self.toggle_help,
            "s": self.toggle_drawing,
            "z": self.take_back,
            "p": self.save_picture,
            "w": self.save_mesh,
        }
        for key, action in keys.items():
            self.plotter.add_key_event(key, partial(self.act, action))
        interactor = self.plotter.iren
        interactor.add_observer("LeftButtonPressEvent", self._handle_press)
        interactor.style.add_observer("EndInteractionEvent", self._handle_release)

    def act(self, action: Callable[[], object]) -> None:
        """Run the action of a key or slider, and render the window; an error is shown in the caption."""
        try:
            action()
        except (MeshError, OSError) as error:
            self._message = str(error)
            self.draw()
            self._message = ""
        self.plotter.render()

    def _handle_press(self, *_: object) -> None:
        self._pressed = self.plotter.iren.get_event_position()

    def _handle_release(self, *_: object) -> None:
        x, y = self.plotter.iren.get_event_position()
        if abs(x - self._pressed[0]) + abs(y - self._pressed[1]) <= MAX_CLICK_MOVEMENT:
            self.act(partial(self.pick, x, y))


def view(
    V: ArrayLike,
    F: ArrayLike,
    *,
    method: str = "linabf",
    screenshot: str | bool = False,
    off_screen: bool | None = None,
    title: str = "igl_linabf",
    **options: Any,
) -> Viewer:
    """Open a window with the surface and its flat map side by side, and wait until it is closed.

    Parameters
    ----------
    V, F : (#V, 3) float and (#F, 3) int
        Any oriented manifold surface. Surfaces other than disks (with or without holes) are unwrapped.
    method : str
        Method of the first map, as in `flatten`.
    screenshot : str or bool
        Where to save the last picture.
    off_screen : bool, optional
        If True, do not open a window; by default `pyvista.OFF_SCREEN`.
    title : str
        Title of the window.
    **options
        Options of `Viewer` (`frequency`, `measure`, `boundary`, `cones`, `window_size`) and of
        `pyvista.Plotter`.

    Returns
    -------
    Viewer

    Raises
    ------
    MeshError
        The surface cannot be flattened.
    OSError
        There is no display.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> viewer = view(V, F, off_screen=True)  # a window, without off_screen
    >>> viewer.shown.charts, viewer.shown.quality.flips
    (1, 0)
    """
    hidden = pv.OFF_SCREEN if off_screen is None else off_screen
    if not hidden and not has_display():
        raise OSError(NO_DISPLAY)
    viewer = Viewer(V, F, method=method, off_screen=hidden, **options)
    with pv.vtk_verbosity("error"):
        viewer.plotter.show(title=title, screenshot=screenshot)
    return viewer
