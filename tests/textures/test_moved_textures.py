"""After `--bake texture`, a file shows the same images at the same points of its surface."""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from gltf_files import write_glb
from PIL import Image
from scipy.ndimage import map_coordinates

from igl_linabf import MeshError, MeshWarning, Packing, unwrap
from igl_linabf.cli import main
from igl_linabf.io import MeshFile, image_maps, read_file, write_file
from igl_linabf.textures import Picture, bake, bake_texture
from igl_linabf.textures.texels import find_covered_texels

# the sides of a box that share no vertices, as in glTF files with sharp edges
SIDES = np.array([[0, 1, 1], [0, -1, 1], [1, 1, 0], [1, -1, 0], [2, 1, 2], [2, -1, 2]])
BAKE_TEXTURE = ["--bake", "texture", "--resolution", "128", "--quiet"]
KINDS = ("baseColorTexture", "metallicRoughnessTexture", "occlusionTexture", "emissiveTexture")


def box() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return positions, normals, texture coordinates (v downwards) and triangles of a box of 1 x 2 x 3."""
    V, N, uv, F = [], [], [], []
    for i, (axis, sign, _) in enumerate(SIDES.tolist()):
        others = [k for k in range(3) if k != axis]
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        points = np.zeros((4, 3))
        points[:, axis], points[:, others] = sign, square
        F += [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        if normal[axis] * sign < 0:
            F[-2:] = [row[::-1] for row in F[-2:]]
        V += (points * [0.5, 1, 1.5]).tolist()
        N += [np.eye(3)[axis] * sign] * 4
        column, row = i % 3, i // 3
        uv += (((square + 1) * 0.45 + 0.05 + [column, row]) / [3, 2]).tolist()  # the map mirrors some sides
    return np.array(V), np.array(N), np.array(uv), np.array(F)


def closed_box() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return V, F, TC and FTC of the box of 1 x 2 x 3 with shared vertices."""
    V, _, uv, FTC = box()
    corners, same = np.unique(V, axis=0, return_inverse=True)
    return corners, same.ravel()[FTC], uv * [1, -1] + [0, 1], FTC


def picture(seed: int, size: tuple[int, int], channels: int = 3) -> np.ndarray:
    """Return a smooth periodic image with values from 0 to 1."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: size[1], : size[0]] * 2 * np.pi / np.array([[[size[1]]], [[size[0]]]])
    waves = [np.sin(a * x + b * y + c) for a, b, c in rng.integers(1, 3, (channels, 3))]
    return np.stack(waves, axis=2) / 2 + 0.5


def png(image: np.ndarray) -> bytes:
    data = BytesIO()
    Image.fromarray(np.rint(image * 255).astype(np.uint8)).save(data, "PNG")
    return data.getvalue()


def scene(
    path: Path,
    materials: list[dict],
    images: list[bytes],
    samplers: list[dict] | None = None,
    node: dict | None = None,
) -> None:
    """Write a box as GLB; the second half of its faces has the last material."""
    V, N, uv, F = box()
    parts = [V.astype("<f4"), N.astype("<f4"), uv.astype("<f4"), F[:6].astype("<u4"), F[6:].astype("<u4")]
    blocks = [part.tobytes() for part in parts] + [image + b"\0" * (-len(image) % 4) for image in images]
    accessors = [
        {"bufferView": i, "componentType": 5126, "count": len(V), "type": kind}
        for i, kind in enumerate(("VEC3", "VEC3", "VEC2"))
    ]
    accessors += [{"bufferView": i, "componentType": 5125, "count": 18, "type": "SCALAR"} for i in (3, 4)]
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    last = len(materials) - 1
    text = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0, **(node or {})}],
        "meshes": [
            {
                "primitives": [
                    {"attributes": attributes, "indices": 3, "material": 0},
                    {"attributes": attributes, "indices": 4, "material": last},
                ]
            }
        ],
        "materials": materials,
        "samplers": samplers or [{}],
        "textures": [{"source": i, "sampler": min(i, len(samplers or [0]) - 1)} for i in range(len(images))],
        "images": [{"bufferView": 5 + i, "mimeType": "image/png"} for i in range(len(images))],
        "accessors": accessors,
    }
    write_glb(path, text, blocks)


def sample_image(mesh: MeshFile, kind: str, face: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Interpolate the image of a material at points of faces; NaN without an image."""
    source = mesh.extras.source.gltf
    uv = np.einsum("pk,pkd->pd", weights, mesh.TC[mesh.FTC[face]])
    found = np.full((len(face), 4), np.nan)
    for i, material in enumerate(source.text["materials"]):
        info = {**material, **material.get("pbrMetallicRoughness", {})}.get(kind)
        mine = np.flatnonzero(mesh.extras.materials[1][face] == i)
        if info is None or not len(mine):
            continue
        texture = source.text["textures"][info["index"]]
        data = source.read_view(source.text["images"][texture["source"]]["bufferView"])
        pixels = np.asarray(Image.open(BytesIO(data)), dtype=float) / 255
        move = info.get("extensions", {}).get("KHR_texture_transform", {})
        angle, scale = move.get("rotation", 0), np.array(move.get("scale", (1, 1)))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        st = (uv[mine] * [1, -1] + [0, 1]) * scale @ turn.T + move.get("offset", (0, 0))
        sampler = source.text["samplers"][texture["sampler"]]
        modes = {10497: "grid-wrap", 33071: "nearest", 33648: "reflect"}
        assert sampler.get("wrapS", 10497) == sampler.get("wrapT", 10497)
        at = st[:, ::-1].T * np.array(pixels.shape[:2])[:, None] - 0.5
        for k in range(pixels.shape[2]):
            mode = modes[sampler.get("wrapS", 10497)]
            found[mine, k] = map_coordinates(pixels[..., k], at, order=1, mode=mode)
    return found


