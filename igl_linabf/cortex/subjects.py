"""Subjects of FreeSurfer: the surfaces of their hemispheres, one row a vertex in all of them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError
from ..io import call_reader, import_optional, mean_surface, read_file, surfaces_beside
from ..surface import vertex_array

HemisphereName = Literal["lh", "rh"]
HEMISPHERES: tuple[HemisphereName, ...] = get_args(HemisphereName)
HOW_TO_GET = "pip install 'igl-linabf[cortex]' reads subjects"


@dataclass(frozen=True, eq=False)
class Hemisphere:
    """A hemisphere of a subject.

    Attributes
    ----------
    subject : Path
    name : {"lh", "rh"}
    V : (#V, 3) float64
        The cortex, midway between the white matter and the pial surface, mm.
    F : (#F, 3) int64
    """

    subject: Path
    name: HemisphereName
    V: FloatArray
    F: IntArray

    @classmethod
    def of_subject(cls, subject: str | os.PathLike[str], name: HemisphereName) -> Hemisphere:
        """Read `surf/?h.fiducial` or what stands for it.

        Raises
        ------
        MeshError
            The folder is no subject, or the hemisphere has no surface.
        """
        folder = Path(subject)
        if name not in HEMISPHERES:
            raise ValueError(f"the hemisphere is {name!r}: use 'lh' or 'rh'")
        paths = surfaces_beside(folder / "surf", name)
        if not paths:
            raise MeshError(
                f"{folder} has no surf/{name}.fiducial, .midthickness, .smoothwm, .white or .pial: give the "
                "folder of a FreeSurfer subject"
            )
        mesh = mean_surface([read_file(path) for path in paths])
        return cls(folder, name, mesh.V, mesh.triangles)

    def registered_sphere(self) -> FloatArray:
        """The directions of the vertices from the centre of `surf/?h.sphere.reg`, (#V, 3).

        Raises
        ------
        MeshError
            There is no such file, or it is another subject's.
        """
        path = self.subject / "surf" / f"{self.name}.sphere.reg"
        if not path.is_file():
            raise MeshError(
                f"{path} is missing, by which a template's cuts are carried over: run recon-all -surfreg, or "
                "use cuts='found' with medial_wall='label'"
            )
        sphere = read_file(path)
        if len(sphere.V) != len(self.V):
            raise MeshError(
                f"{path} has {len(sphere.V)} vertices, and the surfaces of {self.subject} have "
                f"{len(self.V)}: it is another subject's, or of another run"
            )
        return directions(sphere.V, str(path))

    def labelled_wall(self) -> BoolArray:
        """The vertices that are not in `label/?h.cortex.label`, (#V,).

        Raises
        ------
        MeshError
            There is no such file, or it is another subject's.
        """
        path = self.subject / "label" / f"{self.name}.cortex.label"
        if not path.is_file():
            raise MeshError(f"{path} is missing, which tells the medial wall: use medial_wall='template'")
        freesurfer = import_optional("nibabel.freesurfer", HOW_TO_GET)
        cortex = np.atleast_1d(call_reader(freesurfer.read_label, path)).astype(np.int64)
        if not len(cortex):
            raise MeshError(f"{path} has no vertices: is it a label? use medial_wall='template'")
        if cortex.min() < 0 or cortex.max() >= len(self.V):
            raise MeshError(
                f"{path} has vertices {cortex.min()} to {cortex.max()}, and the surfaces of "
                f"{self.subject} have {len(self.V)}: it is another subject's"
            )
        wall = np.ones(len(self.V), dtype=bool)
        wall[cortex] = False
        return wall


def directions(points: FloatArray, name: str) -> FloatArray:
    """Points of a sphere around the origin, as unit vectors."""
    points = vertex_array(points)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    if not (length > 0).all() or length.max() > 1.5 * length.min():
        raise MeshError(f"{name} is no sphere around the origin: give a registered sphere, as ?h.sphere.reg")
    return np.asarray(points / length)
