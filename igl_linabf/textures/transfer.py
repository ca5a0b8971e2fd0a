"""Transfer images from old texture coordinates to an atlas."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import igl
import numpy as np
from numpy.typing import ArrayLike

from .._types import BoolArray, FloatArray, IntArray
from ..charts import FIRST_UDIM_TILE, parse_page_size
from ..errors import MeshError, first_few, format_count
from ..surface import Polygons, normalize_vectors, vertex_array
from .baking import check_image_memory, check_padding, list_pages, paint_page
from .coordinates import Coordinates, MappedTriangles
from .sampling import Picture
from .tangents import TangentFrames, change_frames, compute_tangent_frames
from .texels import Size, Texels

SMOOTH_NORMAL = (0.5, 0.5, 1.0, 1.0)  # RGBA of a direction along the normal in a normal map


def bake_texture(
    V: ArrayLike,
    F: Any,
    atlas: Coordinates,
    TC: ArrayLike,
    FTC: Any,
    images: Sequence[ArrayLike | Picture | None] | Picture | FloatArray,
    resolution: int | tuple[int, int],
    *,
    labels: ArrayLike | None = None,
    normals: ArrayLike | None = None,
    padding: int = 8,
    bare: float = 1.0,
) -> FloatArray:
    """Transfer images from old texture coordinates to an atlas.

    Each texel gets the value of the old image at the corresponding point of the surface, by bilinear
    interpolation, or from the nearest pixel if the `Picture` has `nearest=True`. Texels around a chart are
    filled as in `bake`.

    Parameters
    ----------
    V : (#V, 3) float
    F : (#F, 3) int
        The unwrapped faces, which may be polygons.
    atlas : Atlas, (#V, 2) float, or (TC, FTC)
        The new texture coordinates, as in `bake`.
    TC : (#TC, 2) float
        The old texture coordinates, with v pointing up.
    FTC : in the shape of `F`
        Rows of `TC` at the corners; -1 at corners without texture coordinates.
    images : (#rows, #columns[, k]) float, or a sequence of images, one per label
        Values from 0 to 1, with the upper row first. Images repeat beyond the unit square. None means that
        faces with this label have no image.
    resolution : int or (int, int)
        Texels along the side of a page, or its width and height.
    labels : (#F,) int, optional
        Image of each face, such as `mesh.extras.materials[1]`; -1 for faces without an image.
    normals : (#F, 3, 3) float, or "vertices", optional
        Normals at the corners, or "vertices" for the normals of the vertices. If given, the images are normal
        maps in tangent space, and are converted to the tangent frames (mikktspace) of the new map.
    padding : int
        Width in texels of an additional border around each chart.
    bare : float
        Value of all channels where a face has an image, but no old texture coordinates. By default the
        value is 1 (white), which does not change the colour of a material. In normal maps, such faces are
        smooth.

    Returns
    -------
    image : (height, width, k) float64
        As in `bake`. The shape is (#pages, height, width, k) if the atlas has several pages.

    Raises
    ------
    MeshError
        The arrays do not match, or no face has an image.
    ValueError
        The resolution is not positive.

    Examples
    --------
    >>> import igl, numpy as np, igl_linabf
    >>> V, F = igl.icosahedron()
    >>> old, new = (igl_linabf.unwrap(V, F, charts=charts, packing=igl_linabf.Packing(resolution=128))
    ...             for charts in (igl_linabf.ChartOptions(trade=0), igl_linabf.ChartOptions(trade=30)))
    >>> image = igl_linabf.textures.bake(V, F, old, V / 2 + 0.5, 128)
    >>> moved = bake_texture(V, F, new, old.TC, old.FTC, image, 128)
    >>> there = igl_linabf.textures.bake(V, F, new, V / 2 + 0.5, 128)
    >>> bool(np.median(abs(moved - there)[there > 0]) < 0.01)
    True
    """
    size, padding = parse_page_size(resolution), check_padding(padding)
    mapped = MappedTriangles.from_mesh(V, F, atlas)
    uv, is_bare = _get_old_coordinates(F, TC, FTC, mapped)
    pictures = _convert_images(images)
    label = _get_labels(labels, len(uv), len(pictures), mapped)
    pictures, label = _separate_tiles(pictures, label, uv, ~is_bare)
    frames = None if normals is None else _compute_frames(mapped, size, uv, normals)
    widths = {picture.pixels.shape[2] for picture in pictures if picture is not None}
    channels = (3 if max(widths) >= 3 else 1) + bool(widths & {2, 4})  # colours or grey, plus alpha
    check_image_memory(size, mapped.pages, channels)

    def values_at(shown: Texels) -> tuple[FloatArray, IntArray]:
        values = np.zeros((len(shown.index), channels))
        has = np.zeros(len(values), dtype=bool)
        for k, picture in enumerate(pictures):
            if picture is not None:
                rows = np.flatnonzero(label[shown.face] == k)
                has[rows] = True
                own = shown.select(rows)
                known = ~is_bare[own.face]
                values[rows[~known]] = bare if frames is None or channels < 3 else SMOOTH_NORMAL[:channels]
                values[rows[known]] = _sample_image(picture, own.select(known), uv, frames, channels)
        return values[has], shown.index[has]

    made = [paint_page(page, size, padding, 0.0, values_at) for page in list_pages(mapped, size)]
    return made[0] if len(made) == 1 else np.stack(made)


def _sample_image(
    picture: Picture,
    texels: Texels,
    uv: FloatArray,
    frames: tuple[TangentFrames, TangentFrames] | None,
    channels: int,
) -> FloatArray:
    """Look up an old image at the surface points of texels, and convert it to the number of channels."""
    found = picture.interpolate(texels.interpolate(uv))
    if found.shape[1] < 3 <= channels:  # a grey image, with or without alpha
        found = np.column_stack((np.repeat(found[:, :1], 3, axis=1), found[:, 1:]))
    missing = channels - found.shape[1]
    found = np.column_stack((found, np.ones((len(found), missing)))) if missing > 0 else found
    if frames is not None and channels >= 3:
        old, new = (TangentFrames(*(texels.interpolate(part) for part in frame)) for frame in frames)
        found[:, :3] = normalize_vectors(change_frames(2 * found[:, :3] - 1, old, new)) / 2 + 0.5
    return found


def _get_old_coordinates(
    F: Any, TC: ArrayLike, FTC: Any, mapped: MappedTriangles
) -> tuple[FloatArray, BoolArray]:
    """Return the old texture coordinates at the corners of the triangles, (#T, 3, 2).

    The second result is a mask of the triangles without texture coordinates, whose coordinates are 0.
    """
    polygons, points = Polygons.from_faces(F), vertex_array(TC, 2, "TC")
    texture = polygons.parse_texture_indices(FTC)
    bad = np.unique(texture.polygon_of_corner[texture.corners >= len(points)])
    if len(bad):
        raise MeshError(
            f"faces {first_few(bad)} refer to old texture coordinates outside 0..{len(points) - 1}: correct "
            "FTC"
        )
    place = mapped.split.place if mapped.split is not None else np.arange(polygons.sizes.sum()).reshape(-1, 3)
    if len(place) != len(mapped.F):
        raise MeshError(
            f"the atlas has {format_count(len(mapped.F), 'triangle')}, and F has {len(place)}: pass the "
            "unwrapped F"
        )
    rows = texture.corners[place]
    uv = np.concatenate((points, [[0.0, 0.0]]))[np.where(rows < 0, len(points), rows)]
    bad = np.flatnonzero(~np.isfinite(uv).all(axis=(1, 2)))
    if len(bad):
        raise MeshError(f"TC is NaN or infinite at triangles {first_few(bad)}: correct it")
    return np.asarray(uv), np.asarray((rows < 0).any(axis=1))


def _convert_images(images: Any) -> list[Picture | None]:
    """Convert the argument `images` of `bake_texture` to a list of pictures."""
    given = [images] if isinstance(images, Picture | np.ndarray) else list(images)
    made = []
    for i, image in enumerate(given):
        if image is not None and not isinstance(image, Picture):
            pixels = np.asarray(image, dtype=np.float64)
            pixels = pixels[:, :, None] if pixels.ndim == 2 else pixels
            if pixels.ndim != 3 or 0 in pixels.shape:
                raise MeshError(f"image {i} has the shape {pixels.shape}: pass rows, columns and channels")
            image = Picture(pixels)
        made.append(image)
    if all(picture is None for picture in made):
        raise MeshError("no face has an image: give an image for at least one label")
    return made


def _separate_tiles(
    pictures: list[Picture | None], label: IntArray, uv: FloatArray, is_mapped: BoolArray
) -> tuple[list[Picture | None], IntArray]:
    """Replace images of UDIM tiles by their tiles; return the pictures and the picture of each triangle.

    The middle of a triangle (#T, 3, 2) decides which tile it uses.
    """
    separated, label = pictures.copy(), label.copy()
    for k, picture in enumerate(pictures):
        if picture is None or not picture.tiles:
            continue
        mine = np.flatnonzero((label == k) & is_mapped)
        pages = picture.find_pages(uv[mine].mean(axis=1))
        lacking = ~np.isin(pages, list(picture.tiles))
        if lacking.any():
            tiles = np.unique(pages[lacking & (pages >= 0)]) + FIRST_UDIM_TILE
            where = (
                f"the UDIM tiles {first_few(tiles)}, which their image lacks"
                if len(tiles)
                else "no UDIM tile"
            )
            raise MeshError(
                f"triangles {first_few(mine[lacking])} are on {where}: add the tiles, or move the charts"
            )
        for page in np.unique(pages).tolist():
            label[mine[pages == page]] = len(separated)
            separated.append(picture.select_tile(page))
    return separated, label


def _get_labels(labels: ArrayLike | None, n_triangles: int, number: int, mapped: MappedTriangles) -> IntArray:
    """Return, for each triangle, the index of its image, or -1."""
    if labels is None:
        if number > 1:
            raise MeshError(
                f"there are {number} images and no labels: pass the index of the image of each face"
            )
        return np.zeros(n_triangles, dtype=np.int64)
    given = np.asarray(labels)
    face = np.arange(n_triangles) if mapped.split is None else mapped.split.face
    if given.shape != (int(face.max(initial=-1)) + 1,) or given.dtype.kind not in "iu":
        raise MeshError(f"labels have the shape {given.shape}: pass an integer for each face")
    bad = np.flatnonzero(given >= number)
    if len(bad):
        raise MeshError(
            f"faces {first_few(bad)} have labels beyond the {format_count(number, 'image')}: give more images"
        )
    return np.asarray(given[face], dtype=np.int64)


def _compute_frames(
    mapped: MappedTriangles, size: Size, uv: FloatArray, normals: ArrayLike
) -> tuple[TangentFrames, TangentFrames]:
    """Return the tangent frames of the old and the new map at the corners of triangles."""
    V, F = mapped.V, mapped.F
    if isinstance(normals, str) and normals == "vertices":
        directions = np.nan_to_num(igl.per_vertex_normals(V, F))[F]
    else:
        directions = np.asarray(normals, dtype=np.float64)
    if directions.shape != (*F.shape, 3):
        raise MeshError(f"normals have the shape {directions.shape}: pass {(*F.shape, 3)}, or 'vertices'")
    aspect = size[1] / size[0] if mapped.aspect is None else mapped.aspect
    flat = mapped.TC[mapped.rows] * [1, aspect]
    old, new = (compute_tangent_frames(V[F], directions, map_) for map_ in (uv, flat))
    return old, new
