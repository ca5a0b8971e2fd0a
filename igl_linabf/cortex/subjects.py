"""Read the surfaces and the labels of a FreeSurfer subject's hemispheres."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError
from ..io import average_surfaces, call_reader, find_companion_surfaces, import_optional, read_file
from ..surface import vertex_array

HemisphereName = Literal["lh", "rh"]
HEMISPHERE_NAMES: tuple[HemisphereName, ...] = get_args(HemisphereName)
INSTALL_HINT = "pip install 'igl-linabf[cortex]' reads subjects"


@dataclass(frozen=True, eq=False)
class Hemisphere:
    """A hemisphere of a FreeSurfer subject.

    Attributes
    ----------
    subject : Path
    name : {"lh", "rh"}
    V : (#V, 3) float64
        Vertices of the cortex in mm, midway between the white matter and the pial surface.
    F : (#F, 3) int64
    """

    subject: Path
    name: HemisphereName
    V: FloatArray
    F: IntArray

    @classmethod
    def of_subject(cls, subject: str | os.PathLike[str], name: HemisphereName) -> Hemisphere:
        """Read a subject's `surf/?h.fiducial` or, if it is missing, the mean of its white and pial surfaces.

        Raises
        ------
        MeshError
            The folder is not a subject, or the hemisphere has no surface.
        """
        folder = Path(subject)
        if name not in HEMISPHERE_NAMES:
            raise ValueError(f"the hemisphere is {name!r}: use 'lh' or 'rh'")
        paths = find_companion_surfaces(folder / "surf", name)
        if not paths:
            raise MeshError(
                f"{folder} has no surf/{name}.fiducial, .midthickness, .smoothwm, .white or .pial: give the "
                "folder of a FreeSurfer subject"
            )
        mesh = average_surfaces([read_file(path) for path in paths])
        return cls(folder, name, mesh.V, mesh.triangles)

    def registered_sphere(self) -> FloatArray:
        """Return the vertices of `surf/?h.sphere.reg` as unit vectors, (#V, 3).

        Raises
        ------
        MeshError
            The file does not exist, or belongs to another subject.
        """
        path = self.subject / "surf" / f"{self.name}.sphere.reg"
        if not path.is_file():
            raise MeshError(
                f"{path} is missing, which the transfer of a template needs: run recon-all -surfreg, or "
                "use cuts='found' with medial_wall='label'"
            )
        sphere = read_file(path)
        if len(sphere.V) != len(self.V):
            raise MeshError(
                f"{path} has {len(sphere.V)} vertices, and the surfaces of {self.subject} have "
                f"{len(self.V)}: it is another subject's, or from another run"
            )
        return scale_to_unit_sphere(sphere.V, str(path))

    def labelled_wall(self) -> BoolArray:
        """Return True for the vertices that are not in `label/?h.cortex.label`, (#V,).

        Raises
        ------
        MeshError
            The file does not exist, or belongs to another subject.
        """
        path = self.subject / "label" / f"{self.name}.cortex.label"
        if not path.is_file():
            raise MeshError(f"{path} is missing, which defines the medial wall: use medial_wall='template'")
        freesurfer = import_optional("nibabel.freesurfer", INSTALL_HINT)
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


def scale_to_unit_sphere(points: FloatArray, name: str) -> FloatArray:
    """Scale points on a sphere around the origin to unit length."""
    points = vertex_array(points)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    if not (length > 0).all() or length.max() > 1.5 * length.min():
        raise MeshError(f"{name} is not a sphere around the origin: give a registered sphere, ?h.sphere.reg")
    return np.asarray(points / length)
