"""Add sliders to the window."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from ..measures import MEASURES

if TYPE_CHECKING:
    from .window import Viewer

MAX_SLIDER_ITERATIONS = 8  # maximum of the slider for the number of iterations
MAX_SLIDER_TRADE = 60.0  # maximum of the slider for `trade`
SLIDER_LETTER_HEIGHT = 0.1  # height of letters, relative to the height of the row of sliders


def add_sliders(viewer: Viewer) -> None:
    """Add the sliders for method, iterations, trade and colours to the lowest row of the window."""
    viewer.plotter.subplot(1, 0)
    colours = ("board", *MEASURES)

    def show_method(name: str) -> None:
        viewer.method = name
        viewer.draw()

    def set_iterations(value: float) -> None:
        viewer.iterate(round(value) - viewer.iterations)

    def show_colours(name: str) -> None:
        viewer.look.measure = None if name == "board" else next(m for m in MEASURES if m == name)
        viewer.draw()

    _add_choice(viewer, 0, viewer.methods, viewer.method, show_method)
    _add_number(viewer, 1, "iterations, 0: auto", MAX_SLIDER_ITERATIONS, viewer.iterations, set_iterations)
    _add_number(viewer, 2, "trade", MAX_SLIDER_TRADE, 6.0, viewer.set_trade)
    _add_choice(viewer, 3, colours, viewer.look.measure or colours[0], show_colours)


def _build_slider_options(i: int) -> dict[str, Any]:
    """Return the style of the i-th slider, and its ends as shares of the row."""
    ends = {"pointa": (0.015 + 0.1 * i, 0.45), "pointb": (0.095 + 0.1 * i, 0.45)}
    return {"style": "modern", "interaction_event": "end", **ends}


def _add_choice(
    viewer: Viewer, i: int, names: Sequence[str], now: str, chosen: Callable[[str], None]
) -> None:
    slider = viewer.plotter.add_text_slider_widget(
        _call_on_change(viewer, now, chosen),
        list(names),
        value=list(names).index(now),
        **_build_slider_options(i),
    )
    slider.GetRepresentation().SetTitleHeight(SLIDER_LETTER_HEIGHT)


def _add_number(
    viewer: Viewer, i: int, title: str, most: float, now: float, chosen: Callable[[float], None]
) -> None:
    titled = {"title": title, "fmt": "%.0f", "title_height": SLIDER_LETTER_HEIGHT}
    slider = viewer.plotter.add_slider_widget(
        _call_on_change(viewer, float(now), chosen),
        (0, most),
        value=now,
        **titled,
        **_build_slider_options(i),
    )
    slider.GetRepresentation().SetLabelHeight(SLIDER_LETTER_HEIGHT)


def _call_on_change(viewer: Viewer, now: object, chosen: Callable) -> Callable:  # type: ignore[type-arg]
    """Return a callback that calls `chosen` for each new value.

    Unchanged values are ignored, because pyvista also calls back with the initial value.
    """
    last = [now]

    def act_on_change(value: object) -> None:
        if value != last[0]:
            last[0] = value
            viewer.act(partial(chosen, value))

    return act_on_change
