"""A mesh file and what belongs beside it, whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from .._runtime import replacing
from ..errors import MeshError
from .formats import WITH_IMAGES, warn_of_loss, writer
from .mesh_file import MeshFile
from .obj_writing import materials_beside
from .pictures import png


@contextmanager
def written(
    path: str | os.PathLike[str],
    mesh: MeshFile,
    TC: ArrayLike,
    FTC: ArrayLike | None = None,
    image: ArrayLike | None = None,
) -> Iterator[None]:
    """Write under temporary names; the files take their places when the block succeeds."""
    path = Path(path)
    suffix = path.suffix.lower()
    save = writer(path)
    if image is not None and suffix not in WITH_IMAGES:
        raise MeshError(f"{path} holds no image: write one of {', '.join(WITH_IMAGES)}")
    made = replace(mesh.textured(TC, FTC), image=None if image is None else png(image))
    warn_of_loss(made, suffix)
    beside = materials_beside(made, path) if suffix == ".obj" else {}
    with ExitStack() as stack:
        temporary = stack.enter_context(replacing(path))
        for own, data in beside.items():
            Path(stack.enter_context(replacing(path.with_suffix(own)))).write_bytes(data)
        save(temporary, made, path)
        yield
