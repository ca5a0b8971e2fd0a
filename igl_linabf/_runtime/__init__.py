"""Room: _runtime."""

from . import progress
from .child_process import Arrays, run_apart, serve
from .cleanup import undone_at_once
from .progress import Progress, advance, part, reporting
from .stopwatch import stopwatch, timed
from .text import aligned

__all__ = [
    "Arrays",
    "Progress",
    "advance",
    "aligned",
    "part",
    "progress",
    "reporting",
    "run_apart",
    "serve",
    "stopwatch",
    "timed",
    "undone_at_once",
]
