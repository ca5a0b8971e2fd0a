"""Room: _runtime."""

from .child_process import Arrays, run_apart, serve
from .cleanup import undone_at_once
from .progress import Progress, advance, part, reporting
from .text import aligned
from .timing import stopwatch, timed

__all__ = [
    "Arrays",
    "Progress",
    "advance",
    "aligned",
    "part",
    "reporting",
    "run_apart",
    "serve",
    "stopwatch",
    "timed",
    "undone_at_once",
]
