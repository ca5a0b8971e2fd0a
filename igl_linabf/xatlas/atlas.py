"""The class `Atlas` and the function `parametrize` of xatlas-python."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._types import FloatArray, IntArray
from ..errors import first_few, format_count
from ..surface import check_finite, face_array, vertex_array
from ..textures import find_covered_texels
from .arrays import check_shape
from .options import ChartOptions, ChartType, PackOptions, warn_of_ignored_options
from .packed_meshes import GivenMesh, PackedMesh, pack_uv_meshes, unwrap_meshes

UInts = NDArray[np.uint32]
Arrays = tuple[UInts, UInts, NDArray[np.float32]]
COLOURS = (64, 256)  # range of each colour channel of a chart in an image


@dataclass(frozen=True, eq=False)
class Chart:
    """One chart of a mesh.

    Attributes
    ----------
    faces : (#f,) uint32
        Row indices into the mesh's faces.
    atlas_index : int
        The page of the chart.
    type : ChartType
    material : int
        The material of the chart's faces; 0 if the mesh has no materials.
    """

    faces: UInts
    atlas_index: int
    type: ChartType
    material: int


class Atlas:
    """Meshes that share an atlas, with the interface of `xatlas.Atlas` in xatlas-python.

    `add_mesh` or `add_uv_mesh` adds meshes, and `generate` computes the atlas. `atlas[i]` then returns three
    arrays of mesh i. Page, width and utilization refer to the pages, which xatlas calls atlases.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> atlas = Atlas()
    >>> atlas.add_mesh(V, F)
    >>> atlas.add_mesh(2 * V, F)
    >>> atlas.generate()
    >>> vmapping, indices, uvs = atlas[1]
    >>> len(atlas), atlas.atlas_count, atlas.width, bool((vmapping[indices] == F).all())
    (2, 1, 1024, True)
    """

    def __init__(self) -> None:
        self._given: list[GivenMesh] = []
        self._has_given_uv = False
        self._packed: list[PackedMesh] = []
        self._size = 0
        self._texels_per_unit = 0.0
        self._has_image = False

    def add_mesh(
        self,
        positions: ArrayLike,
        indices: ArrayLike,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
    ) -> None:
        """Add a mesh that `generate` unwraps.

        Parameters
        ----------
        positions : (#V, 3) float
        indices : (#F, 3) int
        normals, uvs : (#V, 3) and (#V, 2) float, optional
            Only their shapes are checked; the atlas does not depend on them.

        Raises
        ------
        ValueError
            A shape is wrong, an array is empty, or a position of a face is not finite.
        RuntimeError
            An index is out of range, or the atlas has texture coordinates of `add_uv_mesh`.
        """
        n = check_shape("positions", positions, 3)
        for name, array, columns in (("normals", normals, 3), ("uvs", uvs, 2)):
            if array is not None:
                check_shape(name, array, columns, n)
        check_shape("indices", indices, 3)
        self._add_given_mesh(vertex_array(positions, 3, "positions"), indices, None)

    def add_uv_mesh(
        self, uvs: ArrayLike, indices: ArrayLike, face_materials: ArrayLike | None = None
    ) -> None:
        """Add texture coordinates whose charts `generate` packs without changing their shapes.

        Parameters
        ----------
        uvs : (#V, 2) float
        indices : (#F, 3) int
        face_materials : (#F,) or (#F, 1) int, optional
            Faces of different materials are in different charts.

        Raises
        ------
        ValueError
            A shape is wrong, an array is empty, or texture coordinates of a face are not finite.
        RuntimeError
            An index is out of range, or the atlas has meshes of `add_mesh`.
        """
        check_shape("uvs", uvs, 2)
        n_faces = check_shape("indices", indices, 3)
        materials = None
        if face_materials is not None:
            column = np.array(face_materials, dtype=np.int64)
            column = column[:, None] if column.ndim == 1 else column
            check_shape("face_materials", column, 1, n_faces)
            materials = column.ravel()
        self._add_given_mesh(vertex_array(uvs, 2, "uvs"), indices, materials, is_uv=True)

    def _add_given_mesh(
        self, points: FloatArray, indices: ArrayLike, materials: IntArray | None, *, is_uv: bool = False
    ) -> None:
        F = face_array(indices)
        bad = np.flatnonzero(((F < 0) | (len(points) <= F)).any(axis=1))
        if len(bad):
            raise RuntimeError(
                f"faces {first_few(bad)} have indices that are out of range for "
                f"{format_count(len(points), 'vertex')} "
                f"(face {bad[0]} is {F[bad[0]].tolist()}): correct them"
            )
        if self._given and self._has_given_uv != is_uv:
            raise RuntimeError("an atlas has meshes either of add_mesh or of add_uv_mesh: use two atlases")
        used = np.unique(F)
        check_finite(points[used], used, "uvs" if is_uv else "positions")
        self._has_given_uv = is_uv
        # copies, because the caller may change the arrays before `generate`
        self._given.append(GivenMesh(points.copy(), F.copy(), materials))

    def generate(
        self,
        chart_options: ChartOptions | None = None,
        pack_options: PackOptions | None = None,
        verbose: bool = False,
    ) -> None:
        """Compute the atlas of all meshes.

        Parameters
        ----------
        chart_options : ChartOptions, optional
        pack_options : PackOptions, optional
        verbose : bool
            Print a line about the atlas.

        Raises
        ------
        MeshError
            There are too many charts for the padding.

        Warns
        -----
        FallbackWarning
            Options are ignored.
        OutcomeWarning
            A chart has flipped faces, or still overlaps itself.
        """
        charts, pack = chart_options or ChartOptions(), pack_options or PackOptions()
        warn_of_ignored_options(charts, pack, keeps_rotation=self._has_given_uv)
        if not self._given:
            return
        make = pack_uv_meshes if self._has_given_uv else unwrap_meshes
        made = make(self._given, pack)
        self._packed, self._size, self._has_image = made.meshes, made.resolution, pack.create_image
        self._texels_per_unit = made.scale * made.resolution
        if verbose:
            pages = f"{self.atlas_count} x {self.width} x {self.height} texels"
            print(f"{format_count(self.chart_count, 'chart')} on {pages}, {self.utilization:.0%} filled")

    def get_mesh(self, mesh_index: int) -> Arrays:
        """Return the vertices, the faces and the texture coordinates of a mesh.

        Parameters
        ----------
        mesh_index : int

        Returns
        -------
        vmapping : (#N,) uint32
            The given vertex of each vertex; a vertex at a seam occurs several times.
        indices : (#F, 3) uint32
            The given faces in their order, with the new vertices: `vmapping[indices]` are the given faces.
        uvs : (#N, 2) float32
            From 0 to 1 on the page of the vertex, v upwards.

        Raises
        ------
        IndexError
            The atlas has no such mesh.
        """
        mesh = self._get_mesh(mesh_index)
        return mesh.origin.astype(np.uint32), mesh.indices.astype(np.uint32), mesh.uv.astype(np.float32)

    def __getitem__(self, mesh_index: int) -> Arrays:
        return self.get_mesh(mesh_index)

    def __len__(self) -> int:
        return self.mesh_count

    @property
    def mesh_count(self) -> int:
        """Number of meshes, 0 before `generate`."""
        return len(self._packed)

    @property
    def atlas_count(self) -> int:
        """Number of pages."""
        return max((int(mesh.page.max(initial=0)) + 1 for mesh in self._packed), default=0)

    @property
    def chart_count(self) -> int:
        """Number of charts of all meshes."""
        return sum(len(mesh.page) for mesh in self._packed)

    @property
    def width(self) -> int:
        """Width of a page in texels."""
        return self._size

    @property
    def height(self) -> int:
        """Height of a page in texels."""
        return self._size

    @property
    def texels_per_unit(self) -> float:
        """Texels per unit of length of the positions."""
        return self._texels_per_unit

    @property
    def utilization(self) -> float:
        """Share of the first page that charts cover."""
        return self.get_utilization(0)

    def get_utilization(self, atlas_index: int) -> float:
        """Return the share of a page that charts cover."""
        self._check_page(atlas_index)
        return sum(float(mesh.areas[mesh.page_of_faces == atlas_index].sum()) for mesh in self._packed)

    def get_mesh_vertex_assignment(self, mesh_index: int) -> tuple[UInts, UInts]:
        """Return the page and the chart of each vertex of a mesh.

        Charts are numbered over all meshes. Vertices of pieces without area have the number 2**32 - 1.
        """
        mesh = self._get_mesh(mesh_index)
        chart = mesh.chart_of_vertices
        page = np.append(mesh.page, -1)[chart]
        chart[chart >= 0] += self._count_charts_before(mesh_index)
        return page.astype(np.uint32), chart.astype(np.uint32)

    def get_mesh_chart_count(self, mesh_index: int) -> int:
        """Return the number of charts of a mesh."""
        return len(self._get_mesh(mesh_index).page)

    def get_mesh_chart(self, mesh_index: int, chart_index: int) -> Chart:
        """Return a chart of a mesh; charts are numbered within the mesh."""
        mesh = self._get_mesh(mesh_index)
        _check_index("Chart", chart_index, len(mesh.page), "mesh")
        faces = np.flatnonzero(mesh.chart == chart_index)
        materials = self._given[mesh_index].materials
        material = 0 if materials is None else int(materials[faces[0]])
        return Chart(faces.astype(np.uint32), int(mesh.page[chart_index]), ChartType.LSCM, material)

    @property
    def chart_image(self) -> NDArray[np.uint8]:
        """An image of the first page, as `get_chart_image` returns."""
        return self.get_chart_image(0)

    def get_chart_image(self, atlas_index: int) -> NDArray[np.uint8]:
        """Return an image of a page, (height, width, 3), with a colour for each chart on black.

        Row y shows v = (y + 1/2) / height, as in xatlas. `image[::-1]` has v upwards.

        Raises
        ------
        IndexError
            The atlas has no page with this number.
        RuntimeError
            `PackOptions.create_image` was not set.
        """
        self._check_page(atlas_index)
        if not self._has_image:
            raise RuntimeError("the atlas has no image: set PackOptions.create_image before generate")
        colours = np.random.default_rng(0).integers(*COLOURS, (self.chart_count, 3), np.uint16)
        image = np.zeros((self.height, self.width, 3), dtype=np.uint8)
        for i, mesh in enumerate(self._packed):
            on = np.flatnonzero(mesh.page_of_faces == atlas_index)
            texels = find_covered_texels(
                mesh.uv[mesh.indices[on]] * self._size - 0.5, (self.width, self.height)
            )
            image.reshape(-1, 3)[texels.index] = colours[
                self._count_charts_before(i) + mesh.chart[on[texels.face]]
            ]
        return image

    def _count_charts_before(self, mesh_index: int) -> int:
        """Return the number of charts of all meshes before the given mesh: the number of its first chart."""
        return sum(len(mesh.page) for mesh in self._packed[:mesh_index])

    def _get_mesh(self, mesh_index: int) -> PackedMesh:
        _check_index("Mesh", mesh_index, len(self._packed), "atlas")
        return self._packed[mesh_index]

    def _check_page(self, atlas_index: int) -> None:
        _check_index("Atlas", atlas_index, self.atlas_count, "result")


def parametrize(
    positions: ArrayLike, indices: ArrayLike, normals: ArrayLike | None = None, uvs: ArrayLike | None = None
) -> Arrays:
    """Unwrap a mesh onto one page, with the interface of `xatlas.parametrize` in xatlas-python.

    Parameters
    ----------
    positions : (#V, 3) float
    indices : (#F, 3) int
        Any triangles, repaired as by `clean`. Vertices at the same position count as one vertex.
    normals, uvs : (#V, 3) and (#V, 2) float, optional
        Only their shapes are checked.

    Returns
    -------
    vmapping, indices, uvs : (#N,) uint32, (#F, 3) uint32 and (#N, 2) float32
        As from `Atlas.get_mesh`.

    Raises
    ------
    ValueError
        A shape is wrong, an array is empty, or a position of a face is not finite.
    RuntimeError
        An index is out of range.

    Examples
    --------
    >>> import igl
    >>> import igl_linabf.xatlas as xatlas
    >>> V, F = igl.icosahedron()
    >>> vmapping, indices, uvs = xatlas.parametrize(V, F)
    >>> bool((vmapping[indices] == F).all()), uvs.dtype
    (True, dtype('float32'))
    """
    atlas = Atlas()
    atlas.add_mesh(positions, indices, normals, uvs)
    atlas.generate()
    return atlas[0]


def _check_index(kind: str, index: int, number: int, of: str) -> None:
    if not 0 <= index < number:
        raise IndexError(f"{kind} index {index} is out of bounds: the {of} has {number}")
