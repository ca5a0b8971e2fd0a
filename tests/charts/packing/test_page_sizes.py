"""On pages that are not square, charts keep their shapes in texels, and all measures agree."""

from __future__ import annotations

import json
from pathlib import Path

import igl
import numpy as np
import pytest
from test_packing import star, stars

from igl_linabf import Atlas, ChartOptions, Cones, MeshError, Packing, check_uv, quality, unwrap
from igl_linabf.charts import pack_charts, pack_together
from igl_linabf.cli import main
from igl_linabf.io import read_file
from igl_linabf.textures import bake
from igl_linabf.uv import pack

Size = tuple[int, int]
SIZES: list[Size] = [(2048, 1024), (512, 2048)]


def body() -> tuple[np.ndarray, np.ndarray]:
    V, F = igl.loop(*igl.icosahedron(), 3)
    return V * [1, 2, 0.5], F


def in_texels(atlas: Atlas, size: Size) -> np.ndarray:
    return atlas.TC * np.array(size)


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("number", [1, 8, 150])
def test_charts_are_similar_in_texels_and_apart(size: Size, number: int) -> None:
    charts = stars(np.geomspace(1, 0.1, number) if number > 1 else [1.0], thin=1.5)
    placed = pack_charts(charts, Packing(resolution=size, padding=4))
    scales = []
    for (uv, F), new in zip(charts, placed, strict=True):
        before, after = (z[:, 0] + 1j * z[:, 1] for z in (uv, new.uv * size))
        ratio = np.diff(after) / np.diff(before)
        assert np.abs(ratio - ratio[0]).max() < 1e-6 * abs(ratio[0])
        scales.append(abs(ratio[0]))
        assert new.uv.min() >= 0
        assert new.uv.max() <= 1
        assert np.isclose(
            new.area * size[0] * size[1], scales[-1] ** 2 * np.abs(igl.doublearea(uv, F)).sum() / 2
        )
    assert np.ptp(scales) < 1e-6 * scales[0]
    flat = [(new.uv, F) for (_, F), new in zip(charts, placed, strict=True)]
    start = np.cumsum([0, *(len(uv) for uv, _ in flat)])
    TC = np.concatenate([uv for uv, _ in flat])
    FTC = np.concatenate([F + i for (_, F), i in zip(flat, start, strict=False)])
    V = np.insert(TC * size, 2, 0.0, axis=1)
    check = check_uv(V, FTC, TC, FTC, resolution=size, min_margin=4)
    assert check.good, check.troubles
    assert check.report.resolution == size
    assert np.isclose(check.stretch_l2, 1)
    assert np.isclose(check.report.texel_density.mean, 1)
    assert np.isclose(check.fill, sum(new.area for new in placed))


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_an_atlas_measures_what_lies_in_its_texels(size: Size) -> None:
    V, F = body()
    atlas = unwrap(V, F, charts=ChartOptions(max_stretch=1.2), packing=Packing(resolution=size, padding=6))
    measured = quality(V[atlas.origin], atlas.FTC, in_texels(atlas, size))
    for name in ("stretch_l2", "angle_distortion", "texel_spread"):
        assert np.isclose(getattr(atlas.quality, name), getattr(measured, name)), name
    assert np.allclose(atlas.flat * size[0], in_texels(atlas, size))
    check = check_uv(V, F, atlas.TC, atlas.FTC, resolution=size, min_margin=6)
    assert check.good, check.troubles
    assert np.isclose(check.fill, atlas.fill)
    assert np.isclose(check.report.texel_density.mean, atlas.report.scale * size[0], rtol=1e-3)
    square = unwrap(V, F, charts=ChartOptions(max_stretch=1.2), packing=Packing(resolution=1024, padding=6))
    assert atlas.fill > 0.7 * square.fill
    again = pack_together([atlas], Packing(resolution=512))[0]
    assert again.report.aspect == 1
    assert np.isclose(quality(V[atlas.origin], atlas.FTC, again.TC).stretch_l2, measured.stretch_l2)


