"""The command `igl-linabf`.

It takes a command line and returns an exit code. Maps go to files, tables to stdout, and each warning or
error is one line on stderr.
"""

from .parser import main
