"""How good a flat map is: angles, stretch, areas, flips, overlaps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .errors import MeshError
from .mesh import check_finite, compact, complex_positions, face_array, measure, vertex_array
from .overlaps import overlaps
from .tables import aligned
from .topology import NEXT, PREV, ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class Quality:
    """Distortion of a flat map, as numbers; `print` shows them as a table.

    Attributes
    ----------
    angle_distortion : float
        The paper's F/3nt: mean over corners of ((angle in uv - angle in 3-D) / angle in 3-D)^2.
    angle_error : float
        The same unweighted: mean of (angle in uv - angle in 3-D)^2, in square radians.
    conformal_distortion : float
        Quasi-conformal distortion sigma1 / sigma2, its mean by area in 3-D; 1 is best. Infinite
        where a triangle has collapsed.
    conformal_distortion_max : float
        The largest one.
    area_distortion : float
        Mean by area of `|log(area in uv / area in 3-D)|`, both of total 1; 0 is best. Infinite
        where a triangle has collapsed.
    stretch_l2, stretch_linf : float
        Root mean square and largest stretch of Sander et al. 2001, normalised by area; 1 is best.
        Infinite where a triangle has collapsed.
    flips : int
        Triangles whose area in uv is not positive (`igl.flipped_triangles`, and the collapsed).
    overlaps : int
        Pairs of triangles of one chart that lie over each other (`igl_linabf.overlaps`).
    faces : int
        Number of triangles.
    """

    angle_distortion: float
    angle_error: float
    conformal_distortion: float
    conformal_distortion_max: float
    area_distortion: float
    stretch_l2: float
    stretch_linf: float
    flips: int
    overlaps: int
    faces: int

    def __str__(self) -> str:
        return table({"": self})


ROWS = {
    "faces": "triangles",
    "flips": "flipped triangles",
    "overlaps": "overlapping pairs",
    "angle_distortion": "angle distortion F/3nt",
    "angle_error": "mean squared angle error, rad^2",
    "conformal_distortion": "conformal distortion, mean",
    "conformal_distortion_max": "conformal distortion, largest",
    "area_distortion": "area distortion",
    "stretch_l2": "stretch, L2",
    "stretch_linf": "stretch, largest",
}


def table(columns: Mapping[str, Quality], extra: Mapping[str, Mapping[str, str]] | None = None) -> str:
    """Several maps' qualities side by side as text, one map a column.

    Parameters
    ----------
    columns : mapping of name to Quality
    extra : mapping of label to mapping of name to text, optional
        Rows to put below.
    """
    cells = [["", *columns]] if any(columns) else []
    for name, label in ROWS.items():
        values = (getattr(quality, name) for quality in columns.values())
        cells.append([label, *(f"{v:,d}" if isinstance(v, int) else f"{v:.4g}" for v in values)])
    for label, texts in (extra or {}).items():
        cells.append([label, *(texts.get(name, "") for name in columns)])
    return aligned(cells)


def quality(V: ArrayLike, F: ArrayLike, uv: ArrayLike) -> Quality:
    """Measure the distortion of a flat map.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Triangles; any number of pieces, loops and handles.
    uv : (#V, 2) float
        The map, of any scale; not a number only where no face refers to.

    Returns
    -------
    Quality

    Raises
    ------
    MeshError
        The arrays do not fit together, `V` or `uv` is not finite, or a face has no area in 3-D.

    Examples
    --------
    >>> import numpy as np
    >>> V, F = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])
    >>> stretched = quality(V, F, [[0, 0], [1, 0], [0, 1]])
    >>> stretched.conformal_distortion, round(stretched.stretch_l2, 4), stretched.flips
    (2.0, 1.118, 0)
    """
    positions, faces, map_ = vertex_array(V), face_array(F), vertex_array(uv, 2, "uv")
    if len(map_) != len(positions):
        raise MeshError(f"uv has {len(map_)} rows for {len(positions)} vertices: pass one row a vertex")
    vertices, faces = compact(faces, len(positions))
    positions, map_ = positions[vertices], map_[vertices]
    check_finite(positions, vertices)
    check_finite(map_, vertices, "uv")
    corner = np.ascontiguousarray(faces.T)
    double_area, dot = measure(positions, corner, vertices)
    z = complex_positions(map_)[corner]
    right, left = z[NEXT] - z, z[PREV] - z
    cross = right.conj() * left  # its argument is the angle, its imaginary part twice the area
    signed = cross[0].imag
    error = np.arctan2(np.abs(cross.imag), cross.real)
    alpha = np.arctan2(double_area, dot)
    error -= alpha
    major, minor = _singular_values(positions, corner, double_area, dot, right[0], left[0])
    weight = double_area / double_area.sum()
    scale = np.abs(signed).sum() / double_area.sum()  # of areas
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(minor > 0, major / minor, np.inf)
        area = np.abs(np.log(np.abs(signed) / double_area / scale))
        stretch = scale * (minor**-2.0 + major**-2.0) / 2
        largest = np.sqrt(scale) / minor
    return Quality(
        angle_distortion=float(((error / alpha) ** 2).mean()),
        angle_error=float((error**2).mean()),
        conformal_distortion=float(weight @ ratio),
        conformal_distortion_max=float(ratio.max()),
        area_distortion=float(weight @ area),
        stretch_l2=float(np.sqrt(weight @ stretch)),
        stretch_linf=float(largest.max()),
        flips=int(np.count_nonzero(~(signed > 0))),
        overlaps=len(overlaps(map_, faces)),
        faces=len(faces),
    )


def _singular_values(
    V: FloatArray,
    corner: IntArray,
    double_area: FloatArray,
    dot: FloatArray,
    right: ComplexArray,
    left: ComplexArray,
) -> tuple[FloatArray, FloatArray]:
    """Singular values of each triangle's map from its plane to uv, the larger ones first.

    `right` and `left` are the sides from corner 0 to corners 1 and 2 in uv.
    """
    length = np.linalg.norm(V[corner[1]] - V[corner[0]], axis=1)
    # columns of the Jacobian in the frame of side 0-1: right = l c1, left = (dot c1 + 2 A c2) / l
    c1 = right / length
    c2 = (left * length - dot[0] * c1) / double_area
    p, q = (c1 - 1j * c2) / 2, (c1 + 1j * c2) / 2  # f(w) = p w + q conj(w)
    major = np.abs(p) + np.abs(q)
    determinant = np.abs((c1.conj() * c2).imag)
    with np.errstate(divide="ignore", invalid="ignore"):
        return major, np.where(major > 0, determinant / major, 0.0)
