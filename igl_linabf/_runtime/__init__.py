"""Room: _runtime."""

from .child_process import Arrays, run_apart, serve
from .cleanup import replacing, undone_at_once
from .progress import Progress, advance, part, reporting
from .text import aligned

__all__ = [
    "Arrays",
    "Progress",
    "advance",
    "aligned",
    "part",
    "replacing",
    "reporting",
    "run_apart",
    "serve",
    "undone_at_once",
]