def bake_and_sample(path: Path, out: Path, *words: str) -> tuple[MeshFile, MeshFile, np.ndarray, np.ndarray]:
    """Return a file before and after baking, and random points of its faces."""
    assert main(["unwrap", str(path), "-o", str(out), "--bake", "texture", "--quiet", *words]) == 0
    rng = np.random.default_rng(0)
    before, after = read_file(path), read_file(out)
    place = {tuple(np.round(p, 5)): i for i, p in enumerate(after.V[after.triangles].mean(axis=1))}
    rows = np.array([place[tuple(np.round(p, 5))] for p in before.V[before.triangles].mean(axis=1)])
    face, weights = rng.integers(len(rows), size=4000), rng.dirichlet(np.ones(3), size=4000)
    corners = before.V[before.triangles[face]], after.V[after.triangles[rows[face]]]
    order = np.linalg.norm(corners[1][:, :, None] - corners[0][:, None], axis=3).argmin(axis=2)
    moved = np.take_along_axis(weights, order, axis=1)
    return before, after, np.column_stack((face, rows[face])), np.stack((weights, moved))


MOVE = {"offset": [0.3, 0.1], "rotation": 0.7, "scale": [1.5, 2.5]}


@pytest.mark.parametrize(
    "words", [["--resolution", "512x1024"], ["--resolution", "256", "--pages", "3"]], ids=str
)
def test_all_images_look_the_same_after_the_transfer(words: list[str], tmp_path: Path) -> None:
    infos = [
        {"index": i, "extensions": {"KHR_texture_transform": MOVE}} if i % 2 else {"index": i}
        for i in range(4)
    ]
    first = {
        "name": "all",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 1, 1, 1],
            "baseColorTexture": infos[0],
            "metallicRoughnessTexture": infos[1],
        },
        "occlusionTexture": {**infos[2], "strength": 0.5},
        "emissiveTexture": infos[3],
    }
    second = {"name": "one", "pbrMetallicRoughness": {"baseColorTexture": {"index": 4}}}
    sizes = [(128, 128), (64, 128), (32, 32), (100, 60), (256, 128)]
    images = [png(picture(i, size, 4 if i == 0 else 3)) for i, size in enumerate(sizes)]
    samplers = [{}, {"wrapS": 33648, "wrapT": 33648}, {}, {"wrapS": 10497, "wrapT": 10497}, {}]
    scene(tmp_path / "in.glb", [first, second], images, samplers)
    before, after, face, weights = bake_and_sample(tmp_path / "in.glb", tmp_path / "out.glb", *words)
    for kind in KINDS:
        old, new = (sample_image(m, kind, face[:, i], weights[i]) for i, m in enumerate((before, after)))
        known = np.isfinite(old[:, 0])
        assert (np.isfinite(new[:, 0]) == known).all()
        off = np.abs(new - old)[known][:, :3]
        assert np.median(off) < 0.01
        assert np.quantile(off, 0.97) < 0.05, kind  # a new chart may cross a seam of the old map
    text = after.extras.source.gltf.text
    tiles = len(np.unique(np.floor(after.TC[after.FTC].mean(axis=1)), axis=0))
    assert len(text["images"]) == len(KINDS) * tiles  # the old images are removed
    written = (tmp_path / "out.glb").read_bytes()
    assert not any(image in written for image in images)
    for material in text["materials"]:
        assert "KHR_texture_transform" not in json.dumps(material)
        if material["name"].startswith("all"):
            assert material["pbrMetallicRoughness"]["baseColorFactor"] == [0.5, 1, 1, 1]
            assert material["occlusionTexture"]["strength"] == 0.5


