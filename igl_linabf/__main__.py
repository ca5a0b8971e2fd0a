"""Run the command `igl-linabf`, which Ctrl-C and SIGTERM end immediately with one line of text.

Only the standard library is imported before `main` sets the signal handlers. The package's `__init__` imports
a subpackage when one of its names is first used.
"""

import os
import signal
import sys
from typing import NoReturn

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


def _exit_after_signal(number: int, _: object) -> NoReturn:
    try:
        _ignore_signals()
        undo_all = getattr(sys.modules.get("igl_linabf._runtime.cleanup"), "undo_all", None)
        if undo_all is not None:  # the module `cleanup` has been imported
            undo_all()
        os.write(2, f"igl-linabf: {WORDS[signal.Signals(number)]}\n".encode())
    finally:
        os._exit(128 + number)  # an ordinary shutdown may crash inside an interrupted library


def main() -> int:
    """Run `igl-linabf` and return its exit code, which is 130 after Ctrl-C and 143 after SIGTERM."""
    for number in WORDS:
        if signal.getsignal(number) != signal.SIG_IGN:  # shells ignore SIGINT for background jobs
            signal.signal(number, _exit_after_signal)
    from . import cli

    code = cli.main(on_commit=_ignore_signals)
    _ignore_signals()
    return code


def _ignore_signals() -> None:
    for number in WORDS:
        signal.signal(number, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main())
