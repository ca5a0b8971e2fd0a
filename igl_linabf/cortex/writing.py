"""Write the files of a flat hemisphere, either all of them or none."""

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
from .pictures import compute_log_area_ratios, draw_flat_hemisphere
from .subjects import INSTALL_HINT, HemisphereName

GIFTI_STRUCTURES = {"lh": "CortexLeft", "rh": "CortexRight"}  # GIFTI's names of the hemispheres
FLAT_PATCH_NAME = "cortex.flat.patch.3d"  # the flat map, as a patch
FILE_NAMES = (
    "cortex.patch.3d",  # the vertices of the map at their positions in space
    FLAT_PATCH_NAME,
    "cortex.flat.surf.gii",  # the flat map, as a surface
    "cortex.area.shape.gii",  # log(area in the map / area of the surface)
    "cortex.png",
)


def list_output_paths(folder: str | os.PathLike[str], hemisphere: HemisphereName) -> list[Path]:
    """Return the paths of the files that are written for a hemisphere."""
    return [Path(folder) / f"{hemisphere}.{name}" for name in FILE_NAMES]


def write_hemisphere(folder: str | os.PathLike[str], flat: FlatHemisphere) -> None:
    """Write a flat hemisphere as patches, GIFTI files and a picture, either all files or none.

    Parameters
    ----------
    folder : path of a folder
        Created if it does not exist. `?h.cortex.patch.3d` and `?h.cortex.flat.patch.3d` are the mapped
        vertices in space and in the plane, for FreeSurfer and pycortex. `?h.cortex.flat.surf.gii` is the map
        as a surface. `?h.cortex.area.shape.gii` is the logarithm of the change of area. Both GIFTI files
        have a row for each vertex of the subject. `?h.cortex.png` shows the folds and the change of area.
    flat : FlatHemisphere

    Raises
    ------
    OSError
        A file cannot be written. In that case no file is left behind.

    Examples
    --------
    >>> import tempfile
    >>> from igl_linabf.cortex import list_output_paths
    >>> [path.name for path in list_output_paths(tempfile.mkdtemp(), "lh")][:2]
    ['lh.cortex.patch.3d', 'lh.cortex.flat.patch.3d']
    """
    with writing_hemispheres(folder, [flat]):
        pass


@contextmanager
def writing_hemispheres(folder: str | os.PathLike[str], flats: Iterable[FlatHemisphere]) -> Iterator[None]:
    """Write hemispheres under temporary names, and rename the files when the `with` block succeeds."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    chosen = list(flats)
    with ExitStack() as stack, ThreadPoolExecutor(max(len(chosen), 1)) as threads:
        places = [
            [stack.enter_context(replacing(path)) for path in list_output_paths(folder, flat.hemisphere.name)]
            for flat in chosen
        ]
        list(threads.map(_write_map_files, chosen, places))
        yield


def _write_map_files(flat: FlatHemisphere, places: list[str]) -> None:
    solid, plane, surface, area, picture = places
    vertex, border = flat.patch.vertices, flat.border[flat.patch.vertices]
    write_patch(solid, vertex, border, flat.hemisphere.V[vertex])
    write_patch(plane, vertex, border, flat.uv[vertex])
    points = np.insert(np.nan_to_num(flat.uv), 2, 0.0, axis=1)
    _write_gifti(surface, flat, ("POINTSET", points), ("TRIANGLE", flat.F.astype(np.int32)))
    change = np.nan_to_num(compute_log_area_ratios(flat))
    _write_gifti(area, flat, ("SHAPE", change))
    draw_flat_hemisphere(flat, change).save(picture)


def _write_gifti(path: str, flat: FlatHemisphere, *arrays: tuple[str, FloatArray | Any]) -> None:
    gifti: Any = import_optional("nibabel.gifti", INSTALL_HINT)
    meta = {"AnatomicalStructurePrimary": GIFTI_STRUCTURES[flat.hemisphere.name], "GeometricType": "Flat"}
    made = [
        gifti.GiftiDataArray(
            values if values.dtype == np.int32 else values.astype(np.float32),
            intent=f"NIFTI_INTENT_{intent}",
            meta=gifti.GiftiMetaData(meta if intent == "POINTSET" else {}),
        )
        for intent, values in arrays
    ]
    Path(path).write_bytes(gifti.GiftiImage(darrays=made, meta=gifti.GiftiMetaData(meta)).to_bytes())
