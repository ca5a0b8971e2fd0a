"""Entry of the command: Ctrl-C ends it with one line also while the libraries are imported."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn

INTERRUPTED = 130


def _stop(*_: object) -> NoReturn:
    os.write(2, b"igl-linabf: interrupted\n")
    os._exit(INTERRUPTED)  # an exception would become that of whatever import it interrupts


def main() -> int:
    """Run `igl-linabf`; the exit codes are those of `igl_linabf.cli.main`."""
    ignored = signal.getsignal(signal.SIGINT) == signal.SIG_IGN  # in the background of a shell script
    if not ignored:
        signal.signal(signal.SIGINT, _stop)
    from igl_linabf import cli

    code = cli.main()
    if code == INTERRUPTED:
        os._exit(code)  # what a library was in the middle of may crash when it is taken down
    if not ignored:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is done, and its files are in their places
    return code


if __name__ == "__main__":
    sys.exit(main())
