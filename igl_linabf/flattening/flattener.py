"""Flatten the same triangles repeatedly, with moving vertices."""

from __future__ import annotations

from numpy.typing import ArrayLike

from .._runtime import Progress
from ..surface import PlanarFaces
from .boundary_shapes import BoundaryName
from .functions import flatten_mesh
from .methods import Method
from .result import Flattening


class Flattener:
    """A flattener of meshes that share their triangles.

    All results that depend only on the triangles are computed once: the check of the triangles, their edges
    and loops, the sparsity pattern of the linear system, and its symbolic factorization.

    Parameters
    ----------
    F : (#F, 3) int
        Oriented triangles of one disk, with or without holes.

    Raises
    ------
    MeshError
        The surface is not one oriented manifold piece with a boundary and without handles.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> flattener = Flattener(F[1:])
    >>> [flattener.flatten(V * [1, 1, z]).uv.shape for z in (1.0, 1.1)]
    [(12, 2), (12, 2)]
    """

    def __init__(self, F: ArrayLike) -> None:
        self._faces = PlanarFaces.from_faces(F)

    def flatten(
        self,
        V: ArrayLike,
        b: ArrayLike | None = None,
        bc: ArrayLike | None = None,
        *,
        method: str | Method = "linabf",
        outer: int | None = None,
        boundary: BoundaryName | ArrayLike = "free",
        corners: ArrayLike | None = None,
        up: ArrayLike | None = None,
        progress: Progress = None,
    ) -> Flattening:
        """Flatten the triangles with vertices at `V`; the result is bitwise that of `flatten(V, F, ...)`.

        Parameters
        ----------
        V : (#V, 3) float
            Vertex positions.
        b, bc, method, outer, boundary, corners, up, progress
            As in `igl_linabf.flatten`; they may differ between calls.

        Returns
        -------
        Flattening
            As in `igl_linabf.flatten`.

        Raises
        ------
        MeshError
            `V` is malformed or too short, a face is degenerate, `outer` is not on a boundary loop, or the
            pins are not two different vertices.

        Examples
        --------
        >>> import igl
        >>> V, F = igl.icosahedron()
        >>> Flattener(F[1:]).flatten(V, [0, 1], [[0, 0], [1, 0]], method="abf").uv.shape
        (12, 2)
        """
        return flatten_mesh(
            lambda: self._faces.with_positions(V, outer), method, b, bc, progress, boundary, corners, up
        )