def sample_normals(mesh: MeshFile, face: np.ndarray, weights: np.ndarray, scale: list[float]) -> np.ndarray:
    """Return the object-space normals of a normal map on planar faces."""
    local = 2 * sample_image(mesh, "normalTexture", face, weights)[:, :3] - 1
    a, b, c = (mesh.V / scale)[mesh.triangles[face]].transpose(1, 0, 2)
    p, q, r = mesh.TC[mesh.FTC[face]].transpose(1, 0, 2)
    d = np.stack((q - p, r - p), axis=1)
    along = np.einsum("pij,pjd->pid", np.linalg.inv(d), np.stack((b - a, c - a), axis=1))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    tangent = along[:, 0] / np.linalg.norm(along[:, 0], axis=1)[:, None]
    mirrored = np.sign(np.einsum("pd,pd->p", np.cross(along[:, 0], along[:, 1]), normal))
    bitangent = mirrored[:, None] * np.cross(normal, tangent)
    made = local[:, :1] * tangent + local[:, 1:2] * bitangent + local[:, 2:] * normal
    return made / np.linalg.norm(made, axis=1)[:, None]


@pytest.mark.parametrize("scale", [[1, 1, 1], [1, 2, 4], [-1, 1, 1], [2, -1, 3]], ids=str)
def test_normal_maps_keep_their_directions_in_space(scale: list[float], tmp_path: Path) -> None:
    slopes = picture(5, (128, 128), 2) - 0.5
    normals = np.dstack((slopes, np.sqrt(1 - (slopes**2).sum(axis=2)))) / 2 + 0.5
    material = {"name": "bumpy", "normalTexture": {"index": 0, "scale": 1.0}}
    scene(tmp_path / "in.glb", [material], [png(normals)], node={"scale": scale})
    before, after, face, weights = bake_and_sample(
        tmp_path / "in.glb", tmp_path / "out.glb", "--resolution", "512"
    )
    old, new = (sample_normals(m, face[:, i], weights[i], scale) for i, m in enumerate((before, after)))
    angle = np.degrees(np.arccos(np.clip((old * new).sum(axis=1), -1, 1)))
    assert np.median(angle) < 1.5
    assert np.quantile(angle, 0.99) < 5
    # the normals of the map deviate from the surface; otherwise, the test would be trivial
    plain = np.abs(sample_image(before, "normalTexture", face[:, 0], weights[0])[:, :2] - 0.5)
    assert plain.max() > 0.2


