"""Read and write tifxyz, the format of scroll segments: a folder with a grid of points as TIFF images."""

from __future__ import annotations

import json
import os
import reprlib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..._runtime import replacing_folder
from ..._types import BoolArray, FloatArray
from ...errors import MeshError, MeshWarning, first_few, is_number, stack_level
from ...linalg import has_free_memory
from ..parsing import Damaged, call_reader, check_regular_file, import_optional
from ..references import Folder

INSTALL_HINT = "pip install 'igl-linabf[scrolls]' reads and writes tifxyz"
FORMAT = "tifxyz"
META = "meta.json"
AXES = ("x", "y", "z")
MASK = "mask"
MASK_THRESHOLD = 255  # points with a smaller value in the mask image are removed
SINGLE_FILE = dict.fromkeys(("is_ome", "is_mmstack", "is_ndtiff"), False)  # options against other files
MISSING_COORDINATE = -1.0  # coordinate value that marks a missing point in a file


@dataclass(frozen=True, eq=False)
class Segment:
    """A scroll segment: a grid of points, as tifxyz stores it.

    Attributes
    ----------
    points : (#rows, #columns, 3) float64
        Positions in voxels; NaN where a point is missing.
    scale : (float, float)
        Grid cells per voxel along the columns and along the rows: the reciprocal of the distance between
        neighbouring points.
    meta : dict
        The contents of `meta.json`.
    channels : dict of str to array
        Further images of the folder, by name.
    path : Path or None
        The folder.
    """

    points: FloatArray
    scale: tuple[float, float]
    meta: dict[str, Any] = field(default_factory=dict)
    channels: dict[str, np.ndarray] = field(default_factory=dict)
    path: Path | None = None

    @property
    def valid(self) -> BoolArray:
        """Mask of the points that are not missing, (#rows, #columns)."""
        return np.asarray(np.isfinite(self.points).all(axis=2))

    def __repr__(self) -> str:
        rows, columns = self.points.shape[:2]
        return f"<Segment of {rows:,} x {columns:,} points, {self.valid.sum():,} of them valid>"


def read_tifxyz(path: str | os.PathLike[str], *, mask: bool = True, allow_outside: bool = False) -> Segment:
    """Read a scroll segment in the tifxyz format of Volume Cartographer.

    Parameters
    ----------
    path : path of a folder
        The folder contains the images `x.tif`, `y.tif` and `z.tif` and the file `meta.json`. Points are
        missing if z is not positive or a coordinate is not finite.
    mask : bool
        Whether an image `mask.tif` removes the points where its first channel is below 255. The size of the
        image is the size of the grid, or a multiple of it.
    allow_outside : bool
        Follow symbolic links from files of the segment to files outside the folder. By default these are
        refused, because a segment from a stranger may contain links to any file of this computer. The folder
        itself may be a link.

    Returns
    -------
    Segment

    Raises
    ------
    MeshError
        A file is damaged; it is a folder, a pipe, a device, or a link to a file outside the folder; the
        images differ in size; or `meta.json` does not describe a segment.
    ImportError
        tifffile is missing.
    OSError
        The folder or one of the files does not exist or cannot be read.

    Warns
    -----
    MeshWarning
        The size of the mask is not a multiple of the size of the grid, and the mask is ignored.

    Examples
    --------
    >>> import os, tempfile
    >>> from igl_linabf.scrolls import synthetic_segment
    >>> path = os.path.join(tempfile.mkdtemp(), "spiral")
    >>> write_tifxyz(path, synthetic_segment(30, 80))
    >>> read_tifxyz(path)
    <Segment of 30 x 80 points, 2,087 of them valid>
    """
    folder = Path(path)
    inside = Folder(folder, allow_outside)
    meta = _read_meta(_get_file(inside, META))
    x, y, z = (_read_coordinate(_get_file(inside, f"{name}.tif")) for name in AXES)
    if not x.shape == y.shape == z.shape:
        sizes = ", ".join(f"{name}.tif {a.shape}" for name, a in zip(AXES, (x, y, z), strict=True))
        raise MeshError(f"{folder}: the coordinates differ in size: {sizes}")
    points = np.stack((x, y, z), axis=2)
    valid = np.isfinite(points).all(axis=2) & (z > 0)
    found = [_get_file(inside, file.name) for file in sorted(folder.glob("*.tif"))]
    others = {file.stem: file for file in found if file.stem not in AXES}
    mask_file = others.pop(MASK, None)
    if mask and mask_file is not None:
        valid &= _read_mask(mask_file, valid.shape)
    points[~valid] = np.nan
    channels = {name: _read_image(file) for name, file in others.items()}
    return Segment(points, meta["scale"], meta, channels, folder)


