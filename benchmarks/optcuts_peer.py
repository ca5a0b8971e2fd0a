"""Build OptCuts (Li et al. 2018) from its sources, and make atlases with it."""

from __future__ import annotations

import resource
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import igl
import numpy as np
from compiling import compile_program
from peers import TexelAtlas

from igl_linabf.io import read_file, read_mesh

BOUND = 4.1  # bound on the mean symmetric Dirichlet energy, the default of OptCuts
SIZES = (1250, 6300)  # smallest and largest number of triangles of the meshes
# OptCuts uses the copy of libigl in its sources, and would download TBB
BUILD = """
cmake_minimum_required(VERSION 3.10)
project(optcuts C CXX)
find_package(TBB REQUIRED)
set(LIBIGL_INCLUDE_DIR "{sources}/ext/libigl/include" CACHE PATH "")
add_subdirectory("{sources}" optcuts)
"""


@dataclass(frozen=True)
class OptCuts:
    """The compiled program."""

    program: Path

    @classmethod
    def build(cls, sources: Path, folder: Path) -> OptCuts:
        """Compile the program in a folder."""
        return cls(compile_program(folder, BUILD, sources, "OptCuts_bin"))

    def unwrap(self, V: np.ndarray, F: np.ndarray) -> TexelAtlas:
        """Return the atlas, at the scale of the mesh, and the CPU time."""
        with tempfile.TemporaryDirectory() as folder:
            igl.write_triangle_mesh(f"{folder}/mesh.obj", V, F)
            # no window, mesh, initial weight of seams, name of the run, method, bound, no overlaps, first cut
            options = ["100", "mesh.obj", "0.999", "1", "0", str(BOUND), "1", "0"]
            start = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                [self.program, *options], check=True, capture_output=True, cwd=folder, timeout=1000
            )
            end = resource.getrusage(resource.RUSAGE_CHILDREN)
            (path,) = Path(folder).glob("output/*/finalResult_mesh.obj")
            made = read_file(path)
        origin = np.empty(len(made.TC), dtype=np.int64)
        origin[made.FTC] = F
        seconds = end.ru_utime - start.ru_utime + end.ru_stime - start.ru_stime
        return TexelAtlas(origin, made.FTC, made.TC, float(np.ptp(made.TC, axis=0).prod()), seconds)


def load_meshes(sources: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield the meshes of OptCuts' own benchmark without texture coordinates, with sizes in `SIZES`."""
    for path in sorted((sources / "input" / "benchmark").glob("*.obj")):
        V, F = read_mesh(path)
        if SIZES[0] <= len(F) <= SIZES[1] and read_file(path).TC is None:
            yield path.stem, V, F