def test_options_of_an_mtl_file_are_applied_and_its_other_lines_are_kept(tmp_path: Path) -> None:
    (tmp_path / "tex").mkdir()
    (tmp_path / "tex" / "wood a.png").write_bytes(png(picture(1, (64, 32))))
    (tmp_path / "tex" / "spec.png").write_bytes(png(picture(2, (32, 32))[..., 0]))
    (tmp_path / "tex" / "m.mtl").write_text(
        "newmtl wood\nKd 0.5 1 1\nNs 3\nillum 2\n"
        "map_Kd -s 2 3 1 -o 0.25 wood a.png\nmap_Ks -clamp on spec.png\n"
    )
    V, _, uv, F = box()
    lines = [f"v {x} {y} {z}" for x, y, z in V.tolist()] + [f"vt {u} {1 - v}" for u, v in uv.tolist()]
    lines += ["mtllib tex/m.mtl", "usemtl wood"]
    lines += ["f " + " ".join(f"{i}/{i}" for i in row) for row in (F + 1).tolist()]
    (tmp_path / "in.obj").write_text("\n".join(lines))
    words = ["--bake", "texture", "--resolution", "256", "--quiet"]
    assert main(["unwrap", str(tmp_path / "in.obj"), "-o", str(tmp_path / "out.obj"), *words]) == 0
    library = (tmp_path / "out.mtl").read_text()
    assert "map_Kd out.png" in library
    assert "map_Ks -clamp on out_map_Ks.png" in library
    assert "Kd 0.5 1 1" in library
    assert "illum 2" in library
    after = read_file(tmp_path / "out.obj")
    image = np.asarray(Image.open(tmp_path / "out.png"), dtype=float) / 255
    old_image = np.asarray(Image.open(tmp_path / "tex" / "wood a.png"), dtype=float) / 255
    before = read_file(tmp_path / "in.obj")
    old = before.TC[before.FTC].mean(axis=1) * [2, 3] + [0.25, 0]
    new = after.TC[after.FTC].mean(axis=1)

    def looked_up(pixels: np.ndarray, at: np.ndarray) -> np.ndarray:
        place = np.array([1 - at[:, 1], at[:, 0]]) * np.array(pixels.shape[:2])[:, None] - 0.5
        return np.stack(
            [map_coordinates(pixels[..., k], place, order=1, mode="grid-wrap") for k in range(3)], axis=1
        )

    assert np.abs(looked_up(image, new) - looked_up(old_image, old)).max() < 0.04
    code = main(["unwrap", str(tmp_path / "in.obj"), "-o", str(tmp_path / "out.obj"), *words])
    assert code == 2  # the image exists already


def test_missing_textures_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene(tmp_path / "in.glb", [{"name": "plain"}], [])
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", str(tmp_path / "o.glb"), "--bake", "texture"]) == 2
    assert "no images" in capsys.readouterr().err
    V, F, TC, FTC = closed_box()
    atlas = unwrap(V, F, packing=Packing(resolution=64))
    with pytest.raises(MeshError, match="no face has an image"):
        bake_texture(V, F, atlas, TC, FTC, [None], 64)
    with pytest.raises(MeshError, match="no labels"):
        bake_texture(V, F, atlas, TC, FTC, [np.ones((2, 2)), np.ones((2, 2))], 64)
    with pytest.raises(MeshError, match="old texture coordinates outside"):
        bake_texture(V, F, atlas, TC, np.where(FTC == 3, len(TC), FTC), np.ones((2, 2)), 64)
    with pytest.raises(MeshError, match="faces 0 have labels beyond the 2 images"):
        labels = np.where(np.arange(len(F)) == 0, 2, 1)
        bake_texture(V, F, atlas, TC, FTC, [np.ones((2, 2)), np.ones((2, 2))], 64, labels=labels)


