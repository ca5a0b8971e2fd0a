"""Meshes as xatlas returns them: vertices are duplicated at seams, and each has a page and a chart."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .._types import FloatArray, IntArray
from ..charts import UDIM_ROW, PackedChart, Packing, pack_charts, pack_together, unwrap
from ..charts import Atlas as UnwrappedMesh
from ..errors import MeshWarning
from ..surface import (
    complex_positions,
    has_distinct_corners,
    label_face_components,
    merge_coincident,
    real_coordinates,
    signed_double_areas,
)
from .options import PackOptions

DEFAULT_RESOLUTION = 1024  # texels along a page if the options do not determine them
FILTERED_TEXELS = 2  # texels between charts such that no bilinear lookup reads texels of two charts
ROUNDING = 1e-14  # largest double area that counts as zero, relative to the largest coordinate squared


@dataclass(frozen=True, eq=False)
class GivenMesh:
    """A checked mesh: positions in space, or texture coordinates with a material for each face."""

    V: FloatArray
    F: IntArray
    materials: IntArray | None = None


@dataclass(frozen=True, eq=False)
class PackedMesh:
    """A mesh with its place in the atlas.

    Attributes
    ----------
    origin : (#N,) int64
        The given vertex of each vertex.
    indices : (#F, 3) int64
    uv : (#N, 2) float64
        Texture coordinates, relative to the page of each vertex.
    chart : (#F,) int64
        Chart of each face, numbered within the mesh; -1 for faces of pieces without area.
    page : (#charts,) int64
    """

    origin: IntArray
    indices: IntArray
    uv: FloatArray
    chart: IntArray
    page: IntArray

    @property
    def chart_of_vertices(self) -> IntArray:
        """Chart of each vertex, or -1."""
        chart = np.full(len(self.origin), -1)
        chart[self.indices] = self.chart[:, None]
        return chart

    @property
    def page_of_faces(self) -> IntArray:
        """Page of each face, or -1."""
        return _index_or_minus_one(self.page, self.chart)

    @property
    def areas(self) -> FloatArray:
        """Area of each face, as a share of a page."""
        z = complex_positions(self.uv)
        return np.abs(signed_double_areas(z, np.ascontiguousarray(self.indices.T))) / 2


@dataclass(frozen=True, eq=False)
class PackedMeshes:
    """Meshes on common pages.

    Attributes
    ----------
    meshes : list of PackedMesh
    resolution : int
        Texels along a page's side.
    scale : float
        Page widths per unit of length.
    """

    meshes: list[PackedMesh]
    resolution: int
    scale: float


def unwrap_meshes(meshes: Sequence[GivenMesh], options: PackOptions) -> PackedMeshes:
    """Unwrap meshes onto common pages."""
    resolution = options.resolution or DEFAULT_RESOLUTION
    packing = _make_packing(options, resolution)
    atlases = [_unwrap_quietly(mesh, packing) for mesh in meshes]
    if len(atlases) > 1:
        atlases = pack_together(atlases, packing)
    scale = max(atlas.report.scale for atlas in atlases)
    if _is_resolution_open(options) and scale:
        resolution = int(np.ceil(options.texels_per_unit / scale))
        atlases = pack_together(atlases, _make_packing(options, resolution))
        scale = max(atlas.report.scale for atlas in atlases)
    made = [_split_at_seams(*pair) for pair in zip(meshes, atlases, strict=True)]
    return PackedMeshes(made, resolution, scale)


def pack_uv_meshes(meshes: Sequence[GivenMesh], options: PackOptions) -> PackedMeshes:
    """Pack the charts of texture coordinates onto common pages without changing their shapes."""
    divided = [_divide_into_charts(mesh) for mesh in meshes]
    charts = [chart for mesh in divided for chart in _list_charts(mesh)]
    rotate = options.rotate_charts or options.rotate_charts_to_axis
    resolution = options.resolution or DEFAULT_RESOLUTION
    placed = pack_charts(charts, _make_packing(options, resolution), rotate=rotate)
    if _is_resolution_open(options) and placed:
        resolution = int(np.ceil(options.texels_per_unit / abs(placed[0].ratio)))
        placed = pack_charts(charts, _make_packing(options, resolution), rotate=rotate)
    made, first = [], 0
    for mesh in divided:
        made.append(_place_charts(mesh, placed[first : first + len(mesh.page)]))
        first += len(mesh.page)
    return PackedMeshes(made, resolution, abs(placed[0].ratio) if placed else 0.0)


def _is_resolution_open(options: PackOptions) -> bool:
    """Return True if the resolution of the page follows from `texels_per_unit`."""
    return not options.resolution and bool(options.texels_per_unit)


def _make_packing(options: PackOptions, resolution: int) -> Packing:
    """Return the packing at a resolution, with the texel density if the options determine both."""
    density = options.texels_per_unit or None if options.resolution else None
    padding = max(options.padding, FILTERED_TEXELS * options.bilinear)
    return Packing(resolution=resolution, padding=padding, texel_density=density)


def _place_charts(mesh: PackedMesh, placed: Sequence[PackedChart]) -> PackedMesh:
    """Move the charts of a mesh to their places; vertices without a chart are at the corner of the page."""
    page = np.array([chart.page for chart in placed], dtype=np.int64)
    ratio, shift = np.array([*((chart.ratio, chart.shift) for chart in placed), (0, 0)]).T  # 0 for chart -1
    at = mesh.chart_of_vertices
    z = ratio[at] * complex_positions(mesh.uv) + shift[at]
    return replace(mesh, uv=_make_page_relative(real_coordinates(z), page, at), page=page)


def _unwrap_quietly(mesh: GivenMesh, packing: Packing) -> UnwrappedMesh:
    """Unwrap a mesh isometrically, without the warning that lists repairs.

    Vertices at the same position are merged, because many programs duplicate vertices at creases and seams.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "the mesh is repaired", MeshWarning)
        return unwrap(mesh.V, mesh.F, method="isometric", weld=0, packing=packing, progress=False)


def _split_at_seams(mesh: GivenMesh, atlas: UnwrappedMesh) -> PackedMesh:
    """Return an output vertex for each pair of input vertex and texture coordinates, chart by chart."""
    n = len(mesh.V)
    pairs, corner = np.unique(np.asarray(atlas.FTC) * n + mesh.F, return_inverse=True)
    indices = corner.reshape(mesh.F.shape)
    split = PackedMesh(pairs % n, indices, atlas.TC[pairs // n], atlas.chart, atlas.page)
    return replace(split, uv=_make_page_relative(split.uv, atlas.page, split.chart_of_vertices))


def _divide_into_charts(mesh: GivenMesh) -> PackedMesh:
    """Return the unpacked charts of texture coordinates. Connected faces of one material form a chart."""
    n = len(mesh.V)
    material = np.zeros(len(mesh.F), np.int64) if mesh.materials is None else mesh.materials
    layer = np.unique(material, return_inverse=True)[1].ravel()
    point = merge_coincident(mesh.V, np.unique(mesh.F))[mesh.F] + n * layer[:, None]
    used, point = np.unique(point, return_inverse=True)
    label = label_face_components(point.reshape(mesh.F.shape), len(used))
    area = signed_double_areas(complex_positions(mesh.V), np.ascontiguousarray(mesh.F.T))
    size = np.zeros(label.max() + 1)
    np.maximum.at(size, label, np.abs(mesh.V[mesh.F]).max(axis=(1, 2)))
    solid = np.bincount(label, np.abs(area)) > ROUNDING * size**2
    chart = np.where(solid, np.cumsum(solid) - 1, -1)[label]
    pairs, corner = np.unique((chart * n)[:, None] + mesh.F, return_inverse=True)
    origin, page = pairs % n, np.zeros(np.count_nonzero(solid), dtype=np.int64)
    return PackedMesh(origin, corner.reshape(mesh.F.shape), mesh.V[origin], chart, page)


def _list_charts(mesh: PackedMesh) -> list[tuple[FloatArray, IntArray]]:
    """Return the points and the triangles of each chart. The vertices of a chart must be consecutive."""
    order = np.flatnonzero((mesh.chart >= 0) & has_distinct_corners(mesh.indices))
    order = order[np.argsort(mesh.chart[order], kind="stable")]
    numbers = np.arange(len(mesh.page) + 1)
    face = np.searchsorted(mesh.chart[order], numbers)
    vertex = np.searchsorted(mesh.chart_of_vertices, numbers)
    return [
        (mesh.uv[vertex[i] : vertex[i + 1]], mesh.indices[order[face[i] : face[i + 1]]] - vertex[i])
        for i in range(len(mesh.page))
    ]


def _make_page_relative(uv: FloatArray, page: IntArray, chart: IntArray) -> FloatArray:
    """Return coordinates relative to the page of each vertex' chart, in place of UDIM tiles."""
    on = np.maximum(_index_or_minus_one(page, chart), 0)
    return np.asarray(uv - np.column_stack((on % UDIM_ROW, on // UDIM_ROW)))


def _index_or_minus_one(values: IntArray, index: IntArray) -> IntArray:
    """Return `values[index]`, or -1 where the index is -1."""
    return np.append(values, -1)[index]
