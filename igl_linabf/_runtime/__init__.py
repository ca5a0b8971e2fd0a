"""Infrastructure for computations: progress, cleanup, child processes, threads, timing and text tables.

Progress is reported to a callback or a progress bar. Cleanup undoes incomplete work on Ctrl-C, so that files
are written completely or not at all. Child processes run code that may crash or hang.
"""

from .child_process import Arrays, run_as_child_process, run_in_child_process
from .cleanup import replacing, replacing_folder, undo_at_interrupt
from .progress import Progress, advance, counting, progress_part, reporting, stopwatch, timed
from .text import aligned
from .threads import in_threads