def test_a_texel_density_and_pages_as_udim_tiles() -> None:
    V, F = body()
    size = (256, 128)
    atlas = unwrap(
        V, F, charts=ChartOptions(max_stretch=1.2), packing=Packing(resolution=size, texel_density=70)
    )
    assert np.isclose(atlas.report.scale * 256, 70)
    assert atlas.pages > 1
    tile = np.floor(atlas.TC[atlas.FTC].mean(axis=1))
    assert (tile[:, 0] + 10 * tile[:, 1] == atlas.page[atlas.chart]).all()
    image = bake(V, F, atlas, V, size)
    assert image.shape == (atlas.pages, 128, 256, 3)
    page = atlas.page[atlas.chart]
    x, y = ((atlas.TC[atlas.FTC].mean(axis=1) - tile) * size).astype(int).T
    assert np.linalg.norm(image[page, 127 - y, x] - V[F].mean(axis=1), axis=1).max() < 3 / 70
    with pytest.raises(MeshError, match="256 x 128 texels"):
        unwrap(
            V,
            F,
            charts=ChartOptions(max_stretch=1.2),
            packing=Packing(resolution=size, texel_density=70, pages=1),
        )


def test_a_long_chart_lies_along_the_longer_side() -> None:
    uv = np.array([[0.0, 0], [0, 4], [1, 4], [1, 0]])
    F = np.array([[0, 2, 1], [0, 3, 2]])
    for size in ((400, 100), (100, 400)):
        (new,) = pack_charts([(uv, F)], Packing(resolution=size, padding=0))
        assert new.area > 0.99
        assert (np.argmax(np.ptp(new.uv * size, axis=0)) == 0) == (size[0] > size[1])
    chart = star(np.random.default_rng(0), 1.0)
    (new,) = pack_charts([chart], Packing(resolution=(300, 100), padding=0), rotate=False)
    assert new.ratio.imag == 0


def test_packing_again_keeps_the_shapes_in_texels() -> None:
    V, F = body()
    size = (1024, 512)
    atlas = unwrap(V, F, charts=ChartOptions(max_stretch=1.2), packing=Packing(resolution=size))
    packed = pack(V, F, atlas.TC, atlas.FTC, Packing(resolution=size, padding=10), scale="even")
    check = check_uv(V, F, packed.TC, packed.FTC, resolution=size, min_margin=10)
    assert check.good, check.troubles
    assert np.isclose(check.report.quality.angle_distortion, atlas.quality.angle_distortion, rtol=1e-6)
    assert np.isclose(check.report.texel_density.mean, packed.scale * 1024)


def test_the_commands_take_width_and_height(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from PIL import Image

    V, F = body()
    source, out = tmp_path / "in.obj", tmp_path / "out.obj"
    source.write_text(
        "\n".join(
            [
                *(f"v {x} {y} {z}" for x, y, z in V.tolist()),
                *(f"f {a} {b} {c}" for a, b, c in (F + 1).tolist()),
            ]
        )
    )
    words = ["--resolution", "512x256", "--padding", "4", "--quiet"]
    assert main(["unwrap", str(source), "-o", str(out), "--bake", "position", *words]) == 0
    with Image.open(tmp_path / "out.png") as image:
        assert image.size == (512, 256)
    assert main(["check", str(out), "--resolution", "512x256", "--min-margin", "4", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["check"]
    assert said["resolution"] == [512, 256]
    assert main(["check", str(out), "--resolution", "512", "--max-stretch", str(said["stretch_l2"])]) == 1
    assert main(["pack", str(out), "-o", str(tmp_path / "packed.obj"), *words]) == 0
    mesh = read_file(tmp_path / "packed.obj")
    assert check_uv(mesh.V, mesh.F, mesh.TC, mesh.FTC, resolution=(512, 256), min_margin=4).good
    for wrong in ("512x", "0", "1x2x3", "ax2"):
        with pytest.raises(SystemExit):
            main(["check", str(out), "--resolution", wrong])


def test_invalid_page_sizes_are_refused() -> None:
    for wrong in ((512, 0), (1, 2, 3), (1.5, 2), "512", -1):
        with pytest.raises(ValueError, match="width and height"):
            Packing(resolution=wrong)
    with pytest.raises(ValueError, match="padding"):
        Packing(resolution=(1024, 16), padding=8)
    V, F = igl.icosahedron()
    with pytest.raises(ValueError, match="square page"):
        unwrap(V, F, cones=Cones("auto", angles="quarter", period=0.1), packing=Packing(resolution=(64, 32)))


def test_pages_at_a_texel_density_cannot_be_made_fuller() -> None:
    with pytest.raises(ValueError, match="cut_below is for pages whose scale is free"):
        Packing(resolution=64, texel_density=8, cut_below=0.5)
