"""Define the command line parser, the entry point `main`, and shell completion."""

import argparse
import contextlib
import inspect
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import NoReturn

import shtab

from ..errors import escape_control_characters
from .arguments import Command, add_options
from .batching import run_batch
from .doctor import find_version, print_versions
from .flattening import compare_methods, flatten_cortex, flatten_mesh, flatten_scroll
from .jobs import ExitCode, run_command
from .pattern_making import draw_pattern
from .texture_coordinates import check_coordinates, pack_charts
from .unwrapping import unwrap_mesh
from .viewing import view_mesh
from .wording import name_options

COMMANDS: Mapping[str, Command] = {
    "flatten": flatten_mesh,
    "compare": compare_methods,
    "unwrap": unwrap_mesh,
    "check": check_coordinates,
    "pack": pack_charts,
    "pattern": draw_pattern,
    "cortex": flatten_cortex,
    "scroll": flatten_scroll,
    "view": view_mesh,
    "batch": run_batch,
    "doctor": print_versions,
}
EXAMPLES = "examples:"
SHELLS = ("bash", "zsh", "fish")


class Parser(argparse.ArgumentParser):
    """An argument parser that reports errors in one line, like other errors of `igl-linabf`."""

    def error(self, message: str) -> NoReturn:
        self.exit(
            ExitCode.ERROR, f"igl-linabf: {escape_control_characters(message)} (see {self.prog} --help)\n"
        )


class HelpFormatter(argparse.HelpFormatter):
    """A formatter of help texts that wraps all text except the examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if text.startswith(EXAMPLES) else super()._fill_text(text, width, indent)


def make_command_parser() -> Parser:
    """Return the parser of the whole command, which parses the options of the functions in `COMMANDS`."""
    parser = Parser(prog="igl-linabf", description="Linear angle based parameterization of triangle meshes.")
    parser.add_argument("--version", action="version", version=f"igl-linabf {find_version('igl-linabf')}")
    parser.add_argument(
        "--print-completion",
        action=shtab.completion_action(),
        choices=SHELLS,
        help="print a script that makes the shell complete options and files at TAB, and exit",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        summary, description, examples = read_docstring(command)
        lines = [EXAMPLES, *(f"  igl-linabf {name} {example}" for example in examples)]
        subparser = commands.add_parser(
            name,
            help=summary,
            description=description,
            epilog="\n".join(lines) if examples else None,
            formatter_class=HelpFormatter,
        )
        add_options(subparser, command)
    return parser


def read_docstring(command: Command) -> tuple[str, str, list[str]]:
    """Return the summary, the description and the examples from the docstring of a command."""
    description, _, examples = (inspect.getdoc(command) or "").partition("\n\nExamples\n--------\n")
    summary = description.partition("\n")[0].rstrip(".")
    return summary[:1].lower() + summary[1:], description, examples.splitlines()


def main(arguments: Sequence[str] | None = None, *, on_commit: Callable[[], object] = lambda: None) -> int:
    """Run the command and return its exit code: 0, or 1 for a map with flipped triangles, or 2 for an error.

    `on_commit` is called after all output is printed and written, before temporary files are renamed.
    """
    options = vars(make_command_parser().parse_args(arguments))
    command = COMMANDS[options.pop("command")]
    explain = partial(name_options, command=command, commands=COMMANDS)
    with _print_warnings_on_one_line(explain):
        return run_command(command, options, on_commit, explain)


@contextlib.contextmanager
def _print_warnings_on_one_line(explain: Callable[[str], str]) -> Iterator[None]:
    """Print each warning of the library as one line on stderr."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        print(f"igl-linabf: warning: {escape_control_characters(explain(str(message)))}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("default")
        for internal in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", internal)  # as in Python's default filters
        warnings.showwarning = show
        yield
