"""The colours that a mesh has at its corners, wherever its file has them."""

import numpy as np

from .._types import FloatArray
from .materials import WHITE, linear, srgb
from .mesh_file import MeshFile

ONE = (1.0, 1.0, 1.0, 1.0)  # as a factor


def given_colours(mesh: MeshFile) -> FloatArray | None:
    """The colours at the corners (#C, 3 or 4), of corners, faces or vertices, without those of materials."""
    extras, polygons = mesh.extras, mesh.polygons
    if extras.corner_colours is not None:
        return extras.corner_colours
    if extras.face_colours is not None:
        return extras.face_colours[polygons.owner]
    return None if extras.colours is None else extras.colours[polygons.corners]


def corner_colours(mesh: MeshFile) -> FloatArray | None:
    """The colours at the corners of the faces, (#C, 3 or 4), from 0 to 1; None if there are none.

    In glTF and 3MF they are those of vertices times those of materials, proportional to light. Else those
    of corners, faces or vertices count, or if there are none, those of materials. There are four columns if
    one is transparent.
    """
    extras, polygons = mesh.extras, mesh.polygons
    n, looks, given = len(polygons.corners), extras.looks or (), given_colours(mesh)
    alone = given is None
    if given is None:
        if all(look.factor is None and look.colour == WHITE for look in looks):
            return None
        given = np.ones((n, 4))
    made = np.column_stack((given[:, :3], given[:, 3] if given.shape[1] > 3 else np.ones(n)))
    factors = [
        look.factor or ((*linear(np.array(look.colour)), look.alpha) if alone else ONE) for look in looks
    ]
    if extras.materials is not None and set(factors) - {ONE}:
        of = np.array([*factors, ONE])[extras.materials[1]][polygons.owner]  # -1 is none, and the last
        made = np.column_stack((srgb(linear(made[:, :3]) * of[:, :3]), made[:, 3] * of[:, 3]))
    return made if (made[:, 3] < 1).any() else made[:, :3]
