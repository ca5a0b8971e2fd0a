"""What any computation may need around it: in come callbacks and files, out comes nothing half done.

Progress as a callback or a bar; what Ctrl-C has to undo, and files that are whole or not there; work in child
processes, for code that may crash or hang; tables as text.
"""

from .child_process import Arrays, run_as_child_process, run_in_child_process
from .cleanup import replacing, undone_at_once
from .progress import Progress, advance, part, reporting
from .tally import counting
from .text import aligned
from .timing import stopwatch, timed
