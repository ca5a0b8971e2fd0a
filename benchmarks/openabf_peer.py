"""Compile OpenABF (ABF++ and LSCM) from its sources, and compare its time with `abf`.

    git clone https://github.com/educelab/OpenABF FOLDER/OpenABF
    IGL_LINABF_PEERS=FOLDER python benchmarks/openabf_peer.py

The surfaces are from OpenABF's own benchmark (scrolls.py). Eigen has to be installed (on Debian
libeigen3-dev). Times are CPU seconds. Prints Markdown.
"""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import process_time

import numpy as np
from compiling import compile_program
from peers import find_peers_folder
from scrolls import cap, wavy

from igl_linabf import abf, quality

SIZES = (50_000, 100_000)  # triangles of the surfaces

TIMED = r"""
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include "OpenABF/OpenABF.hpp"
using ABF = OpenABF::ABFPlusPlus<double>;
using LSCM = OpenABF::AngleBasedLSCM<double, ABF::Mesh>;
int main(int, char **argv) {
    std::ifstream file(argv[1]);
    std::size_t points, faces, a, b, c;
    double x, y, z;
    file >> points >> faces;
    auto mesh = ABF::Mesh::New();
    while (points-- && file >> x >> y >> z) mesh->insert_vertex(x, y, z);
    while (faces-- && file >> a >> b >> c) mesh->insert_face(a, b, c);
    const std::clock_t start = std::clock();
    ABF::Compute(mesh);
    LSCM::Compute(mesh);
    std::cout << std::setprecision(17) << double(std::clock() - start) / CLOCKS_PER_SEC << " 0\n";
    for (const auto &v : mesh->vertices()) std::cout << v->pos[0] << " " << v->pos[1] << "\n";
}
"""
BUILD = """
cmake_minimum_required(VERSION 3.15)
project(timed_openabf CXX)
add_subdirectory("{sources}" openabf)
add_executable(timed main.cpp)
target_link_libraries(timed OpenABF::OpenABF)
"""


@dataclass(frozen=True)
class OpenAbf:
    """The compiled program that times ABF++ followed by LSCM, both with default options."""

    program: Path

    @classmethod
    def build(cls, sources: Path, folder: Path) -> OpenAbf:
        """Compile the timing program in a folder."""
        return cls(compile_program(folder, BUILD, sources, "timed", TIMED))

    def flatten(self, V: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the map and the CPU time, without the construction of the mesh."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "mesh.txt"
            with path.open("w") as file:
                np.savetxt(file, [(len(V), len(F))], fmt="%d")
                np.savetxt(file, V, fmt="%.17g")
                np.savetxt(file, F, fmt="%d")
            done = subprocess.run(
                [self.program, path], check=True, capture_output=True, encoding="utf-8", timeout=600
            )
        output = np.fromstring(done.stdout, sep=" ").reshape(-1, 2)
        return output[1:], float(output[0, 0])


def main() -> None:
    folder = find_peers_folder()
    if folder is None:
        return
    program = OpenAbf.build(folder / "OpenABF", folder / "build" / "openabf")
    print("| surface | triangles | by | F/3nt | flips | CPU s |\n|---|---|---|---|---|---|")
    abf(*wavy(1000))  # warm-up
    for make, triangles in product((wavy, cap), SIZES):
        V, F = make(triangles)
        start = process_time()
        uv = abf(V, F)
        seconds = process_time() - start
        for name, (map_, time) in {"OpenABF": program.flatten(V, F), "abf": (uv, seconds)}.items():
            q = quality(V, F, map_)
            figures = f"{q.angle_distortion:.5g} | {q.flips} | {time:.2f}"
            print(f"| {make.__name__} | {len(F):,} | {name} | {figures} |", flush=True)


if __name__ == "__main__":
    main()
