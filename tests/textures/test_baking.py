"""A lookup in a baked texture returns the value at the point of the surface."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import igl
import numpy as np
import pytest
from carried import ball
from conftest import load
from scipy.ndimage import map_coordinates

from igl_linabf import Atlas, MeshError, Packing, unwrap
from igl_linabf.charts import pack_together
from igl_linabf.cli import main, unwrapping
from igl_linabf.errors import MemoryLimitError
from igl_linabf.io import read_mesh, write_image, write_mesh, write_textured
from igl_linabf.linalg import memory
from igl_linabf.surface import complex_positions, signed_double_areas
from igl_linabf.textures import bake, bake_texture, baking

Surface = tuple[np.ndarray, np.ndarray, Atlas]
RESOLUTION = 256


def make_several_bodies() -> Surface:
    """Return a ball beside 40 small boxes; many boxes are smaller than a texel."""
    V, F = ball()
    cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    square = np.array([[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]])
    square = np.vstack((square, [[2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]))
    parts, corners, n = [V], [F], len(V)
    for i, size in enumerate(np.geomspace(0.5, 0.002, 40)):
        parts.append(cube * size + [2 + i, 0, 0])
        corners.append(square + n)
        n += 8
    V, F = np.vstack(parts), np.vstack(corners)
    return V, F, unwrap(V, F, packing=Packing(resolution=RESOLUTION))


def cortex() -> Surface:
    V, F = load("pial")
    return V, F, unwrap(V, F, packing=Packing(resolution=RESOLUTION))


@pytest.fixture(scope="module", params=[make_several_bodies, cortex], ids=["several", "cortex"])
def surface(request: pytest.FixtureRequest) -> Surface:
    made: Surface = request.param()
    return made


def look_up(image: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Interpolate an image bilinearly at texture coordinates."""
    n = len(image)
    at = np.array([(1 - uv[:, 1]) * n - 0.5, uv[:, 0] * n - 0.5])
    channels = np.moveaxis(np.atleast_3d(image), -1, 0)
    return np.stack([map_coordinates(part, at, order=1, mode="nearest") for part in channels], axis=1)