def _get_file(folder: Folder, name: str) -> Path:
    """Return the path of a file of a segment; raise a MeshError if it must not be read."""
    folder.find_file(name)  # raises for links to files outside the folder
    path = folder.path / name
    check_regular_file(path)
    return path


def _read_meta(path: Path) -> dict[str, Any]:
    """Read the description of a segment, with `scale` as two positive floats."""
    try:
        meta = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:  # not JSON, not UTF-8, or nested too deeply
        raise MeshError(f"{path} is not JSON: {error}") from None
    kind = meta.get("format") if isinstance(meta, dict) else None
    if kind != FORMAT:
        raise MeshError(
            f"{path} does not describe a tifxyz segment: its format is {_quote(kind)}, not {FORMAT!r}"
        )
    return {**meta, "scale": _check_scale(meta.get("scale"), str(path))}


def _quote(value: Any, limit: int = 80) -> str:
    """Return a value of `meta.json` for a message, in at most `limit` characters."""
    return reprlib.repr(value)[:limit]  # reprlib also limits the depth


def _check_scale(scale: Any, where: str) -> tuple[float, float]:
    """Return the scale as two floats; raise a MeshError if it is not two positive numbers."""
    values = list(scale) if isinstance(scale, list | tuple | np.ndarray) else []
    if len(values) != 2 or not all(is_number(s, 0, np.finfo(float).max, above=True) for s in values):
        raise MeshError(
            f"{where}: scale is {_quote(scale)}: give two positive numbers of grid cells per voxel"
        )
    return float(values[0]), float(values[1])


def _read_image(path: Path, first_channel: bool = False) -> np.ndarray:
    """Read a TIFF image; with `first_channel`, read only the first channel of its first page."""
    tifffile = import_optional("tifffile", INSTALL_HINT)

    def read_values(name: str) -> Any:
        with tifffile.TiffFile(name, **SINGLE_FILE) as file:
            image = file.pages[0] if first_channel else file.series[0]
            wanted = 2 * image.size * image.dtype.itemsize  # while pages are decoded and copied
            if not has_free_memory(wanted):  # a small file may announce many pixels
                raise Damaged(f"its {image.size:,} samples would take {wanted:,} bytes, more than are free")
            values = image.asarray()
            is_sampled = first_channel and "S" in image.axes
            return values.take(0, image.axes.index("S")) if is_sampled else values

    try:
        return np.asarray(call_reader(read_values, path))
    except Damaged as damage:
        raise MeshError(f"{path} cannot be read as TIFF: {damage}") from None


@np.errstate(invalid="ignore")  # NumPy warns when it casts signalling NaN
def _read_coordinate(path: Path) -> FloatArray:
    image = _read_image(path)
    if image.ndim != 2 or image.dtype.kind not in "fiu" or not image.size:
        raise MeshError(f"{path} is an image {image.shape} of {image.dtype}: give one channel of numbers")
    return image.astype(np.float64)


