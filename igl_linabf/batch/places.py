"""Find, read and write files in local folders and at URLs that fsspec supports.

A place is an absolute path or a URL.
"""

import glob
import os
import secrets
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from .._runtime import replacing
from ..cortex import HEMISPHERE_NAMES, HemisphereName
from ..errors import MeshError
from ..io import READABLE, normalize_suffix

TEMPORARY = ".igl_linabf-*"  # file name pattern of the temporary files of `replacing`


class InputFile(NamedTuple):
    """An input file of a batch."""

    place: str  # absolute path or URL of the file
    name: str  # path relative to the requested folder, with / as separator
    version: str  # a text that changes when the file changes


def is_url(place: str) -> bool:
    """Return True if the place is a URL."""
    return "://" in place


def make_absolute(place: str | os.PathLike[str]) -> str:
    """Return a URL without a trailing slash, or an absolute path."""
    place = os.fspath(place)
    return place.rstrip("/") if is_url(place) else os.path.abspath(place)


def join_path(folder: str, name: str) -> str:
    """Join the path or URL of a folder and a relative name with / as separator."""
    return f"{folder}/{name}" if is_url(folder) else os.path.join(folder, *name.split("/"))


def find_inputs(
    inputs: Iterable[str | os.PathLike[str]], out: str, wanted: Callable[[str], bool] | None = None
) -> list[InputFile]:
    """Return the inputs that files, folders and globs refer to, each once, except files in `out`.

    `wanted` is a predicate for files in folders; by default it selects mesh files.

    Raises
    ------
    MeshError
        A glob or a folder holds no mesh file.
    OSError
        A file or folder does not exist.
    """
    files: dict[str, InputFile] = {}
    for given in inputs:
        place = make_absolute(given)
        here = _find_remote_inputs(place) if is_url(place) else _find_local_inputs(place, wanted or _is_mesh)
        meshes = [file for file in here if not file.place.startswith((out + "/", out + os.sep))]
        if not meshes:
            what = "hemisphere (surf/?h.sphere.reg)" if wanted else f"mesh file ({', '.join(READABLE)})"
            raise MeshError(f"{given} holds no {what}: give another folder or glob")
        for file in meshes:
            files.setdefault(file.place, file)
    return list(files.values())


def is_registered_sphere(place: str) -> bool:
    """Return True if the place is the registered sphere of a FreeSurfer subject's hemisphere."""
    return tuple(Path(place).parts[-2:]) in {("surf", f"{name}.sphere.reg") for name in HEMISPHERE_NAMES}


def get_hemisphere(place: str) -> HemisphereName:
    """Return the hemisphere in the name of a FreeSurfer file."""
    return next(name for name in HEMISPHERE_NAMES if Path(place).name.startswith(name))


def _find_local_inputs(place: str, wanted: Callable[[str], bool]) -> list[InputFile]:
    if os.path.isdir(place):
        paths, base = _list_folder(place, wanted), place
    elif os.path.exists(place):
        paths, base = [place], os.path.dirname(place)
    elif glob.has_magic(place):
        fixed = Path(*_iterate_fixed_parts(Path(place).parts))
        matches = sorted(glob.glob(place, recursive=True))
        paths, base = [path for match in matches for path in _list_folder(match, wanted)], str(fixed)
    else:
        raise FileNotFoundError(2, "No such file or directory", place)
    return [_describe_file(path, base) for path in paths]


def _iterate_fixed_parts(parts: Iterable[str]) -> Iterator[str]:
    """Yield the components of a path before the first component with a glob pattern."""
    for part in parts:
        if glob.has_magic(part):
            return
        yield part


def _list_folder(place: str, wanted: Callable[[str], bool]) -> list[str]:
    """Return the wanted files in a folder and its subfolders, or the path itself if it is a wanted file."""
    if not os.path.isdir(place):
        return [place] * wanted(place)
    paths = []
    for folder, folders, names in os.walk(place):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        paths += [path for name in sorted(names) if wanted(path := os.path.join(folder, name))]
    return paths


