"""The command `igl-linabf`.

In: a command line. Out: files, text on stdout, one line on stderr for each warning or error, an exit code.
"""

from .parser import main
