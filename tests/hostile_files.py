"""Damaged files, and checks of the command on them."""

from __future__ import annotations

import contextlib
import io
import os
import re
import struct
import tempfile
from pathlib import Path

import numpy as np
from hostile_meshes import Disk, find_flipped_exactly, has_place, require

from igl_linabf.cli import main
from igl_linabf.io import read_mesh, read_texture


def good_files(rng: np.random.Generator) -> dict[str, list[bytes]]:
    """Return small random meshes in all variants of the formats OBJ, OFF, PLY and STL."""
    return list_files(*Disk(n=int(rng.integers(4, 40)), seed=int(rng.integers(2**32))).build())


def list_files(V: np.ndarray, F: np.ndarray) -> dict[str, list[bytes]]:
    """Return a mesh in all variants of the formats OBJ, OFF, PLY and STL, by suffix."""
    V32, n, m = V.astype("<f4"), len(V), len(F)

    def lines(rows: np.ndarray, form: str) -> bytes:
        return "".join(form.format(*row) + "\n" for row in rows.tolist()).encode()

    v, f = lines(V, "{} {} {}"), lines(F, "3 {} {} {}")

    def ply(form: str, kind: str) -> bytes:
        xyz = "".join(f"property {kind} {axis}\n" for axis in "xyz")
        head = f"ply\nformat {form} 1.0\ncomment made\nelement vertex {n}\n{xyz}element face {m}\n"
        return f"{head}property list uchar int vertex_indices\nend_header\n".encode()

    record = np.zeros(m, [("n", "u1"), ("f", "<i4", 3)])
    record["n"], record["f"] = 3, F
    big = record.astype([("n", "u1"), ("f", ">i4", 3)])
    triangles = np.zeros(m, [("normal", "<f4", 3), ("v", "<f4", (3, 3)), ("more", "<u2")])
    triangles["v"] = V32[F]
    loops = "".join(
        "facet normal 0 0 1\n outer loop\n"
        + "".join(f"  vertex {x!r} {y!r} {z!r}\n" for x, y, z in corner)
        + " endloop\nendfacet\n"
        for corner in V[F].tolist()
    )
    return {
        "obj": [
            lines(V, "v {} {} {}") + lines(F + 1, "f {} {} {}"),
            b"# made\nmtllib a.mtl\no a\n"
            + lines(V, "v {} {} {}")
            + lines(V[:, :2], "vt {} {}")
            + b"vn 0 0 1\ns 1\n"
            + lines(np.repeat(F + 1, 2, axis=1), "f {}/{}/1 {}/{}/1 {}/{}/1"),
            lines(V, "v {} {} {} 0.5 0.5 0.5") + lines(F - n, "f {} {} {}"),
        ],
        "off": [
            f"OFF\n{n} {m} 0\n".encode() + v + f,
            f"COFF\n# made\n{n} {m} 0\n".encode() + lines(V, "{} {} {} 255 0 0 255") + f,
        ],
        "ply": [
            ply("ascii", "double") + v + f,
            ply("binary_little_endian", "float") + V32.tobytes() + record.tobytes(),
            ply("binary_big_endian", "double") + V.astype(">f8").tobytes() + big.tobytes(),
        ],
        "stl": [
            b"made".ljust(80) + struct.pack("<I", m) + triangles.tobytes(),
            f"solid made\n{loops}endsolid made\n".encode(),
        ],
    }


GARBAGE = (
    *(
        b"-1",
        b"0",
        b"1",
        b"3",
        b"255",
        b"-2147483648",
        b"2147483647",
        b"4294967295",
        b"100000",
        b"1000000000",
    ),
    *(
        b"9" * 20,
        b"9" * 5000,
        b"1e400",
        b"1e200",
        b"-1e-320",
        b"nan",
        b"inf",
        b"0x10",
        b"1_0",
        b"1.5",
        b"+-1",
    ),
    *(
        b"abc",
        b"\0",
        b"\n",
        b"\r",
        b" ",
        b"/",
        b"//",
        b"#",
        b"\\",
        b"\xff\xfe",
        b"f",
        b"v",
        b"f 1 2 3\n",
        b"\n\n",
    ),
)


