"""Files written with `--bake` show colours of vertices and materials, and normals of the object."""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path

import igl
import numpy as np
import pytest
from gltf_files import write_glb
from PIL import Image

from igl_linabf.cli import main
from igl_linabf.io import MeshFile, read_file
from igl_linabf.io.materials import encode_srgb

RESOLUTION = 256


def scene(path: Path, node: dict, materials: list[dict], colours: np.ndarray | None) -> None:
    """Write an icosahedron; its first ten faces have the first material, all other faces the last one."""
    V, F = igl.icosahedron()
    parts = [V.astype("<f4").tobytes(), F[:10].astype("<u4").tobytes(), F[10:].astype("<u4").tobytes()]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3"}]
    accessors += [{"bufferView": i, "componentType": 5125, "count": 30, "type": "SCALAR"} for i in (1, 2)]
    attributes = {"POSITION": 0}
    if colours is not None:
        parts.append(colours.astype("<f4").tobytes())
        accessors.append({"bufferView": 3, "componentType": 5126, "count": 12, "type": "VEC4"})
        attributes["COLOR_0"] = 3
    primitives = [
        {"attributes": attributes, "indices": i + 1, "material": min(i, len(materials) - 1)} for i in (0, 1)
    ]
    text = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0, **node}],
        "meshes": [{"primitives": primitives}],
        "materials": materials,
        "accessors": accessors,
    }
    write_glb(path, text, parts)


def bake_file(tmp_path: Path, kind: str, suffix: str = ".glb") -> tuple[MeshFile, np.ndarray]:
    """Unwrap and bake a file; return the written mesh, and its image (0 to 1, lower row first)."""
    out = tmp_path / f"out{suffix}"
    words = ["--bake", kind, "--resolution", str(RESOLUTION), "--quiet"]
    assert main(["unwrap", str(tmp_path / "in.glb"), "-o", str(out), *words]) == 0
    mesh = read_file(out)
    if suffix == ".glb":
        source = mesh.extras.source.gltf
        (image,) = source.text["images"]
        data = source.read_view(image["bufferView"])
    else:
        data = out.with_suffix(".png").read_bytes()
    return mesh, np.asarray(Image.open(BytesIO(data)), dtype=float)[::-1] / 255


def sample_at_centres(mesh: MeshFile, image: np.ndarray) -> np.ndarray:
    """Return the colour of an image at the centre of each face."""
    x, y = (mesh.TC[mesh.FTC].mean(axis=1) * RESOLUTION).astype(int).T
    return image[y, x]


def shade(factor: list[float], alpha: str | None = None) -> dict:
    made = {"name": str(factor), "pbrMetallicRoughness": {"baseColorFactor": factor}}
    return made if alpha is None else {**made, "alphaMode": alpha}


def test_baked_colours_are_vertex_colours_times_material_colours(tmp_path: Path) -> None:
    given = np.random.default_rng(0).random((12, 4))
    factors = [[0.5, 1.0, 0.25, 0.5], [1.0, 0.2, 1.0, 1.0]]
    scene(tmp_path / "in.glb", {}, [shade(factors[0], "BLEND"), shade(factors[1], "BLEND")], given)
    mesh, image = bake_file(tmp_path, "colors")
    _, F = igl.icosahedron()
    factor = np.repeat(factors, 10, axis=0)[:, None]
    wanted = given[F] * factor
    wanted[..., :3] = encode_srgb(wanted[..., :3])
    assert image.shape == (RESOLUTION, RESOLUTION, 4)
    assert np.abs(sample_at_centres(mesh, image) - wanted.mean(axis=1)).max() < 0.02
    text = mesh.extras.source.gltf.text
    for material in text["materials"]:  # the image includes the colour factors of the materials
        assert "baseColorFactor" not in material["pbrMetallicRoughness"]
        assert material["alphaMode"] == "BLEND"
    assert mesh.colours is None


@pytest.mark.parametrize("suffix", [".glb", ".obj"])
def test_colours_of_materials_alone_are_baked(suffix: str, tmp_path: Path) -> None:
    scene(tmp_path / "in.glb", {}, [shade([1, 0, 0, 1]), shade([0, 0, 1, 1])], None)
    mesh, image = bake_file(tmp_path, "colors", suffix)
    wanted = np.repeat([[1, 0, 0], [0, 0, 1]], 10, axis=0)
    assert np.abs(sample_at_centres(mesh, image) - wanted).max() < 0.01


@pytest.mark.parametrize(
    "node",
    [
        {"rotation": [0, 0, 0.5**0.5, 0.5**0.5]},
        {"scale": [1, 2, 5]},
        {"scale": [-1, 1, 1]},
        {"matrix": [0, 2, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 5, 6, 7, 1]},
    ],
    ids=json.dumps,
)
def test_baked_normals_do_not_depend_on_the_transform_of_the_node(node: dict, tmp_path: Path) -> None:
    scene(tmp_path / "in.glb", node, [{}], None)
    mesh, image = bake_file(tmp_path, "normals")
    V, F = igl.icosahedron()
    outwards = V[F].mean(axis=1)
    outwards /= np.linalg.norm(outwards, axis=1)[:, None]
    found = 2 * sample_at_centres(mesh, image) - 1
    limit = 0.99 if "scale" not in node else 0.9  # vertex normals deviate slightly after a stretch
    assert ((found * outwards).sum(axis=1) > limit).all()
    # a format without nodes stores the transformed object
    other, image = bake_file(tmp_path, "normals", ".obj")
    found = 2 * sample_at_centres(other, image) - 1
    a, b, c = other.V[other.triangles].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    assert ((found * normal).sum(axis=1) > 0.6).all()
