"""Run a command: expand patterns, read standard input, name the output files, report errors."""

import contextlib
import glob
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, ClassVar

from .._runtime import progress_part, show_progress, undo_at_interrupt
from ..errors import escape_control_characters
from ..io import (
    SUFFIXES,
    MeshFile,
    check_no_file_exists,
    detect_suffix,
    list_companion_files,
    normalize_suffix,
    read_file,
)
from .arguments import ALLOW_OUTSIDE, Command, Option, bind_options, describe_output_option

STDIO = Path("-")  # the path that stands for standard input or output

# Shares of the progress bar at the end of each step; a picture may be drawn after the map is written.
PROGRESS = {"reading": 0.1, "computing": 0.8, "baking": 0.9, "writing": 0.9}


class ExitCode(IntEnum):
    """Exit codes: all maps are valid, some maps are not valid, or an error occurred."""

    GOOD = 0
    NOT_VALID = 1
    ERROR = 2


@dataclass(frozen=True)
class Job:
    """One run of a command: the mesh it reads, the files it writes, and how it reports."""

    given: list[str] | str  # mesh names in the command line, or a single name
    output: Path | None = None  # file to write, if any
    picture: Path | None = None
    format: str = "obj"  # format of the standard output
    force: bool = False  # replace existing files other than `output`
    json: bool = False  # print figures instead of tables
    quiet: bool = False  # print nothing
    allow_outside: bool = False  # follow references to files outside the folder of the mesh
    mesh: Path = STDIO  # file to read
    title: str = ""  # name of the mesh for messages
    prefix: str = ""  # text before a message if there are several meshes
    on_commit: Callable[[], object] = lambda: None  # called before temporary files are renamed
    explain: Callable[[str], str] = str  # names options of the command in messages of the library

    suffixes: ClassVar[Sequence[str]] = SUFFIXES  # allowed suffixes of `output`

    @property
    def output_name(self) -> Path:
        """The output file; for standard output, a file name with the suffix of its format."""
        return Path(f"map.{self.format}") if self.output in (None, STDIO) else self.output

    def read_mesh(self, surface: Path | None = None, texcoord: int = 0) -> MeshFile:
        """Read the mesh; some of its corners may lack texture coordinates."""
        if self.mesh.is_dir():
            raise ValueError(f"{self.mesh} is a folder: give its files, or use igl-linabf batch")
        with progress_part("reading", PROGRESS["reading"]):
            return read_file(
                self.mesh, surface, partial=True, allow_outside=self.allow_outside, texcoord=texcoord
            )


def describe_output_options(formats: str, suffixes: Sequence[str]) -> dict[str, Option]:
    """Describe the options of a command that writes one file for each mesh."""
    return {
        "output": describe_output_option(
            f"{formats} file, or a folder that exists, or - for standard output"
        ),
        "format": Option(
            "of files in a folder and of standard output", choices=[suffix[1:] for suffix in suffixes]
        ),
        "force": FORCE,
    }


FORCE = Option(
    "replace existing files that -o does not name: MTL and PNG files beside an OBJ, pictures, "
    "files in a folder"
)
MESHES = {
    "given": Option(
        "files (OBJ, PLY, GLB, STL, ...), patterns in quotes, or - for standard input", "MESH", nargs="+"
    ),
    "allow_outside": ALLOW_OUTSIDE,
}
OUTPUT = describe_output_options(
    "OBJ, PLY, GLB, glTF, 3MF, VTP, GIFTI or FreeSurfer (.surf, .flat)", SUFFIXES
)
PICTURE = {"picture": Option("checkerboard picture to write", "OUT.png"), "force": FORCE}
REPORTS = {
    "json": Option("print all figures as JSON, one line per mesh, instead of tables"),
    "quiet": Option("print no tables and no progress"),
}


def run_command(
    command: Command,
    values: Mapping[str, Any],
    on_commit: Callable[[], object],
    explain: Callable[[str], str],
) -> int:
    """Run a command with the parsed options, on each of its meshes, and return the worst exit code.

    Errors are printed. An error in one mesh does not stop the run.
    """

    def run_all_jobs() -> int:
        bound = bind_options(command, values)
        if "job" not in bound:
            return command(**bound)
        jobs = _plan_jobs(replace(bound.pop("job"), on_commit=on_commit, explain=explain))
        return max(report_errors(partial(_run_job, partial(command, **bound), job), job) for job in jobs)

    return report_errors(run_all_jobs, Job("", explain=explain))