def mutate(data: bytes, rng: np.random.Generator) -> bytes:
    """Flip bits, remove bytes, truncate, replace numbers, duplicate and move lines, at random."""
    for _ in range(int(rng.choice([1, 1, 2, 3, 8]))):
        data = _mutate_once(data, rng)
    return data


def _mutate_once(data: bytes, rng: np.random.Generator) -> bytes:
    i, j = sorted(int(k) for k in rng.integers(len(data) + 1, size=2))
    j = min(j, i + 1 + int(rng.integers(9)))
    garbage = GARBAGE[rng.integers(len(GARBAGE))]
    words, lines = data.split(b" "), data.split(b"\n")
    w, a, b = int(rng.integers(len(words))), int(rng.integers(len(lines))), int(rng.integers(len(lines)))
    kind = int(rng.integers(8))
    if kind == 0:
        flipped = int.from_bytes(data[i : i + 1], "big") ^ 1 << int(rng.integers(8))
        return data[:i] + bytes([flipped]) + data[i + 1 :]
    if kind == 1:
        return data[:i]
    if kind == 2:
        return data[:i] + data[j:]
    if kind == 3:
        return data[:i] + garbage + data[i:]
    if kind == 4:
        return b" ".join((*words[:w], garbage, *words[w + 1 :]))
    if kind == 5:
        return b"\n".join((*lines[:a], lines[b], *lines[a:]))
    if kind == 6:
        return b"\n".join((*lines[:a], *lines[a + 1 :]))
    return data[:i] + data[i:j] * int(rng.integers(2, 2000)) + data[j:]


def hostile_file(seed: int) -> tuple[str, bytes]:
    """Return suffix and bytes of a damaged file, sometimes of noise or of a file with a wrong suffix."""
    rng = np.random.default_rng(seed)
    suffix = str(rng.choice(["obj", "off", "ply", "stl"]))
    kind = rng.random()
    if kind < 0.05:
        return suffix, rng.bytes(int(rng.integers(400)))
    files = good_files(rng)
    forms = files[suffix]
    data = forms[rng.integers(len(forms))]
    if kind < 0.1:
        head = data[: int(rng.integers(200))]
        return suffix, head + rng.bytes(int(rng.integers(400)))
    if kind < 0.13:
        return suffix, files[str(rng.choice(["obj", "off", "ply", "stl"]))][0]
    return suffix, mutate(data, rng)


def check_file(seed: int, command: str) -> str:
    """Check the exit code, the message, and the output of the command on a hostile file."""
    suffix, data = hostile_file(seed)
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / f"hostile.{suffix}"
        mesh.write_bytes(data)
        out = Path(folder) / ("out.obj" if command == "flatten" else f"out.{['obj', 'ply', 'glb'][seed % 3]}")
        arguments = [command, str(mesh)]
        arguments += (
            ["--repeat", "1", "--methods", "lscm,linabf"] if command == "compare" else ["-o", str(out)]
        )
        stdout, stderr = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(stdout), contextlib.redirect_stderr(stderr):
            code = main(arguments)
        files_left = sorted(set(os.listdir(folder)) - {mesh.name})
        wrote = command != "compare" and code != 2
        require(code in (0, 1, 2), f"exit code {code}")
        require(
            files_left == ([out.name] if wrote else []),
            f"exit code {code}, files in the folder: {files_left}",
        )
        lines = stderr.getvalue().splitlines()
        require(all(line.startswith("igl-linabf: ") for line in lines), f"stderr is {lines}")
        errors = [line for line in lines if ": warning: " not in line]
        require(all(has_place(line) for line in lines), f"no place in {lines}")
        if code == 2:
            require(len(errors) == 1 and not stdout.getvalue(), f"exit code 2, and {lines}")
            return "refused"
        require(
            bool(stdout.getvalue()) and not re.search(r"\bnan\b", stdout.getvalue()),
            f"NaN in {stdout.getvalue()}",
        )
        if wrote and out.suffix == ".obj":
            TC, FTC = read_texture(out)
            require(bool(read_mesh(out)[1].shape == FTC.shape), "the file has other faces")
            require(bool(np.isfinite(TC[FTC]).all()), "the file has NaN")
            if code == 0 and command == "flatten":
                flipped = find_flipped_exactly(TC, FTC)
                require(
                    not len(flipped), f"exit code 0, and in the file faces {flipped.tolist()} are flipped"
                )
        return {0: "good", 1: "written, not good"}[code]