def _read_mask(path: Path, size: tuple[int, int]) -> BoolArray:
    """Return True for each grid point whose pixels in the mask image are all at least `MASK_THRESHOLD`."""
    image = _read_image(path, first_channel=True)
    rows, columns = size
    if image.ndim != 2 or image.shape[0] % rows or image.shape[1] % columns or not image.size:
        warnings.warn(
            f"{path} is an image {image.shape}, which is not a multiple of the grid {size}: it is ignored",
            MeshWarning,
            stacklevel=stack_level(),
        )
        return np.ones(size, dtype=bool)
    blocks = image.reshape(rows, image.shape[0] // rows, columns, image.shape[1] // columns)
    return np.asarray((blocks >= MASK_THRESHOLD).all(axis=(1, 3)))


def write_tifxyz(path: str | os.PathLike[str], segment: Segment, *, force: bool = False) -> None:
    """Write a scroll segment in the tifxyz format, with 32-bit coordinates.

    Parameters
    ----------
    path : path of a folder
        Its name becomes the `uuid` of the segment.
    segment : Segment
        Its `meta` is kept, except for `format`, `scale`, `bbox` and `uuid`, which describe the new surface.
    force : bool
        Replace an existing segment. Other folders are never replaced.

    Raises
    ------
    MeshError
        The segment has no points, or a point that readers take for missing because z is not positive; or its
        `meta` is nested too deeply.
    FileExistsError
        The folder exists, and `force` is not set; or it is not a segment.
    ImportError
        tifffile is missing.
    OSError
        A file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import os, tempfile
    >>> from igl_linabf.scrolls import synthetic_segment
    >>> path = os.path.join(tempfile.mkdtemp(), "spiral")
    >>> write_tifxyz(path, synthetic_segment(30, 80))
    >>> sorted(os.listdir(path))
    ['meta.json', 'x.tif', 'y.tif', 'z.tif']
    """
    with writing_tifxyz(path, segment, force=force):
        pass


@contextmanager
def writing_tifxyz(path: str | os.PathLike[str], segment: Segment, *, force: bool = False) -> Iterator[None]:
    """Write a segment to a temporary folder, and rename the folder when the `with` block succeeds."""
    tifffile = import_optional("tifffile", INSTALL_HINT)
    target = Path(path)
    points = _round_points(segment)
    valid = points[..., 2] > 0
    low, high = (extreme(points[valid], axis=0).tolist() for extreme in (np.min, np.max))
    meta = {
        **segment.meta,
        "format": FORMAT,
        "scale": list(_check_scale(segment.scale, "segment")),
        "bbox": [low, high],
        "uuid": target.resolve().name,
    }
    try:
        text = json.dumps(meta, indent=2)
    except RecursionError:
        raise MeshError("meta of the segment is nested too deeply: remove its nested values") from None
    check_target(target, force)
    with replacing_folder(target) as folder:
        for k, name in enumerate(AXES):
            tifffile.imwrite(folder / f"{name}.tif", np.ascontiguousarray(points[..., k]), metadata=None)
        for name, values in segment.channels.items():
            layout = "contig" if values.ndim == 3 else None
            tifffile.imwrite(
                folder / f"{name}.tif", values, photometric="minisblack", planarconfig=layout, metadata=None
            )
        (folder / META).write_text(text + "\n", encoding="utf-8")
        yield


def check_target(path: Path, force: bool) -> None:
    """Raise a FileExistsError if a segment cannot be written to this path."""
    if not os.path.lexists(path):
        return
    if not (path / META).is_file():
        raise FileExistsError(f"{path} exists and is not a tifxyz segment: choose another name")
    if not force:
        raise FileExistsError(f"{path} exists: choose another name, or force its replacement")


def _round_points(segment: Segment) -> np.ndarray:
    """Return the points as 32-bit floats, with `MISSING_COORDINATE` where a point is missing."""
    points, valid = segment.points, segment.valid
    if not valid.any():
        raise MeshError("the segment has no points")
    with np.errstate(over="ignore"):
        rounded = np.where(valid[..., None], points, MISSING_COORDINATE).astype(np.float32)
    bad = np.argwhere(valid & ~((rounded[..., 2] > 0) & np.isfinite(rounded).all(axis=2)))
    if len(bad):
        raise MeshError(
            f"the points at rows and columns {first_few(bad)} have z <= 0, which means "
            "missing in tifxyz, or are too large: move the segment"
        )
    return rounded
