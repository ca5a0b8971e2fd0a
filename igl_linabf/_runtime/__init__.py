"""Support for computations: progress, cleanup, child processes, threads, timing, text tables.

Progress goes to a callback or a bar. Cleanup undoes work at Ctrl-C; files are written completely or not at
all. Child processes run code that may crash or hang.
"""

from .child_process import Arrays, run_as_child_process, run_in_child_process
from .cleanup import replacing, undo_at_interrupt
from .progress import Progress, advance, counting, progress_part, reporting, stopwatch, timed
from .text import aligned
from .threads import in_threads
