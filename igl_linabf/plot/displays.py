"""Check whether a window can be opened."""

from __future__ import annotations

import os
import sys

NO_DISPLAY = "there is no display to open a window on: set DISPLAY, or write a picture instead (--screenshot)"


def has_display() -> bool:
    """Return True if there is a display to open a window on. Without one, VTK may end the process.

    Returns
    -------
    bool
        Determined from environment variables; the display itself is not opened.

    Examples
    --------
    >>> import igl
    >>> from igl_linabf.plot import Viewer
    >>> V, F = igl.icosahedron()
    >>> viewer = Viewer(V, F, off_screen=not has_display())
    """
    names = ("DISPLAY", "WAYLAND_DISPLAY")
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in names)
