"""Entry point of the command `igl-linabf`, which Ctrl-C ends at once with one line of text.

Only the standard library is imported before `main` handles the signal. The package's `__init__` imports a
room when one of its names is first used.
"""

import os
import signal
import sys
from functools import partial
from typing import NoReturn

INTERRUPTED = 130  # exit code after Ctrl-C


def _stop(*_: object) -> NoReturn:
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        undo_all = getattr(sys.modules.get("igl_linabf._runtime.cleanup"), "undo_all", None)
        if undo_all is not None:  # the module has been imported
            undo_all()
        os.write(2, b"igl-linabf: interrupted\n")
    finally:
        os._exit(INTERRUPTED)  # an ordinary shutdown may crash inside an interrupted library


def main() -> int:
    """Run `igl-linabf` and return the exit code of `igl_linabf.cli.main`, or 130 if interrupted."""
    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:  # ignored in the background of a shell script
        signal.signal(signal.SIGINT, _stop)
    from . import cli

    ignore_interrupts = partial(signal.signal, signal.SIGINT, signal.SIG_IGN)
    code = cli.main(on_commit=ignore_interrupts)
    ignore_interrupts()
    return code


if __name__ == "__main__":
    sys.exit(main())
