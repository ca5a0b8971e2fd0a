"""Entry of the command: Ctrl-C ends it at once with one line, also while the libraries are imported.

Nothing but the standard library is imported before `main` has taken over the signal: the package's `__init__`
imports a room only when one of its names is used.
"""

import os
import signal
import sys
from functools import partial
from typing import NoReturn

INTERRUPTED = 130


def _stop(*_: object) -> NoReturn:
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        undo_all = getattr(sys.modules.get("igl_linabf._runtime.cleanup"), "undo_all", None)
        if undo_all is not None:  # it has come as far as to import it
            undo_all()
        os.write(2, b"igl-linabf: interrupted\n")
    finally:
        os._exit(INTERRUPTED)  # taken down by the rules, what a library was in the middle of may crash


def main() -> int:
    """Run `igl-linabf`; exit code 130 where it is interrupted, else those of `igl_linabf.cli.main`."""
    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:  # as it is in the background of a shell script
        signal.signal(signal.SIGINT, _stop)
    from . import cli

    too_late = partial(signal.signal, signal.SIGINT, signal.SIG_IGN)
    code = cli.main(settled=too_late)
    too_late()
    return code


if __name__ == "__main__":
    sys.exit(main())
