"""The files of a flat hemisphere, all of them or none."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .._runtime import replacing
from .._types import FloatArray
from ..io import import_optional, write_patch
from .flat_hemispheres import FlatHemisphere
from .pictures import area_changes, draw
from .subjects import HOW_TO_GET, HemisphereName

STRUCTURES = {"lh": "CortexLeft", "rh": "CortexRight"}  # as GIFTI names them
FLAT_PATCH = "cortex.flat.patch.3d"  # the map
NAMES = (
    "cortex.patch.3d",  # what stays, in space
    FLAT_PATCH,
    "cortex.flat.surf.gii",  # the map as a surface
    "cortex.area.shape.gii",  # log(area in the map / area of the surface)
    "cortex.png",
)


def files_of(folder: str | os.PathLike[str], hemisphere: HemisphereName) -> list[Path]:
    """The files that are written for a hemisphere."""
    return [Path(folder) / f"{hemisphere}.{name}" for name in NAMES]


def write_hemisphere(folder: str | os.PathLike[str], flat: FlatHemisphere) -> None:
    """Write a flat hemisphere as patches, GIFTI and a picture; all files or none.

    Parameters
    ----------
    folder : path of a folder, which is made
        In it: `?h.cortex.patch.3d` and `?h.cortex.flat.patch.3d`, what stays in space and in the plane, as
        FreeSurfer and pycortex read them; `?h.cortex.flat.surf.gii`, the map as a surface, and
        `?h.cortex.area.shape.gii`, the logarithm of the change of area, with a row for each of the subject's
        vertices; `?h.cortex.png`, the folds and the change of area.
    flat : FlatHemisphere

    Raises
    ------
    OSError
        A file cannot be written. In that case nothing is left behind.

    Examples
    --------
    >>> import tempfile
    >>> from igl_linabf.cortex import files_of
    >>> [path.name for path in files_of(tempfile.mkdtemp(), "lh")][:2]
    ['lh.cortex.patch.3d', 'lh.cortex.flat.patch.3d']
    """
    with writing_hemispheres(folder, [flat]):
        pass


@contextmanager
def writing_hemispheres(folder: str | os.PathLike[str], flats: Iterable[FlatHemisphere]) -> Iterator[None]:
    """Write under temporary names; the files take their places when the block succeeds."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    chosen = list(flats)
    with ExitStack() as stack, ThreadPoolExecutor(max(len(chosen), 1)) as threads:
        places = [
            [stack.enter_context(replacing(path)) for path in files_of(folder, flat.hemisphere.name)]
            for flat in chosen
        ]
        list(threads.map(_write, chosen, places))
        yield


def _write(flat: FlatHemisphere, places: list[str]) -> None:
    solid, plane, surface, area, picture = places
    vertex, border = flat.patch.vertices, flat.border[flat.patch.vertices]
    write_patch(solid, vertex, border, flat.hemisphere.V[vertex])
    write_patch(plane, vertex, border, flat.uv[vertex])
    points = np.insert(np.nan_to_num(flat.uv), 2, 0.0, axis=1)
    _write_gifti(surface, flat, ("POINTSET", points), ("TRIANGLE", flat.F.astype(np.int32)))
    change = np.nan_to_num(area_changes(flat))
    _write_gifti(area, flat, ("SHAPE", change))
    draw(flat, change).save(picture)


def _write_gifti(path: str, flat: FlatHemisphere, *arrays: tuple[str, FloatArray | Any]) -> None:
    gifti: Any = import_optional("nibabel.gifti", HOW_TO_GET)
    meta = {"AnatomicalStructurePrimary": STRUCTURES[flat.hemisphere.name], "GeometricType": "Flat"}
    made = [
        gifti.GiftiDataArray(
            values if values.dtype == np.int32 else values.astype(np.float32),
            intent=f"NIFTI_INTENT_{intent}",
            meta=gifti.GiftiMetaData(meta if intent == "POINTSET" else {}),
        )
        for intent, values in arrays
    ]
    Path(path).write_bytes(gifti.GiftiImage(darrays=made, meta=gifti.GiftiMetaData(meta)).to_bytes())
