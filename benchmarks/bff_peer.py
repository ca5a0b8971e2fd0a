"""Build boundary first flattening (BFF; Sawhney and Crane 2017) from its sources, and time it."""

from __future__ import annotations

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from compiling import compile_program

from igl_linabf.io import write_obj

TIMED = r"""
#include "bff/mesh/MeshIO.h"
#include "bff/project/Bff.h"
#include <chrono>
#include <ctime>
#include <iostream>
static bool cpu;
static double now() {
    using namespace std::chrono;
    if (cpu) return double(std::clock()) / CLOCKS_PER_SEC;
    return duration<double>(steady_clock::now().time_since_epoch()).count();
}
int main(int n, char **argv) {
    cpu = n > 2;
    for (int run = 0; run < 4; run++) { // the first run is a warm-up
        bff::PolygonSoup soup;
        bff::Model model;
        std::vector<std::pair<int, int>> uncuttable;
        std::string error;
        if (!bff::MeshIO::readOBJ(argv[1], soup, uncuttable, error)) return 1;
        double start = now();
        if (!bff::MeshIO::buildModel(uncuttable, soup, model, error)) return 1;
        double built = now();
        bff::BFF flattener(model[0]);
        bff::DenseMatrix u(flattener.data->bN);
        flattener.flatten(u, true);
        double end = now();
        if (run > 0) std::cout << end - built << " " << end - start << "\n";
    }
}
"""
BUILD = """
cmake_minimum_required(VERSION 3.10)
project(timed_bff)
set(BFF_BUILD_CLI OFF CACHE BOOL "")
set(BFF_BUILD_GUI OFF CACHE BOOL "")
add_subdirectory("{sources}" bff)
add_executable(timed main.cpp)
target_link_libraries(timed bff)
"""


@dataclass(frozen=True)
class Bff:
    """The compiled program that times BFF."""

    program: Path

    @classmethod
    def build(cls, sources: Path) -> Bff:
        """Compile the library and the timing program in a temporary folder."""
        folder = Path(tempfile.mkdtemp(prefix="bff-"))
        return cls(compile_program(folder, BUILD, sources, "timed", TIMED))

    def measure_seconds(self, V: np.ndarray, F: np.ndarray, cpu: bool) -> tuple[float, float]:
        """Return the seconds of BFF alone, and including the construction of its mesh (medians of three)."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "mesh.obj")
            write_obj(path, V, F, V[:, :2])
            command = [self.program, path, *["cpu"] * cpu]
            done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True, timeout=300)
        rows = [[float(word) for word in row.split()] for row in done.stdout.splitlines()]
        core, whole = np.median(rows, axis=0)
        return float(core), float(whole)