def test_images_with_different_channels_are_combined() -> None:
    """A grey image is converted to RGB, and an image without alpha is opaque."""
    V, F, TC, FTC = closed_box()
    atlas = unwrap(V, F, packing=Packing(resolution=64))
    labels = np.arange(len(F)) // 4
    shades = np.array([[0.3, 0.3, 0.3, 1], [0.1, 0.2, 0.3, 1], [0.5, 0.6, 0.7, 0.8]])
    images = [np.full((2, 2, 1), 0.3), np.full((2, 2, 3), shades[1, :3]), np.full((2, 2, 4), shades[2])]
    translucent_grey = bake_texture(V, F, atlas, TC, FTC, np.full((2, 2, 2), [0.3, 0.7]), 64)
    assert translucent_grey.shape == (64, 64, 2)
    np.testing.assert_allclose(translucent_grey[translucent_grey[..., 1] > 0].mean(axis=0), [0.3, 0.7])
    pair = [np.full((2, 2, 2), [0.3, 0.7]), np.full((2, 2, 3), 0.5), np.full((2, 2, 1), 0.1)]
    mixed = bake_texture(V, F, atlas, TC, FTC, pair, 64, labels=labels)
    assert set(mixed[..., 3].ravel().round(9)) - {0.0} == {0.7, 1.0}
    moved = bake_texture(V, F, atlas, TC, FTC, images, 64, labels=labels)
    wanted = bake(V, F, atlas, np.repeat(shades[labels][:, None], 3, axis=1), 64)
    assert np.abs(moved - wanted).max() < 1e-9


def test_labels_select_images_and_pictures_clamp() -> None:
    V, F, TC, FTC = closed_box()
    atlas = unwrap(V, F, packing=Packing(resolution=128))
    labels = np.arange(len(F)) // 2
    images = [np.full((2, 2, 3), i / 6) for i in range(5)]
    moved = bake_texture(V, F, atlas, TC, FTC, [*images, None], 128, labels=labels)
    wanted = bake(V, F, atlas, np.repeat(labels / 6, 3).reshape(-1, 3, 1), 128)
    there = bake(V, F, atlas, np.repeat(labels < 5, 3).reshape(-1, 3, 1).astype(float), 128, padding=0) == 1
    assert np.abs(moved - wanted)[there[..., 0]].max() < 1e-9
    ramp = np.linspace(0, 1, 8).reshape(1, 8, 1)
    clamped = Picture(ramp, ("clamp", "clamp"))
    assert clamped.interpolate(np.array([[-3.0, 0.5], [3.0, 0.5]])).ravel().tolist() == [0, 1]


def test_filters_and_wrap_modes_of_images_are_kept(tmp_path: Path) -> None:
    """The colours of pixel art are not mixed, and each material has the samplers of its own images."""
    pixel_art = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 0]]]) / 255
    nearest = {"magFilter": 9728, "minFilter": 9728, "wrapS": 33071, "wrapT": 33648}
    materials = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in range(2)]
    scene(
        tmp_path / "in.glb", materials, [png(pixel_art), png(1 - pixel_art)], [nearest, {"magFilter": 9729}]
    )
    kept = tmp_path / "out.glb"
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", str(kept), *BAKE_TEXTURE]) == 0
    mesh = read_file(kept)
    text = mesh.extras.source.gltf.text
    textures = [
        text["textures"][m["pbrMetallicRoughness"]["baseColorTexture"]["index"]] for m in text["materials"]
    ]
    assert [text["samplers"][texture["sampler"]] for texture in textures] == [nearest, {"magFilter": 9729}]
    assert textures[0]["source"] == textures[1]["source"]
    image = image_maps(mesh)["baseColorTexture"][0]
    uv = mesh.TC[mesh.FTC[mesh.extras.materials[1] == 0]]
    row, column = np.divmod(find_covered_texels(uv * 128 - 0.5, (128, 128)).index, 128)
    colours = np.unique(image.pixels[127 - row, column], axis=0)
    assert image.nearest and len(colours) > 1
    assert {tuple(colour) for colour in colours} <= {tuple(colour) for colour in pixel_art.reshape(-1, 3)}