def _is_mesh(place: str) -> bool:
    name = os.path.basename(place)
    return not name.startswith(".") and normalize_suffix(name) in READABLE


def _describe_file(path: str, base: str) -> InputFile:
    name = os.path.relpath(path, base).replace(os.sep, "/")
    try:
        about = os.stat(path)
    except OSError:  # such as a link to a missing file: its row states the error, when the file is read
        return InputFile(path, name, "")
    return InputFile(path, name, f"{about.st_size} {about.st_mtime_ns}")


def _find_remote_inputs(url: str) -> list[InputFile]:
    fs, place = _open_filesystem(url)
    if fs.isfile(place):
        paths, base = [place], place.rpartition("/")[0]
    elif glob.has_magic(place):
        base = "/".join(_iterate_fixed_parts(place.split("/")))
        paths = sorted(path for path in fs.glob(place) if _is_mesh(path))
    elif fs.isdir(place):
        paths, base = sorted(path for path in fs.find(place) if _is_mesh(path)), place
    else:
        raise FileNotFoundError(2, "No such file or directory", url)
    return [
        InputFile(fs.unstrip_protocol(path), path.removeprefix(base).lstrip("/"), fs.ukey(path))
        for path in paths
    ]


def _open_filesystem(url: str) -> tuple[Any, str]:
    from fsspec.core import url_to_fs  # a dependency of Dask

    fs, place = url_to_fs(url)
    return fs, place


def list_names(folder: str) -> set[str]:
    """Return the names of the files in a folder and its subfolders; an empty set for a missing folder."""
    if is_url(folder):
        fs, place = _open_filesystem(folder)
        fs.invalidate_cache()
        with suppress(FileNotFoundError):
            return {path.removeprefix(place).lstrip("/") for path in fs.find(place)}
        return set()
    return {
        os.path.relpath(os.path.join(inside, name), folder).replace(os.sep, "/")
        for inside, _, names in os.walk(folder)
        for name in names
    }


def remove_temporaries(names: Iterable[str], folder: str) -> None:
    """Remove temporary files that killed writers left in the folders of the named files."""
    if is_url(folder):
        return
    for inside in {os.path.dirname(join_path(folder, name)) for name in names}:
        for path in Path(inside).glob(TEMPORARY):
            path.unlink(missing_ok=True)


@contextmanager
def fetch_file(place: str) -> Iterator[str]:
    """Yield the local path of a file; a file at a URL is downloaded first."""
    if not is_url(place):
        yield place
        return
    fs, remote = _open_filesystem(place)
    with tempfile.TemporaryDirectory(prefix="igl_linabf-") as folder:
        local = os.path.join(folder, remote.rpartition("/")[2])
        fs.get_file(remote, local)
        yield local


@contextmanager
def replace_atomically(place: str) -> Iterator[str]:
    """Yield a temporary path, and replace the file at `place` when the `with` block succeeds."""
    with prepare_destination(place) as path, replacing(path) as temporary:
        yield temporary


@contextmanager
def prepare_destination(place: str) -> Iterator[str]:
    """Yield a local path for writing; for a URL, upload all files in its folder when the block succeeds."""
    if not is_url(place):
        os.makedirs(os.path.dirname(place), exist_ok=True)
        yield place
        return
    fs, remote = _open_filesystem(place)
    folder, _, name = remote.rpartition("/")
    with tempfile.TemporaryDirectory(prefix="igl_linabf-") as local:
        yield os.path.join(local, name)
        fs.makedirs(folder, exist_ok=True)
        for own in sorted(os.listdir(local), key=lambda other: other == name):  # upload the map last
            temporary = f"{folder}/.igl_linabf-{secrets.token_hex(8)}-{own}"
            try:
                fs.put_file(os.path.join(local, own), temporary)
                fs.mv(temporary, f"{folder}/{own}")
            except BaseException:
                with suppress(FileNotFoundError):
                    fs.rm_file(temporary)
                raise