def _plan_jobs(job: Job) -> list[Job]:
    """Return the job of each mesh. Raise if two jobs write the same file, or a job would replace a file."""
    if isinstance(job.given, str):
        mesh = Path(job.given)
        jobs = [replace(job, mesh=mesh, title=str(mesh))]
    else:
        names = _expand_patterns(job.given)
        if job.output == STDIO and job.json:
            raise ValueError("--json and -o - both write to standard output: leave one out")
        outputs = _choose_paths(job.output, names, f".{job.format}")
        pictures = _choose_paths(job.picture, names, ".png")
        jobs = []
        for name, output, picture in zip(names, outputs, pictures, strict=True):
            title = "standard input" if name == str(STDIO) else name
            prefix = f"{title}: " if len(names) > 1 else ""
            own: dict[str, Any] = {"mesh": Path(name), "output": output, "picture": picture}
            jobs.append(replace(job, title=title, prefix=prefix, **own))
        # only the last job calls `on_commit`, because it disables Ctrl-C
        jobs[:-1] = [replace(one, on_commit=lambda: None) for one in jobs[:-1]]
    paths = (path for one in jobs for path in (one.output, one.picture))
    check_no_file_exists((path for path in paths if path is not None and path != job.output), job.force)
    return jobs


def _run_job(command: Command, job: Job) -> int:
    """Check that the output files of a job can be written, and run the command."""
    for path, suffixes in ((job.output, job.suffixes), (job.picture, (".png",))):
        if path is None or path == STDIO:
            continue
        if normalize_suffix(path) not in suffixes:
            raise ValueError(f"{path} does not end in {' or '.join(suffixes)}: give a file name that does")
        if not os.access(path.parent, os.W_OK):
            raise OSError(None, "the folder is missing or cannot be written to", str(path.parent))
    if job.picture:
        from .. import plot  # noqa: F401  # raises with instructions if pyvista is missing
    with contextlib.ExitStack() as stack:
        if not isinstance(job.given, str):  # several inputs share one progress bar
            stack.enter_context(show_progress(False if job.quiet or job.json else None))
        mesh = stack.enter_context(_spool_standard_input()) if job.mesh == STDIO else job.mesh
        return command(replace(job, mesh=mesh))


def report_errors(run: Callable[[], int], job: Job) -> int:
    """Run a function and return its exit code; print an error as one line that names the mesh."""
    try:
        return int(run())
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        message = f"{place}{error.strerror or error}"
        _discard_stdout()
    except MemoryError:
        message = (
            f"{job.title or 'the command'}: not enough memory: decimate the mesh, or use a smaller resolution"
        )
    except (ImportError, ValueError) as error:  # MeshError is a ValueError
        message = str(error)
    begin = "" if message.startswith(job.title) else job.prefix
    print(f"igl-linabf: {escape_control_characters(begin + job.explain(message))}", file=sys.stderr)
    return ExitCode.ERROR


def _discard_stdout() -> None:
    """Redirect a broken stdout to the null device, so that the exiting process does not flush it again."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def check_companion_files(
    job: Job, mesh: MeshFile, kinds: Sequence[str] = (), pages: int = 1, second: bool = False
) -> None:
    """Raise an error if a file beside the output exists, or is also the picture of this run.

    Called before the computation. `kinds` are the images to write; `second` means second texture coordinates.
    """
    beside = list_companion_files(job.output_name, mesh, kinds, pages, second) if job.output != STDIO else ()
    if job.picture in beside:
        raise ValueError(
            f"the picture and the texture would both be written to {job.picture}: rename the picture"
        )
    check_no_file_exists(beside, job.force)


def _expand_patterns(given: Sequence[str]) -> list[str]:
    """Replace each pattern by the sorted names of its files; keep names that are files."""
    names: list[str] = []
    for name in given:
        found = [name]
        if glob.has_magic(name) and not os.path.exists(name):
            found = sorted(path for path in glob.glob(name, recursive=True) if not os.path.isdir(path))
            if not found:
                raise ValueError(f"{name}: no file matches this pattern")
        names += found
    if names.count(str(STDIO)) > 1:
        raise ValueError("- is given twice: standard input holds one mesh")
    return names


def _choose_paths(given: Path | None, names: Sequence[str], suffix: str) -> Sequence[Path | None]:
    """Return the output file of each mesh: the given file, or one with its name in a given folder."""
    if given is None or not given.is_dir():
        if given is None or len(names) == 1:
            return [given] * len(names)
        raise ValueError(
            f"{given} is not a folder, and there are {len(names)} meshes: give an existing folder, or use "
            "igl-linabf batch"
        )
    places = [given / f"{'stdin' if name == str(STDIO) else Path(name).stem}{suffix}" for name in names]
    for i, place in enumerate(places):
        if place in places[:i]:
            first = names[places.index(place)]
            raise ValueError(f"{first} and {names[i]} would both be written to {place}: use igl-linabf batch")
    return places


@contextlib.contextmanager
def _spool_standard_input() -> Iterator[Path]:
    """Yield a temporary file with the data of standard input, and a suffix detected from the data."""
    data = sys.stdin.buffer.read()
    with TemporaryDirectory(prefix="igl_linabf-") as folder:
        path = Path(folder) / f"standard_input{detect_suffix(data)}"
        with undo_at_interrupt(lambda: path.unlink(missing_ok=True)):
            path.write_bytes(data)
            yield path