@pytest.mark.parametrize("mode", ["LA", "PA", "L"])
def test_the_transparency_of_grey_and_palette_images_is_kept(mode: str, tmp_path: Path) -> None:
    data = BytesIO()
    colour = Image.new("LA", (4, 4), (128, 64))
    if mode == "LA":
        colour.save(data, "PNG")
    elif mode == "PA":
        colour.convert("RGBA").quantize(4).save(data, "PNG")
    else:
        Image.new("L", (4, 4), 128).save(data, "PNG", transparency=128)
    scene(
        tmp_path / "in.glb", [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], [data.getvalue()]
    )
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", str(tmp_path / "out.glb"), *BAKE_TEXTURE]) == 0
    pixels = image_maps(read_file(tmp_path / "out.glb"))["baseColorTexture"][0].pixels
    shown = pixels[pixels[..., 0] > 0]
    np.testing.assert_allclose(shown[:, -1] * 255, 0 if mode == "L" else 64, atol=1)
    np.testing.assert_allclose(shown[:, 0] * 255, 128, atol=2)


def test_options_of_images_without_a_counterpart_are_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nearest = {"magFilter": 9728, "wrapS": 33071, "wrapT": 33071}
    materials = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    scene(tmp_path / "in.glb", materials, [png(picture(0, (8, 8)))], [nearest])
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", str(tmp_path / "out.obj"), *BAKE_TEXTURE]) == 0
    assert "OBJ does not keep the filter NEAREST of its images" in capsys.readouterr().err
    assert "map_Kd -clamp on out.png" in (tmp_path / "out.mtl").read_text()


