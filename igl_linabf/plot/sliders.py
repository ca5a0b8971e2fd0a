"""The sliders below the window's two sides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from ..measures import MEASURES
from .constants import MAX_SLIDER_ITERATIONS, MAX_SLIDER_TRADE, SLIDER_LETTERS

if TYPE_CHECKING:
    from .window import Viewer


def add_sliders(viewer: Viewer) -> None:
    """Method, iterations, trade and colouring, in the window's lowest row."""
    viewer.plotter.subplot(1, 0)
    colours = ("board", *MEASURES)

    def method(name: str) -> None:
        viewer.method = name
        viewer.draw()

    def iterate(value: float) -> None:
        viewer.iterate(round(value) - viewer.iterations)

    def colour(name: str) -> None:
        viewer.look.measure = None if name == "board" else next(m for m in MEASURES if m == name)
        viewer.draw()

    _choice(viewer, 0, viewer.methods, viewer.method, method)
    _number(viewer, 1, "iterations, 0: auto", MAX_SLIDER_ITERATIONS, viewer.iterations, iterate)
    _number(viewer, 2, "trade", MAX_SLIDER_TRADE, 6.0, viewer.set_trade)
    _choice(viewer, 3, colours, viewer.look.measure or colours[0], colour)


def _look(i: int) -> dict[str, Any]:
    """How the i-th slider looks, and its ends in shares of the row."""
    ends = {"pointa": (0.015 + 0.1 * i, 0.45), "pointb": (0.095 + 0.1 * i, 0.45)}
    return {"style": "modern", "interaction_event": "end", **ends}


def _choice(viewer: Viewer, i: int, names: Sequence[str], now: str, chosen: Callable[[str], None]) -> None:
    slider = viewer.plotter.add_text_slider_widget(
        _changed(viewer, now, chosen), list(names), value=list(names).index(now), **_look(i)
    )
    slider.GetRepresentation().SetTitleHeight(SLIDER_LETTERS)


def _number(
    viewer: Viewer, i: int, title: str, most: float, now: float, chosen: Callable[[float], None]
) -> None:
    titled = {"title": title, "fmt": "%.0f", "title_height": SLIDER_LETTERS}
    slider = viewer.plotter.add_slider_widget(
        _changed(viewer, float(now), chosen), (0, most), value=now, **titled, **_look(i)
    )
    slider.GetRepresentation().SetLabelHeight(SLIDER_LETTERS)


def _changed(viewer: Viewer, now: object, chosen: Callable) -> Callable:  # type: ignore[type-arg]
    """Calls `chosen` with each value that is another one: pyvista calls at once with the first, too."""
    last = [now]

    def call(value: object) -> None:
        if value != last[0]:
            last[0] = value
            viewer.act(partial(chosen, value))

    return call
