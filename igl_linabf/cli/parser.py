"""The command line parser, the entry point `main`, and completion in shells."""

import argparse
import contextlib
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from .batching import BATCH
from .commands import Command, ExitCode, run_and_report
from .comparing import COMPARE
from .doctor import DOCTOR, version
from .flattening import CORTEX, FLATTEN
from .jobs import run_each
from .pattern_making import PATTERN
from .unwrapping import UNWRAP
from .uv_sets import CHECK, PACK
from .viewing import VIEW

COMMANDS = (FLATTEN, COMPARE, UNWRAP, CHECK, PACK, PATTERN, CORTEX, VIEW, BATCH, DOCTOR)
EXAMPLES = "examples:"
SHELLS = ("bash", "zsh", "fish")
FLAGS = {
    "subject": ["subject"],
    "mesh": ["mesh"],
    "inputs": ["inputs"],
    "output": ["-o", "--output"],
    "folder": ["-o", "--output"],
}


class Completion(argparse.Action):
    """An option that prints a completion script for a shell; the arguments `files` complete paths."""

    def __init__(self, *args: Any, files: Sequence[argparse.Action], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.files = files

    def __call__(self, parser: argparse.ArgumentParser, *rest: Any) -> NoReturn:
        import shtab

        for argument in self.files:
            argument.complete = shtab.FILE  # type: ignore[attr-defined]
        print(shtab.complete(parser, shell=rest[1]))
        parser.exit()


class Parser(argparse.ArgumentParser):
    """A parser that reports errors in one line, like all errors of the command."""

    def error(self, message: str) -> NoReturn:
        self.exit(ExitCode.ERROR, f"igl-linabf: {message} (see {self.prog} --help)\n")


class Help(argparse.HelpFormatter):
    """A formatter that wraps all text except the examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if text.startswith(EXAMPLES) else super()._fill_text(text, width, indent)


def _format_examples(command: Command) -> str | None:
    lines = (f"  igl-linabf {command.name} {example}" for example in command.examples)
    return "\n".join((EXAMPLES, *lines)) if command.examples else None


def command_parser() -> Parser:
    """Return the parser of the whole command; the parsed options have the chosen function in `run`."""
    files: list[argparse.Action] = []
    parser = Parser(prog="igl-linabf", description="Linear angle based parameterization of triangle meshes.")
    parser.add_argument("--version", action="version", version=f"igl-linabf {version('igl-linabf')}")
    parser.add_argument(
        "--print-completion",
        action=Completion,
        choices=SHELLS,
        files=files,
        help="print a script that makes the shell complete options and files at TAB, and exit",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in COMMANDS:
        subparser = commands.add_parser(
            command.name,
            help=command.help,
            description=command.description,
            epilog=_format_examples(command),
            formatter_class=Help,
        )
        subparser.set_defaults(run=partial(run_each, run=command.run) if command.each else command.run)
        for name, settings in command.arguments.items():
            argument = subparser.add_argument(*FLAGS.get(name, [f"--{name}"]), **settings)
            if argument.type is Path or name in ("mesh", "seams"):
                files.append(argument)
    return parser


def main(arguments: Sequence[str] | None = None, *, on_commit: Callable[[], object] = lambda: None) -> int:
    """Run the command and return its exit code: 0, or 1 for a map with flipped triangles, or 2 for an error.

    `on_commit` is called after everything is printed and written, before the files get their final names.
    """
    options = command_parser().parse_args(arguments)
    options.on_commit = on_commit
    named = getattr(options, "mesh", getattr(options, "subject", "the batch"))
    options.title, options.prefix = str(named), ""
    with _print_warnings_on_one_line():
        return run_and_report(options.run, options)


@contextlib.contextmanager
def _print_warnings_on_one_line() -> Iterator[None]:
    """Print each warning of the library as one line on stderr."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        print(f"igl-linabf: warning: {message}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("default")
        for internal in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", internal)  # Python ignores them by default
        warnings.showwarning = show
        yield