def random_points(V: np.ndarray, F: np.ndarray, atlas: Atlas, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return random points with the same expected number in each face, and their texture coordinates."""
    rng = np.random.default_rng(0)
    face, weights = rng.integers(len(F), size=count), rng.dirichlet(np.full(3, 0.5), size=count)
    return (
        np.einsum("pk,pkd->pd", weights, V[F[face]]),
        np.einsum("pk,pkd->pd", weights, atlas.TC[atlas.FTC[face]]),
    )


def test_a_lookup_of_baked_positions_returns_the_point(surface: Surface) -> None:
    V, F, atlas = surface
    points, uv = random_points(V, F, atlas, 20_000)
    away = np.linalg.norm(look_up(bake(V, F, atlas, V, RESOLUTION), uv) - points, axis=1)
    corner = V[F]
    edges = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max()
    scale = np.sqrt(np.abs(signed_double_areas(complex_positions(atlas.TC), atlas.FTC.T)).sum() / 2)
    size = np.sqrt(igl.doublearea(V, F).sum() / 2)
    texel = size / scale / RESOLUTION  # mean size of a texel on the surface
    assert np.median(away) < 0.5 * texel
    assert away.max() < max(6 * texel, edges / 20)


def test_lookups_do_not_mix_charts_or_background(surface: Surface) -> None:
    V, F, atlas = surface
    _, uv = random_points(V, F, atlas, 20_000)
    assert np.ptp(look_up(bake(V, F, atlas, np.ones(len(V)), RESOLUTION, background=9), uv)) < 1e-12
    colour = np.repeat(atlas.chart[:, None, None], 3, axis=1).astype(float)
    rng = np.random.default_rng(0)
    face = rng.integers(len(F), size=20_000)
    weights = rng.dirichlet(np.ones(3), size=20_000)
    uv = np.einsum("pk,pkd->pd", weights, atlas.TC[atlas.FTC[face]])
    shown = look_up(bake(V, F, atlas, colour, RESOLUTION, background=-5), uv)[:, 0]
    np.testing.assert_allclose(shown, atlas.chart[face], atol=1e-9)


def test_every_texel_whose_centre_lies_in_a_triangle_is_set(surface: Surface) -> None:
    V, F, atlas = surface
    image = bake(V, F, atlas, V, RESOLUTION, padding=0, background=np.nan)
    centre = (np.arange(RESOLUTION) + 0.5) / RESOLUTION
    u, v = np.meshgrid(centre, 1 - centre)
    flat = np.column_stack((u.ravel(), v.ravel()))
    TC = np.column_stack((atlas.TC, np.zeros(len(atlas.TC))))
    distance, _, _ = igl.point_mesh_squared_distance(
        np.column_stack((flat, np.zeros(len(flat)))), TC, atlas.FTC
    )
    inside, known = distance < 1e-20, np.isfinite(image[..., 0]).ravel()
    assert known[inside].all()
    assert inside.sum() > 0.4 * inside.size
    assert not known[distance > (1.5 / RESOLUTION) ** 2].any()  # texels far away from all charts are not set


def test_a_function_is_evaluated_at_points_of_the_surface() -> None:
    V, F, atlas = cortex()
    pattern = bake(V, F, atlas, lambda p: np.sin(p[:, 0] / 5), RESOLUTION)
    assert pattern.shape == (RESOLUTION, RESOLUTION)
    positions = bake(V, F, atlas, V, RESOLUTION)
    np.testing.assert_allclose(pattern[pattern != 0], np.sin(positions[..., 0] / 5)[pattern != 0], atol=1e-12)
    one = bake(V, F, atlas, V[:, :1], RESOLUTION)
    assert one.shape == (RESOLUTION, RESOLUTION, 1)
    np.testing.assert_array_equal(one, positions[..., :1])


def test_pages_are_images_and_polygons_keep_their_corners() -> None:
    V, F = load("bumps")
    atlas = unwrap(V, F)
    assert len(atlas.charts) == 1
    shared = pack_together([atlas] * 3, Packing(resolution=128, pages=3))
    points, uv = random_points(V, F, shared[2], 1000)
    assert (uv[:, 0] > 2).all()
    images = bake(V, F, shared[2], V, 128)
    assert images.shape == (3, 128, 128, 3)
    assert not images[:2].any()
    near = np.linalg.norm(look_up(images[2], uv - [2, 0]) - points, axis=1)
    assert np.median(near) < 0.01 * np.ptp(V)
    V = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    F = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    atlas = unwrap(V, F, packing=Packing(resolution=64))
    image = bake(V, F, atlas, V, 64)
    np.testing.assert_allclose(look_up(image, atlas.TC), V[atlas.origin], atol=0.1)


def test_an_image_does_not_depend_on_the_strips_in_which_it_is_painted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    V, F = igl.upsample(*igl.icosahedron(), 2)
    atlas = unwrap(V, F, packing=Packing(resolution=(96, 128)))
    whole = bake(V, F, atlas, V, (96, 128), padding=5)
    for rows in (1, 7, 100):
        monkeypatch.setattr(baking, "STRIP_TEXELS", 96 * rows)
        assert np.array_equal(bake(V, F, atlas, V, (96, 128), padding=5), whole)


def test_painting_takes_little_more_memory_than_the_image() -> None:
    V, F = igl.icosahedron()
    atlas = unwrap(V, F, packing=Packing(resolution=64))
    tracemalloc.start()
    image = bake(V, F, atlas, V, (2048, 4096))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2 * image.nbytes


def test_an_image_that_does_not_fit_is_refused_before_the_work(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    V, F = igl.icosahedron()
    atlas = unwrap(V, F)
    monkeypatch.setattr(memory, "available_memory", lambda: 4 << 30)
    says = "16384 x 16384 texels takes about 6.5 GiB, but only .* are free: use a smaller resolution"
    with pytest.raises(MemoryLimitError, match=says):
        bake(V, F, atlas, V, 16384)
    igl.write_triangle_mesh(str(tmp_path / "a.obj"), V, F)
    monkeypatch.setattr(unwrapping, "unwrap", None)  # must not be called
    words = ["--bake", "normals", "--resolution", "16384"]
    assert main(["unwrap", str(tmp_path / "a.obj"), "-o", str(tmp_path / "a.glb"), *words]) == 2
    assert "use a smaller resolution" in capsys.readouterr().err


def test_arrays_that_do_not_match_are_refused() -> None:
    V, F, atlas = cortex()
    for values, why in (
        (np.ones(3), "shape"),
        (np.ones((7, 3, 1)), "7 x 3 corners"),
        (lambda points: points[:2], "returns"),
    ):
        with pytest.raises(MeshError, match=why):
            bake(V, F, atlas, values, 64)
    with pytest.raises(MeshError, match="more vertices"):
        bake(V[:10], F, atlas, V, 64)
    with pytest.raises(ValueError, match="resolution"):
        bake(V, F, atlas, V, 0)


def test_a_glb_file_shows_its_texture(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    V, F, atlas = cortex()
    image = bake(V, F, atlas, (V - V.min(axis=0)) / np.ptp(V), RESOLUTION)
    write_textured(tmp_path / "cortex.glb", V, F, atlas.TC, atlas.FTC, image)
    (mesh,) = trimesh.load(tmp_path / "cortex.glb").geometry.values()
    colours = mesh.visual.to_color().vertex_colors[:, :3] / 255
    wanted = (mesh.vertices - V.min(axis=0)) / np.ptp(V)
    assert np.median(np.abs(colours - wanted)) < 0.01
    write_image(tmp_path / "cortex.png", image)
    from PIL import Image

    with Image.open(tmp_path / "cortex.png") as picture:
        np.testing.assert_allclose(np.asarray(picture) / 255, np.clip(image, 0, 1), atol=0.002)
    with pytest.raises(ValueError, match=r"\.glb"):
        write_textured(tmp_path / "cortex.ply", V, F, atlas.TC, atlas.FTC, image)
    with pytest.raises(MeshError, match="channels"):
        write_image(tmp_path / "five.png", np.zeros((4, 4, 5)))


@pytest.mark.parametrize("kind", ["colors", "normals", "position"])
def test_the_command_writes_baked_textures(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pygltflib = pytest.importorskip("pygltflib")
    V, F = load("pial")
    colours = (V - V.min(axis=0)) / np.ptp(V, axis=0)
    lines = [f"v {' '.join(map(str, (*v, *c)))}" for v, c in zip(V.tolist(), colours.tolist(), strict=True)]
    lines += [f"f {a} {b} {c}" for a, b, c in (F + 1).tolist()]
    source, target = tmp_path / "in.obj", tmp_path / "out.glb"
    source.write_text("\n".join(lines))
    assert main(["unwrap", str(source), "-o", str(target), "--bake", kind, "--resolution", "256"]) == 0
    glb = pygltflib.GLTF2().load_binary(str(target))
    assert glb.materials[0].pbrMetallicRoughness.baseColorTexture.index == 0
    assert glb.meshes[0].primitives[0].attributes.COLOR_0 is None
    from io import BytesIO

    from PIL import Image

    view = glb.bufferViews[glb.images[0].bufferView]
    data = glb.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
    image = np.asarray(Image.open(BytesIO(data))) / 255

    def rows(accessor: int) -> np.ndarray:
        at = glb.accessors[accessor]
        first = glb.bufferViews[at.bufferView].byteOffset
        width = {"VEC2": 2, "VEC3": 3}[at.type]
        return np.frombuffer(glb.binary_blob(), "<f4", at.count * width, first).reshape(-1, width)

    attributes = glb.meshes[0].primitives[0].attributes
    shown = look_up(image, rows(attributes.TEXCOORD_0) * [1, -1] + [0, 1])
    points = rows(attributes.POSITION).astype(float)
    vertex = np.linalg.norm(V[:, None] - points, axis=2).argmin(axis=0)
    normals = igl.per_vertex_normals(V, F)
    wanted = {
        "colors": colours,
        "normals": normals / 2 + 0.5,
        "position": (V - V.min(axis=0)) / np.ptp(V, axis=0).max(),
    }[kind]
    assert np.median(np.abs(shown - wanted[vertex])) < 0.02


def test_the_command_refuses_what_it_cannot_bake(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    V, F, atlas = cortex()
    source = tmp_path / "in.obj"
    write_mesh(source, V, F, atlas.TC, atlas.FTC)
    assert len(read_mesh(source)[0]) == len(V)
    for target, kind, why in (("out.glb", "colors", "no colours"), ("out.ply", "normals", ".glb")):
        assert main(["unwrap", str(source), "-o", str(tmp_path / target), "--bake", kind]) == 2
        assert why in capsys.readouterr().err
        assert not (tmp_path / target).exists()


def test_a_texel_beside_a_chart_has_the_value_of_the_nearest_point_of_its_outline() -> None:
    V = np.array([[0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0.0]])
    F = np.array([[0, 1, 2], [0, 2, 3]])
    atlas = unwrap(V, F, packing=Packing(resolution=128, padding=10))
    image = bake(V, F, atlas, atlas.TC, 128, padding=0, background=np.nan)
    row, column = np.nonzero(np.isfinite(image[..., 0]))
    centre = np.column_stack((column + 0.5, 128 - row - 0.5)) / 128
    # the chart is an axis-aligned rectangle
    nearest = np.clip(centre, atlas.TC.min(axis=0), atlas.TC.max(axis=0))
    assert (nearest != centre).any(axis=1).sum() > 100
    np.testing.assert_allclose(image[row, column], nearest, atol=1e-9)


def test_an_atlas_its_coordinates_and_its_map_give_the_same_image() -> None:
    """Quadrangles and triangles, several pages, and a map with a row for each vertex."""
    grid = np.array([[x, y, np.sin(x)] for y in range(6) for x in range(8)], dtype=float)
    quads = np.array([[0, 1, 9, 8]]) + [[8 * y + x] for y in range(5) for x in range(7)]
    for F in (quads, np.vstack((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))):
        atlas = unwrap(grid, F, np.zeros((0, 2), dtype=int), packing=Packing(resolution=64))
        image = bake(grid, F, atlas, grid, 64)
        uv = np.empty((len(grid), 2))
        uv[atlas.origin] = atlas.TC
        assert (bake(grid, F, (atlas.TC, atlas.FTC), grid, 64) == image).all()
        assert (bake(grid, F, uv, grid, 64) == image).all()
        assert (bake(grid, F, uv.tolist(), grid.tolist(), 64) == image).all()
        old = image / 20 + 0.3
        moved = bake_texture(grid, F, atlas, atlas.TC, atlas.FTC, old, 64)
        assert (bake_texture(grid, F, uv, atlas.TC, atlas.FTC, old, 64) == moved).all()
    V, F = ball()
    atlas = unwrap(V, F, packing=Packing(resolution=64, texel_density=40))
    assert atlas.pages > 1
    image = bake(V, F, atlas, V, 64)
    assert (bake(V, F, (atlas.TC, atlas.FTC), V, 64) == image).all()
    bare = atlas.FTC.copy()
    bare[atlas.chart > 0] = -1
    assert (bake(V, F, (atlas.TC, bare), V, 64)[0] == image[0]).sum() > 64


def test_coordinates_that_no_page_holds_are_refused() -> None:
    V, F = ball()
    atlas = unwrap(V, F)
    for TC in (atlas.TC - 0.5, atlas.TC + 0.5, atlas.TC + 10, 2 * atlas.TC):
        with pytest.raises(MeshError, match=r"outside the unit square.*unit_square"):
            bake(V, F, (TC, atlas.FTC), V, 64)
    with pytest.raises(MeshError, match="NaN or infinite"):
        bake(V, F, (np.where(atlas.TC.max(axis=0) == atlas.TC, np.nan, atlas.TC), atlas.FTC), V, 64)
    with pytest.raises(MeshError, match="a row for each vertex"):
        bake(V, F, atlas.TC[:5], V, 64)