@pytest.mark.parametrize("suffix", [".glb", ".obj"])
@pytest.mark.parametrize("kind", ["normals", "position"])
def test_each_page_is_an_image(kind: str, suffix: str, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    V, _, _, F = box()
    (tmp_path / "in.off").write_text(
        "\n".join(["OFF", f"{len(V)} {len(F)} 0", *(" ".join(map(str, p)) for p in V.tolist())])
        + "\n"
        + "\n".join(f"3 {a} {b} {c}" for a, b, c in F.tolist())
    )
    out = tmp_path / f"out{suffix}"
    words = ["--bake", kind, "--resolution", "128x64", "--texel-density", "18", "--quiet"]
    assert main(["unwrap", str(tmp_path / "in.off"), "-o", str(out), "--weld", "0", *words]) == 0
    tiles = np.unique(np.floor(read_file(out).TC[read_file(out).FTC].mean(axis=1)), axis=0)
    assert len(tiles) > 1
    loaded = trimesh.load(out, process=False)
    low, size = V.min(axis=0), np.ptp(V, axis=0).max()
    seen = 0
    for mesh in loaded.geometry.values():
        material = mesh.visual.material
        image = material.baseColorTexture if suffix == ".glb" else material.image
        assert image.size == (128, 64)
        pixels = np.asarray(image.convert("RGB"), dtype=float) / 255
        uv, middle = mesh.visual.uv[mesh.faces].mean(axis=1), mesh.triangles_center
        assert len(np.unique(np.floor(uv), axis=0)) == 1
        x, y = (np.mod(uv, 1) * [128, 64]).astype(int).T
        wanted = mesh.face_normals / 2 + 0.5 if kind == "normals" else (middle - low) / size
        limit = 0.45 if kind == "normals" else 0.05  # vertex normals deviate from face normals
        assert np.abs(pixels[::-1][y, x] - wanted).max() < limit
        seen += len(mesh.faces)
    assert seen == len(F)


def test_textures_are_baked_on_standard_output(
    tmp_path: Path, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    scene(tmp_path / "in.glb", [{"name": "m", "normalTexture": {"index": 0}}], [png(picture(0, (16, 16)))])
    words = ["--bake", "texture", "--resolution", "64", "--quiet"]
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", "-", "--format", "glb", *words]) == 0
    (tmp_path / "piped.glb").write_bytes(capsysbinary.readouterr().out)
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", str(tmp_path / "out.glb"), *words]) == 0
    assert (tmp_path / "piped.glb").read_bytes() == (tmp_path / "out.glb").read_bytes()


def test_images_that_the_format_cannot_store_are_reported(tmp_path: Path) -> None:
    info = {"index": 0}
    shading = {"baseColorTexture": info, "metallicRoughnessTexture": info}
    scene(tmp_path / "in.glb", [{"name": "m", "pbrMetallicRoughness": shading}], [png(picture(0, (16, 16)))])
    with pytest.warns(MeshWarning, match="metallicRoughnessTexture"):
        from igl_linabf.io import image_maps, write_file

        mesh = read_file(tmp_path / "in.glb")
        atlas = unwrap(mesh.V, mesh.F, packing=Packing(resolution=64))
        maps = image_maps(mesh)
        moved = {
            kind: bake_texture(
                mesh.V, mesh.F, atlas, mesh.TC, mesh.FTC, images, 64, labels=mesh.extras.materials[1]
            )
            for kind, images in maps.items()
        }
        write_file(tmp_path / "out.obj", mesh, atlas.TC, atlas.FTC, moved)
    assert (tmp_path / "out.png").exists()


TILE_COLOURS = {1001: (255, 0, 0), 1002: (0, 255, 0), 1011: (0, 0, 255)}


def write_tiles(folder: Path, name: str, suffix: str) -> Path:
    """Write a body of three squares; each square fills one UDIM tile."""
    for tile, colour in TILE_COLOURS.items():
        Image.new("RGB", (8, 8), colour).save(folder / f"skin.{tile}.png")
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    corners = np.concatenate([square + np.array([k % 10, k // 10]) for k in (0, 1, 10)])
    V = np.column_stack((corners * 1.5, np.zeros(len(corners))))
    (folder / "skin.mtl").write_text(f"newmtl skin\nmap_Kd {name}\n")
    lines = ["mtllib skin.mtl", *(f"v {x} {y} {z}" for x, y, z in V), *(f"vt {u} {v}" for u, v in corners)]
    faces = (np.arange(12).reshape(3, 4) + 1).tolist()
    lines += ["usemtl skin", *(f"f {' '.join(f'{i}/{i}' for i in face)}" for face in faces)]
    (folder / "in.obj").write_text("\n".join(lines))
    if suffix == ".obj":
        return folder / "in.obj"
    mesh = read_file(folder / "in.obj")
    write_file(folder / "in.gltf", mesh, mesh.TC, mesh.FTC, {"baseColorTexture": np.ones((1, 1, 3))})
    text = json.loads((folder / "in.gltf").read_text())
    text["images"] = [{"uri": name.replace("<", "%3C").replace(">", "%3E")}]
    (folder / "in.gltf").write_text(json.dumps(text))
    return folder / "in.gltf"


@pytest.mark.parametrize("name", ["skin.<UDIM>.png", "skin.1001.png"])
@pytest.mark.parametrize("suffix", [".obj", ".gltf"])
def test_each_chart_keeps_its_udim_tile(name: str, suffix: str, tmp_path: Path) -> None:
    source = write_tiles(tmp_path, name, suffix)
    assert main(["unwrap", str(source), "-o", str(tmp_path / "out.glb"), *BAKE_TEXTURE]) == 0
    mesh = read_file(tmp_path / "out.glb")
    (new,) = image_maps(mesh)["baseColorTexture"]
    rng = np.random.default_rng(0)
    for face, colour in enumerate(TILE_COLOURS.values()):
        weights = rng.dirichlet(np.ones(len(mesh.FTC[face])), 200)
        assert np.allclose(new.interpolate(weights @ mesh.TC[mesh.FTC[face]]) * 255, colour, atol=1)


def test_a_missing_udim_tile_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = write_tiles(tmp_path, "skin.<UDIM>.png", ".obj")
    (tmp_path / "skin.1011.png").unlink()
    assert main(["unwrap", str(source), "-o", str(tmp_path / "out.glb"), *BAKE_TEXTURE]) == 2
    assert "triangles 4, 5 are on the UDIM tiles 1011, which their image lacks" in capsys.readouterr().err


def test_a_single_file_named_1001_repeats(tmp_path: Path) -> None:
    source = write_tiles(tmp_path, "skin.1001.png", ".obj")
    for tile in (1002, 1011):
        (tmp_path / f"skin.{tile}.png").unlink()
    (picture,) = image_maps(read_file(source))["baseColorTexture"]
    assert not picture.tiles
    assert np.allclose(picture.interpolate(np.array([[1.5, 0.5]])) * 255, TILE_COLOURS[1001])
