"""Where files are: in folders, or behind a URL that fsspec knows."""

import glob
import os
import secrets
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from .._runtime import replacing
from ..cortex import HEMISPHERES, HemisphereName
from ..errors import MeshError
from ..io import READABLE, suffix_of

TEMPORARY = ".igl_linabf-*"  # what `replacing` writes before it takes its place


class Found(NamedTuple):
    """An input."""

    place: str  # absolute path, or URL
    name: str  # from the folder that was asked for, with / between folders
    version: str  # changes when the file does


def is_url(place: str) -> bool:
    return "://" in place


def absolute(place: str | os.PathLike[str]) -> str:
    """The place, under a name that holds in every process of every machine that shares it."""
    place = os.fspath(place)
    return place.rstrip("/") if is_url(place) else os.path.abspath(place)


def joined(folder: str, name: str) -> str:
    """The place of a name with / between folders."""
    return f"{folder}/{name}" if is_url(folder) else os.path.join(folder, *name.split("/"))


def found(
    inputs: Iterable[str | os.PathLike[str]], out: str, wanted: Callable[[str], bool] | None = None
) -> list[Found]:
    """The meshes that files, folders and globs stand for, each once, but none in `out`.

    `wanted` tells the places of inputs in folders; by default they are those of mesh files.

    Raises
    ------
    MeshError
        A glob or a folder holds no mesh file.
    OSError
        There is no such file or folder.
    """
    files: dict[str, Found] = {}
    for given in inputs:
        place = absolute(given)
        here = _remote(place) if is_url(place) else _local(place, wanted or _is_mesh)
        meshes = [file for file in here if not file.place.startswith((out + "/", out + os.sep))]
        if not meshes:
            what = "hemisphere (surf/?h.sphere.reg)" if wanted else f"mesh file ({', '.join(READABLE)})"
            raise MeshError(f"{given} holds no {what}: give another folder or glob")
        for file in meshes:
            files.setdefault(file.place, file)
    return list(files.values())


def is_hemisphere(place: str) -> bool:
    """Whether it is the registered sphere of a FreeSurfer subject's hemisphere."""
    return tuple(Path(place).parts[-2:]) in {("surf", f"{name}.sphere.reg") for name in HEMISPHERES}


def hemisphere_of(place: str) -> HemisphereName:
    """The hemisphere of a file that is named as FreeSurfer does."""
    return next(name for name in HEMISPHERES if Path(place).name.startswith(name))


def _local(place: str, wanted: Callable[[str], bool]) -> list[Found]:
    if os.path.isfile(place):
        paths, base = [place], os.path.dirname(place)
    elif os.path.isdir(place):
        paths, base = _in_folder(place, wanted), place
    elif glob.has_magic(place):
        fixed = Path(*_before(Path(place).parts))
        matches = sorted(glob.glob(place, recursive=True))
        paths, base = [path for match in matches for path in _in_folder(match, wanted)], str(fixed)
    else:
        raise FileNotFoundError(2, "No such file or directory", place)
    return [_stated(path, base) for path in paths]


def _before(parts: Iterable[str]) -> Iterator[str]:
    """The parts of a path before the first that is a pattern."""
    for part in parts:
        if glob.has_magic(part):
            return
        yield part


def _in_folder(place: str, wanted: Callable[[str], bool]) -> list[str]:
    """The wanted files in a folder and in those in it, without hidden ones; such a file is one itself."""
    if not os.path.isdir(place):
        return [place] * wanted(place)
    paths = []
    for folder, folders, names in os.walk(place):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        paths += [path for name in sorted(names) if wanted(path := os.path.join(folder, name))]
    return paths


def _is_mesh(place: str) -> bool:
    name = os.path.basename(place)
    return not name.startswith(".") and suffix_of(name) in READABLE


def _stated(path: str, base: str) -> Found:
    about = os.stat(path)
    name = os.path.relpath(path, base).replace(os.sep, "/")
    return Found(path, name, f"{about.st_size} {about.st_mtime_ns}")


def _remote(url: str) -> list[Found]:
    fs, place = _filesystem(url)
    if fs.isfile(place):
        paths, base = [place], place.rpartition("/")[0]
    elif glob.has_magic(place):
        base = "/".join(_before(place.split("/")))
        paths = sorted(path for path in fs.glob(place) if _is_mesh(path))
    elif fs.isdir(place):
        paths, base = sorted(path for path in fs.find(place) if _is_mesh(path)), place
    else:
        raise FileNotFoundError(2, "No such file or directory", url)
    return [
        Found(fs.unstrip_protocol(path), path.removeprefix(base).lstrip("/"), fs.ukey(path)) for path in paths
    ]


def _filesystem(url: str) -> tuple[Any, str]:
    from fsspec.core import url_to_fs  # comes with Dask

    fs, place = url_to_fs(url)
    return fs, place


def names_in(folder: str) -> set[str]:
    """The files in a folder and in those in it, by their names from it; of what is not there, none."""
    if is_url(folder):
        fs, place = _filesystem(folder)
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
    """Remove what writers that were killed have left beside files of these names from a folder."""
    if is_url(folder):
        return
    for inside in {os.path.dirname(joined(folder, name)) for name in names}:
        for path in Path(inside).glob(TEMPORARY):
            path.unlink(missing_ok=True)


@contextmanager
def fetched(place: str) -> Iterator[str]:
    """A local file with what is at the place."""
    if not is_url(place):
        yield place
        return
    fs, remote = _filesystem(place)
    with tempfile.TemporaryDirectory(prefix="igl_linabf-") as folder:
        local = os.path.join(folder, remote.rpartition("/")[2])
        fs.get_file(remote, local)
        yield local


@contextmanager
def written(place: str) -> Iterator[str]:
    """A local file that takes the place when the block succeeds; its folder is made."""
    with destination(place) as path, replacing(path) as temporary:
        yield temporary


@contextmanager
def destination(place: str) -> Iterator[str]:
    """A local path for what is to be at the place when the block succeeds, with the files beside it."""
    if not is_url(place):
        os.makedirs(os.path.dirname(place), exist_ok=True)
        yield place
        return
    fs, remote = _filesystem(place)
    folder, _, name = remote.rpartition("/")
    with tempfile.TemporaryDirectory(prefix="igl_linabf-") as local:
        yield os.path.join(local, name)
        fs.makedirs(folder, exist_ok=True)
        for own in sorted(os.listdir(local), key=lambda other: other == name):  # itself last
            temporary = f"{folder}/.igl_linabf-{secrets.token_hex(8)}-{own}"
            try:
                fs.put_file(os.path.join(local, own), temporary)
                fs.mv(temporary, f"{folder}/{own}")
            except BaseException:
                with suppress(FileNotFoundError):
                    fs.rm_file(temporary)
                raise
