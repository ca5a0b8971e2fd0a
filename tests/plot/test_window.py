"""The window `igl-linabf view`, tested by key presses, clicks and pixels of an X server."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import igl
import numpy as np
import pytest
import pyvista as pv
from conftest import load, read_pixels
from high_curvature import crown, rings
from own_measures import measure_circle_error
from pixels import count_square_changes, find_colour, locate_in_colour_map

from igl_linabf import MeshError
from igl_linabf.io import read_texture
from igl_linabf.plot import MARK, SEAM, WARNING, Viewer, view
from igl_linabf.plot.drawn_seams import DrawnSeams

SIZE = (1400, 830)
SIDES = 700  # height in pixels of the surface and the map; the sliders and the help are below
PATIENCE = 300  # longest time in seconds to wait for a change of the window


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """Start a private X server, and yield the name of its display."""
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed")
    pytest.importorskip("Xlib", reason="python-xlib is not installed")
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1400x900x24", "-nolisten", "tcp"]
    process = subprocess.Popen(command, pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with open(read, encoding="utf-8") as answer:
        number = answer.readline().strip()
    if not number:
        pytest.skip("Xvfb does not start here")
    yield f":{number}"
    process.terminate()
    process.wait()


class Window:
    """A running `igl-linabf view` that is operated like a user would."""

    def __init__(self, display: str, mesh: Path, *options: str) -> None:
        from Xlib.display import Display

        command = [sys.executable, "-m", "igl_linabf", "view", str(mesh), *options]
        self.process = subprocess.Popen(
            command, env={**os.environ, "DISPLAY": display}, stderr=subprocess.PIPE, encoding="utf-8"
        )
        self.display = Display(display)
        self.title = f"igl_linabf: {mesh.name}"

    def wait(self) -> None:
        """Wait until the window is open and shows the mesh."""
        end = time.monotonic() + PATIENCE
        while (window := self._find()) is None:
            assert self.process.poll() is None, self.process.stderr.read()
            assert time.monotonic() < end, f"there is no window {self.title!r}"
            time.sleep(0.1)
        self.window = window
        self.until(lambda image: 0.05 < (image.sum(axis=2) < 700).mean() < 0.95)

    def _find(self):
        from Xlib.error import BadWindow

        for window in self.display.screen().root.query_tree().children:
            with suppress(BadWindow):  # VTK destroys a window of its own while it opens this one
                if window.get_wm_name() == self.title and window.get_attributes().map_state:
                    return window
        return None

    def image(self) -> np.ndarray:
        from Xlib import X

        form = self.window.get_geometry()
        data = self.window.get_image(0, 0, form.width, form.height, X.ZPixmap, 0xFFFFFFFF).data
        return np.frombuffer(data, np.uint8).reshape(form.height, form.width, 4)[..., 2::-1].astype(int)

    def until(self, holds: Callable[[np.ndarray], bool]) -> np.ndarray:
        """Wait until the picture of the window is stable and satisfies a condition; return the picture."""
        end = time.monotonic() + PATIENCE
        last = self.image()
        while True:
            time.sleep(0.2)
            image = self.image()
            if (image == last).all() and holds(image):
                return image
            last = image
            assert self.process.poll() is None, self.process.stderr.read()
            assert time.monotonic() < end, "the window does not show it"

    def key(self, name: str) -> None:
        from Xlib import XK, X
        from Xlib.ext import xtest

        self.window.set_input_focus(X.RevertToParent, X.CurrentTime)
        code = self.display.keysym_to_keycode(XK.string_to_keysym(name))
        for event in (X.KeyPress, X.KeyRelease):
            xtest.fake_input(self.display, event, code)
        self.display.sync()

    def drag(self, start: tuple[int, int], *way: tuple[int, int]) -> None:
        """Press a mouse button at a pixel, move along a path, and release; without a path, click."""
        from Xlib import X
        from Xlib.ext import xtest

        self._move(start)
        xtest.fake_input(self.display, X.ButtonPress, 1)
        for place in way:
            self._move(place)
        xtest.fake_input(self.display, X.ButtonRelease, 1)
        self.display.sync()

    def _move(self, place: tuple[int, int]) -> None:
        from Xlib import X
        from Xlib.ext import xtest

        form = self.window.get_geometry()
        xtest.fake_input(self.display, X.MotionNotify, x=form.x + place[0], y=form.y + place[1])
        self.display.sync()

    def close(self) -> None:
        self.process.kill()
        self.process.communicate()
        self.display.close()


@pytest.fixture
def opened(server, tmp_path) -> Iterator[Callable[..., Window]]:
    windows = []

    def open_window(V: np.ndarray, F: np.ndarray, *options: str) -> Window:
        igl.write_triangle_mesh(str(tmp_path / "mesh.ply"), V, F)
        windows.append(Window(server, tmp_path / "mesh.ply", *options))  # closed even if it does not open
        windows[-1].wait()
        return windows[-1]

    yield open_window
    for window in windows:
        window.close()


def find_marks(image: np.ndarray) -> list[np.ndarray | None]:
    """Return column and row of the mark on the surface (left) and on the map (right), or None."""
    found = []
    for left in (0, SIZE[0] // 2):
        rows, columns = np.nonzero(find_colour(image[:, left : left + SIZE[0] // 2], MARK, 30))
        found.append(np.array([columns.mean() + left, rows.mean()]) if len(rows) > 20 else None)
    return found


def flat(image: np.ndarray) -> np.ndarray:
    return image[:SIDES, SIZE[0] // 2 :]


def is_coloured(image: np.ndarray) -> bool:
    """Return True if the map shows a distortion, in colours that differ from the blue of the checkerboard."""
    return bool((locate_in_colour_map(flat(image)[300:400, 100:600], "viridis") > 0.5).mean() > 0.2)


def has_both_marks(image: np.ndarray) -> bool:
    return all(place is not None for place in find_marks(image))


@pytest.mark.slow
def test_keys_change_frequency_distortion_help_and_quit(opened) -> None:
    window = opened(*load("bumps"))
    before = count_square_changes(flat(window.image()))
    assert before > 20
    for _ in range(4):
        window.key("Left")
    fewer = window.until(lambda image: count_square_changes(flat(image)) < 0.5 * before)
    window.key("Right")
    window.until(lambda image: count_square_changes(flat(image)) > count_square_changes(flat(fewer)))
    assert not is_coloured(fewer)
    window.key("d")
    window.until(is_coloured)
    for _ in range(3):
        window.key("d")  # conformal, stretch, area (brown over white to green)
    window.until(
        lambda image: np.isfinite(locate_in_colour_map(flat(image)[300:400, 100:600], "BrBG")).mean() > 0.8
    )
    window.key("d")
    before = window.until(lambda image: count_square_changes(flat(image)) > 5)
    assert find_colour(before[SIDES:], "black", 60).sum() > 500
    window.key("h")
    after = window.until(lambda image: find_colour(image[SIDES:, 600:], "black", 60).sum() < 10)
    assert (after[:SIDES] == before[:SIDES]).all()  # hiding the help does not change the picture
    window.key("q")
    assert window.process.wait(timeout=PATIENCE) == 0
    assert window.process.stderr.read() == ""


@pytest.mark.slow
def test_keys_change_the_method_and_flips_are_shown(opened) -> None:
    window = opened(*rings(40, crown))
    assert not find_colour(window.image(), WARNING).any()  # the map of linABF has no flips
    window.key("m")
    window.key("m")  # from linABF to ABF, then to igl.lscm, which flips triangles
    window.until(lambda image: find_colour(image, WARNING).sum() > 100)
    window.key("bracketright")  # linABF with one iteration has no flips
    window.until(lambda image: not find_colour(image, WARNING).any())


@pytest.mark.slow
def test_a_click_marks_the_same_point_on_both_sides(opened) -> None:
    window = opened(*load("bumps"))
    left = np.array([300, 400])
    window.drag(tuple(left))
    first = find_marks(window.until(has_both_marks))
    assert np.abs(first[0] - left).max() < 6
    # a click on the mark in the map marks the same point on the surface
    elsewhere = (SIZE[0] * 3 // 4 + 80, 300)
    window.drag(elsewhere)
    second = find_marks(
        window.until(lambda im: has_both_marks(im) and np.abs(find_marks(im)[1] - elsewhere).max() < 6)
    )
    assert np.abs(second[0] - first[0]).max() > 20
    window.drag(tuple(np.round(first[1]).astype(int)))
    back = find_marks(
        window.until(lambda im: has_both_marks(im) and np.abs(find_marks(im)[1] - first[1]).max() < 3)
    )
    assert np.abs(back[0] - first[0]).max() < 6
    # rotating the surface neither moves the mark nor sets a new one
    before = window.image()
    window.drag((300, 400), (360, 405), (420, 410))
    turned = window.until(lambda im: (np.abs(im - before)[60:, :700].max(axis=2) > 60).mean() > 0.05)
    assert has_both_marks(turned)
    assert np.abs(find_marks(turned)[1] - back[1]).max() < 2
    # changing the colours keeps the mark
    window.key("d")
    window.until(is_coloured)
    assert has_both_marks(window.image())


@pytest.mark.slow
def test_sliders_change_method_iterations_trade_and_colours(opened) -> None:
    window = opened(*rings(40, crown))
    y = 772
    window.drag((77, y), (55, y), (40, y))  # moves the slider of the method from linABF to igl.lscm
    window.until(lambda image: find_colour(image, WARNING).sum() > 100)
    window.drag((189, y), (205, y))  # moves the slider of the iterations, which selects linABF
    window.until(lambda image: not find_colour(image, WARNING).any())
    assert not is_coloured(window.image())
    window.drag((469, y), (490, y))
    window.until(is_coloured)
    window.drag((334, y), (385, y))
    window.until(lambda image: find_colour(image[60:SIDES, : SIZE[0] // 2], SEAM).sum() > 100)


@pytest.mark.slow
def test_seams_are_drawn_by_clicks_and_undone(opened) -> None:
    window = opened(*load("bumps"))
    before = window.image()
    window.key("s")
    window.until(lambda image: (image != before)[:60].any())
    window.drag((250, 400))
    one = window.until(lambda image: find_colour(image[60:SIDES, :700], SEAM).sum() > 20)
    window.drag((430, 330))
    two = window.until(lambda image: find_colour(image[60:SIDES, :700], SEAM).sum() > 300)
    assert (flat(two) != flat(one)).any(axis=2).mean() > 0.05  # the map follows the drawn seam
    window.key("z")
    window.until(lambda image: find_colour(image[60:SIDES, :700], SEAM).sum() < 300)


@pytest.mark.filterwarnings("ignore:.* edges are cut in addition to the given seams")
def test_a_drawn_seam_is_the_shortest_path_and_cuts_the_map() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 3)
    V, F, *_ = igl.remove_unreferenced(V, F[V[F].mean(axis=1)[:, 2] < 0.5])
    viewer = Viewer(V, F, off_screen=True)
    whole = viewer.shown
    viewer.toggle_drawing()
    ends = [int(np.argmin(np.linalg.norm(V - at, axis=1))) for at in ([1, 0, 0], [0, 0, -1], [-1, 0, 0])]
    for vertex in ends:
        viewer.drawn.add_vertex(vertex)
    length = sum(np.linalg.norm(V[a] - V[b]) for a, b in viewer.drawn.edges)
    assert np.pi < length < 1.1 * np.pi  # a path along edges, near two quarters of a great circle
    cut = viewer.shown
    assert (
        len(cut.uv) == len(whole.uv) + len(viewer.drawn.edges) - 1
    )  # the interior vertices of the path are duplicated
    viewer.take_back()
    assert len(viewer.drawn.paths) == 1
    assert viewer.drawn.end == ends[1]  # the next click continues at the end of the remaining path
    viewer.take_back()
    assert viewer.drawn.edges == ()
    assert viewer.drawn.end == ends[0]
    assert viewer.shown is whole


def test_a_seam_ends_at_its_last_vertex_and_between_components() -> None:
    V, F = igl.icosahedron()
    two = DrawnSeams(np.concatenate((V, V + 5)), np.concatenate((F, F + len(V))))
    first, second = F[0, :2].tolist()
    for vertex in (first, second, second):  # a second click on the last vertex ends the seam
        two.add_vertex(vertex)
    assert two.end is None
    assert two.edges == ((min(first, second), max(first, second)),)
    two.add_vertex(first)
    two.add_vertex(int(F[0, 0]) + len(V))  # a vertex of another component starts a new seam
    assert two.end == F[0, 0] + len(V)
    assert len(two.paths) == 1


def test_a_click_marks_the_visible_side() -> None:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    viewer = Viewer(V, F, off_screen=True)
    viewer.plotter.show(auto_close=False)
    renderer, drawn = viewer.plotter.renderers[0], viewer.shown.drawn
    towards = -np.array(renderer.camera.direction)
    middle = drawn.V[drawn.F].mean(axis=1)
    face = int(np.argmax(middle @ (towards + np.array([0.2, 0.1, 0]))))  # a face to the side of the view axis
    renderer.SetWorldPoint(*middle[face], 1.0)
    renderer.WorldToDisplay()
    x, y, _ = renderer.GetDisplayPoint()
    viewer.pick(round(x), round(y))
    assert viewer.picked is not None
    picked, weights = viewer.picked
    assert np.linalg.norm(weights @ drawn.V[drawn.F[picked]] - middle[face]) < 0.05
    viewer.plotter.close()


def test_saved_files_get_new_names(tmp_path) -> None:
    V, F = load("bumps")
    viewer = Viewer(V, F, off_screen=True, save_as=tmp_path / "bumps")
    viewer.plotter.show(auto_close=False)
    assert [viewer.save_mesh().name for _ in range(2)] == ["bumps-1.obj", "bumps-2.obj"]
    assert read_pixels(viewer.save_picture()).shape[:2] == SIZE[::-1]
    TC, FTC = read_texture(tmp_path / "bumps-1.obj")
    uv = viewer.shown.uv - viewer.shown.uv.min(axis=0)
    assert np.allclose(TC[FTC], (uv / uv.max())[F])
    viewer.plotter.close()
    missing = Viewer(V, F, off_screen=True, save_as=tmp_path / "none" / "bumps")
    missing.act(missing.save_mesh)  # the window shows the error instead of raising an exception
    assert not (tmp_path / "none").exists()
    missing.plotter.close()


@pytest.mark.slow
def test_a_closed_surface_is_unwrapped_and_its_seams_drawn(opened) -> None:
    window = opened(*igl.upsample(*igl.icosahedron(), 3))
    image = window.until(lambda image: find_colour(image[60:, : SIZE[0] // 2], SEAM).sum() > 300)
    seams = find_colour(image[60:, : SIZE[0] // 2], SEAM).sum()
    window.key("x")
    window.until(lambda image: find_colour(image[60:, : SIZE[0] // 2], SEAM).sum() < seams / 4)


@pytest.mark.parametrize(
    "display",
    [
        {},
        *(
            pytest.param(x, marks=pytest.mark.slow)
            for x in ({"DISPLAY": ":4711"}, {"WAYLAND_DISPLAY": "wayland-9"})
        ),
    ],
)
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
def test_a_missing_display_is_one_sentence(tmp_path, display) -> None:
    igl.write_triangle_mesh(str(tmp_path / "mesh.ply"), *load("bumps"))
    kept = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-m", "igl_linabf", "view", str(tmp_path / "mesh.ply")]
    process = subprocess.run(
        command, env=kept | display, capture_output=True, encoding="utf-8", timeout=PATIENCE
    )
    assert process.returncode == 2
    lines = [line for line in process.stderr.splitlines() if "scikit-sparse is not" not in line]
    assert len(lines) == 1
    assert "there is no display" in lines[0]


def test_a_screenshot_needs_no_display(tmp_path) -> None:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    two = np.concatenate((V, V + np.array([3, 0, 0]))), np.concatenate((F, F + len(V)))  # two closed pieces
    igl.write_triangle_mesh(str(tmp_path / "mesh.ply"), *two)
    path = tmp_path / "shot.png"
    command = ["view", str(tmp_path / "mesh.ply"), "--screenshot", str(path), "--method", "lscm"]
    environment = {k: v for k, v in os.environ.items() if "DISPLAY" not in k}
    subprocess.run([sys.executable, "-m", "igl_linabf", *command], env=environment, check=True)
    image = read_pixels(path)
    assert image.shape[:2] == SIZE[::-1]
    assert find_colour(image[60:, : SIZE[0] // 2], SEAM).sum() > 200
    assert max(count_square_changes(flat(image)[row : row + 2]) for row in range(60, SIDES, 40)) > 10


def test_maps_are_cached_and_aligned(monkeypatch) -> None:
    V, F = load("bumps")
    viewer = Viewer(V, F, off_screen=True)
    maps = {}
    for _ in range(3):
        maps[viewer.method] = viewer.shown
        viewer.next_method()
    assert set(maps) == {"lscm", "linabf", "abf"}
    assert viewer.shown is maps["linabf"]
    others = [shown.drawn.uv - maps["linabf"].drawn.uv for shown in maps.values()]
    assert max(np.abs(away).max() for away in others) < 0.2 * np.ptp(maps["linabf"].drawn.uv)
    assert [np.abs(away).max() > 0 for away in others].count(True) == 2
    viewer.iterate(1)
    assert "1 iteration:" in viewer.caption
    once = viewer.shown
    viewer.iterate(1)
    assert "2 iterations:" in viewer.caption
    assert viewer.shown is not once
    viewer.iterate(-2)
    assert viewer.shown is maps["linabf"]
    viewer.plotter.close()


def test_boundaries_and_cones_are_shown_for_methods_that_support_them() -> None:
    V, F = load("bumps")
    viewer = Viewer(V, F, method="lscm", boundary="circle", off_screen=True)
    loop = igl.boundary_loop(F)
    off = {}
    for _ in range(2):
        off[viewer.method] = measure_circle_error(viewer.shown.uv[loop])
        viewer.next_method()
    viewer.plotter.close()
    assert off["linabf"] < 1e-6 < off["lscm"]
    ball = Viewer(*igl.upsample(*igl.icosahedron(), 2), cones=4, off_screen=True)
    coned = ball.shown.drawn
    assert len(coned.cones) == 4
    assert coned.sides is not None
    ball.set_trade(1.0)
    assert len(ball.shown.drawn.cones) == 0
    ball.plotter.close()
    with pytest.raises(ValueError, match="leave out boundary or cones"):
        Viewer(V, F, boundary="circle", cones=4, off_screen=True)


def test_invalid_arguments_of_the_window_are_refused() -> None:
    V, F = load("bumps")
    with pytest.raises(ValueError, match="method is 'magic'"):
        view(V, F, method="magic", off_screen=True)
    with pytest.raises(MeshError, match="the same triangle"):
        view(V, np.vstack((F, F[:1])), off_screen=True)
    assert pv.OFF_SCREEN is False
