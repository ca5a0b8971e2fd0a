"""A window with the surface and its flat map side by side. Needs pyvista.

A click on either side marks the same point on both, or draws a seam. The sliders and keys below change the
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
from ..errors import MeshError
from ..flattening import METHODS, BoundaryName
from ..io import replacing, unit_square, write_mesh
from ..measures import MEASURES, Measure
from ..surface import face_array, vertex_array
from .constants import CLICK_MOVES, MARKER_RADIUS, PANEL_HEIGHT, SEAM_END_RADIUS
from .displays import NO_DISPLAY, has_display
from .drawn_seams import DrawnSeams
from .picking import hit_at
from .reused_maps import MapRequest, ReusedMaps, Shown
from .scene import SEAM, add_cut, add_flat, add_surface, board, distortions, face_the_camera
from .sliders import add_sliders

NAMES = {"lscm": "igl.lscm", "linabf": "linABF", "abf": "ABF"}
MARK = "#e815c4"
HELP = (
    """\
click  marks a point on both
s      draws seams by clicks;
       its end again: ends it
z      takes a click back""",
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
class Look:
    """What the window shows of a map.

    Attributes
    ----------
    frequency : float
        Squares of the checkerboard along the longer side of the map.
    measure : {"angle", "conformal", "stretch", "area"} or None
        The distortion that is shown instead of the checkerboard.
    seams, help : bool
        Whether the seams, and the help, are shown.
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
        Any oriented manifold surface; anything but a disk (with or without holes) is unwrapped.
    method : {"linabf", "lscm", "abf"} or another method of `flatten`
        The first method shown.
    frequency : float
        Squares of the checkerboard along the longer side of the map.
    measure : {"angle", "conformal", "stretch", "area"}, optional
        Distortion to show instead of the checkerboard.
    boundary : {"free", "circle", "circles", "rectangle"}
        Of the maps of methods that can shape it, as in `flatten`.
    cones : int or "auto", optional
        How many cones each component gets, as in `unwrap`, by the methods that can. With seams of another
        trade, or drawn ones, there are none.
    off_screen : bool
        Open no window.
    window_size : (int, int)
        Width and height in pixels; the lowest 130 are for the sliders and the help.
    save_as : path
        What saved files are called, before their number: igl_linabf-1.png, igl_linabf-1.obj.
    **options
        Options of `pyvista.Plotter`.

    Attributes
    ----------
    plotter : pyvista.Plotter
    iterations : int
        Iterations of linABF; 0 is its default, "auto".
    trade : float or None
        Of seam length for stretch; None leaves a disk uncut.
    picked : (int, (3,) float64) or None
        Face and barycentric coordinates of the marked point.
    drawn : DrawnSeams
        The seams that were drawn.
    look : Look
        Checkerboard or distortion, seams, help.
    """

    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
        method: str = "linabf",
        *,
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
        self.methods = list(dict.fromkeys((*NAMES, method)))
        self.method, self.iterations, self.look = method, 0, Look(frequency, measure)
        self.trade: float | None = None
        self.picked: tuple[int, FloatArray] | None = None
        self._maps = ReusedMaps(vertex_array(V), face_array(F), boundary, cones)
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
        face_the_camera(self.plotter, shown.drawn.V, shown.drawn.F)
        self.plotter.camera.zoom(0.92)  # below the caption
        if not off_screen:
            add_sliders(self)
            self._listen()

    @property
    def drawing(self) -> bool:
        """Whether clicks draw seams."""
        return self.drawn.active

    @property
    def shown(self) -> Shown:
        """The map of what is set at present, computed on first use."""
        iterations = self.iterations if self.method == "linabf" else 0
        return self._maps.map_for(MapRequest(self.method, iterations, self.trade, self.drawn.edges))

    def draw(self) -> None:
        """Redraw both sides; the camera of the surface stays."""
        drawn = self.shown.drawn
        look = self.look
        colours = board(look.frequency) if look.measure is None else distortions([drawn], look.measure)[0]
        self.plotter.suppress_rendering = True  # each addition would render
        for title in tuple(self.plotter.scalar_bars.keys()):
            self.plotter.remove_scalar_bar(title)
        for side in (0, 1):  # the sliders stay
            self.plotter.renderers[side].clear_actors()
        self.plotter.subplot(0, 0)
        add_surface(self.plotter, drawn, **colours, show_scalar_bar=False, reset_camera=False)
        if self.look.seams:
            add_cut(self.plotter, drawn, reset_camera=False)
        self.plotter.add_text(self.caption, font_size=10)
        self.plotter.subplot(0, 1)
        add_flat(self.plotter, drawn.flat, **colours)
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
        self._mark()
        self.plotter.suppress_rendering = False

    @property
    def caption(self) -> str:
        """The caption of the window."""
        q, name = self.shown.quality, NAMES.get(self.method, self.method)
        if self.method == "linabf" and self.iterations:
            name += f", {self.iterations} iteration{'s' * (self.iterations > 1)}"
        said = f"{name}: F/3nt {q.angle_distortion:.3g}, L2 stretch {q.stretch_l2:.3g}, {q.flips} flipped"
        if self.shown.charts > 1:
            said += f", {self.shown.charts} charts"
        if self.picked is not None:
            face, weights = self.picked
            drawn = self.shown.drawn
            u, v = weights @ drawn.uv[drawn.F[face]]
            x, y, z = weights @ self._maps.V[self._maps.F[face]]
            said += f"\nface {face}: ({x:.4g}, {y:.4g}, {z:.4g}) -> ({u:.4g}, {v:.4g})"
        if self.drawing:
            said += "\ndrawing a seam: click vertices; s ends, z takes back"
        return f"{said}\n{self._message}" if self._message else said

    def next_method(self) -> None:
        self.method = self.methods[(self.methods.index(self.method) + 1) % len(self.methods)]
        self.draw()

    def iterate(self, more: int) -> None:
        """Change the iterations of linABF by `more`; below 1, its default."""
        self.method, self.iterations = "linabf", max(0, self.iterations + more)
        self.draw()

    def refine(self, factor: float) -> None:
        """Multiply the number of squares by `factor`."""
        self.look.frequency = float(np.clip(self.look.frequency * factor, 1, 1000))
        self.draw()

    def next_measure(self) -> None:
        every = (None, *MEASURES)
        self.look.measure = every[(every.index(self.look.measure) + 1) % len(every)]
        self.draw()

    def toggle_seams(self) -> None:
        self.look.seams = not self.look.seams
        self.draw()

    def toggle_help(self) -> None:
        self.look.help = not self.look.help
        self.draw()

    def set_trade(self, trade: float | None) -> None:
        """Find seams anew, with this trade of their length for stretch; None leaves a disk uncut."""
        self.trade = trade
        self.draw()

    def toggle_drawing(self) -> None:
        """Clicks draw seams, or mark points again."""
        self.drawn.active, self.drawn.end = not self.drawing, None
        self.draw()

    def take_back(self) -> None:
        """Take the last click of a drawn seam back."""
        self.drawn.back()
        self.draw()

    def save_picture(self) -> Path:
        """Save both sides as a PNG that does not replace a file; its path."""
        path = self._free_path(".png")
        with replacing(path) as temporary:
            self.plotter.screenshot(temporary)
        return self._report_saved(path)

    def save_mesh(self) -> Path:
        """Save the surface with its map as an OBJ that does not replace a file; its path."""
        path = self._free_path(".obj")
        write_mesh(path, self._maps.V, self._maps.F, unit_square(self.shown.uv), self.shown.corners)
        return self._report_saved(path)

    def _free_path(self, suffix: str) -> Path:
        numbered = (Path(f"{self._save_as}-{i}{suffix}") for i in count(1))
        return next(path for path in numbered if not path.exists())

    def _report_saved(self, path: Path) -> Path:
        self._message = f"saved {path}"
        self.draw()
        self._message = ""
        return path

    def pick(self, x: int, y: int) -> None:
        """Mark the point under a pixel on both sides, or draw a seam to the vertex nearest to it.

        Pixels count from the lower left.
        """
        if y < PANEL_HEIGHT:
            return
        drawn = self.shown.drawn
        side = int(x >= self.plotter.window_size[0] / 2)
        hit = hit_at(self.plotter.renderers[side], drawn.flat.V if side else drawn.V, drawn.F, x, y)
        if hit is not None:
            face, weights = hit
            if self.drawing:
                self.drawn.to(int(self._maps.F[face, np.argmax(weights)]))
            else:
                self.picked = face, weights
            self.draw()

    def _mark(self) -> None:
        """The point that is picked, and the vertex at which the seam goes on."""
        drawn = self.shown.drawn
        if self.picked is not None:
            face, weights = self.picked
            for side, points in enumerate((drawn.V, drawn.flat.V)):
                self._ball(side, points, weights @ points[drawn.F[face]], MARKER_RADIUS, MARK, "mark")
        if self.drawing and self.drawn.end is not None:
            self._ball(0, self._maps.V, self._maps.V[self.drawn.end], SEAM_END_RADIUS, SEAM, "end")

    def _ball(
        self, side: int, points: FloatArray, at: FloatArray, share: float, colour: str, name: str
    ) -> None:
        self.plotter.subplot(0, side)
        ball = pv.Sphere(radius=share * np.linalg.norm(np.ptp(points, axis=0)), center=at)
        self.plotter.add_mesh(ball, color=colour, lighting=False, name=name, reset_camera=False)
        self.plotter.renderer.reset_camera_clipping_range()

    def _listen(self) -> None:
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
        interactor.add_observer("LeftButtonPressEvent", self._press)
        interactor.style.add_observer("EndInteractionEvent", self._release)

    def act(self, action: Callable[[], object]) -> None:
        """Run an action of a key or slider, and show what has changed; an error is a line in the caption."""
        try:
            action()
        except (MeshError, OSError) as error:
            self._message = str(error)
            self.draw()
            self._message = ""
        self.plotter.render()

    def _press(self, *_: object) -> None:
        self._pressed = self.plotter.iren.get_event_position()

    def _release(self, *_: object) -> None:
        x, y = self.plotter.iren.get_event_position()
        if abs(x - self._pressed[0]) + abs(y - self._pressed[1]) <= CLICK_MOVES:
            self.act(partial(self.pick, x, y))


def view(
    V: ArrayLike,
    F: ArrayLike,
    method: str = "linabf",
    *,
    screenshot: str | bool = False,
    off_screen: bool | None = None,
    title: str = "igl_linabf",
    **options: Any,
) -> Viewer:
    """Open a window with the surface and its flat map side by side, and wait until it is closed.

    Parameters
    ----------
    V, F : (#V, 3) float and (#F, 3) int
        Any oriented manifold surface; anything but a disk (with or without holes) is unwrapped.
    method : str
        The first method shown, as in `flatten`.
    screenshot : str or bool
        Where to save the last picture.
    off_screen : bool, optional
        Open no window; by default `pyvista.OFF_SCREEN`.
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
    viewer = Viewer(V, F, method, off_screen=hidden, **options)
    with pv.vtk_verbosity("error"):
        viewer.plotter.show(title=title, screenshot=screenshot)
    return viewer
