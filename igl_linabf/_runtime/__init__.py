"""Support computations: progress, cleanup, child processes, threads, timing and text tables.

Progress is reported to a callback or a progress bar. Cleanup undoes incomplete work on Ctrl-C, so that files
are written completely or not at all. Child processes run code that may crash or hang.
"""

from .child_process import Arrays, run_as_child_process, run_in_child_process
from .cleanup import replacing, replacing_folder, undo_at_interrupt
from .progress import Progress, advance, count_steps, progress_part, show_progress, stopwatch, time_stage
from .text import align_columns
from .threads import map_in_threads
