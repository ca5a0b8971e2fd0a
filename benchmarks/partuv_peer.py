"""Make atlases with PartUV (Wang et al. 2025), in a Python of its own, without a GPU.

PartUV divides a mesh along a tree of parts, which a neural network predicts on a GPU. Here the tree is a
hierarchical clustering of the normals of neighbouring faces (Ward's method). The wheel's compiled module is
imported without its package, which would import PyTorch.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
from peers import TexelAtlas, run_script
from scipy.sparse import coo_matrix

from igl_linabf.io import read_mesh

MAX_TRIANGLES = 45_000  # triangles of the largest mesh
# the defaults of PartUV, with one thread and without a GPU
OPTIONS = """
pipeline: {threshold: 1.25, parallelDepth: 10, component_maxDepth: 10, checkSelfIntersection: false,
  checkNon2Manifold: true, num_omp_threads: 1, num_cuda_streams: 1}
unwrap: {method: abf, abf_iters: 5, agg_parts: 10, pamo: false}
num_cuda_streams: 1
verbose: false
save_stuff: false
"""
SCRIPT = f"""
import numpy as np, sys, time
from importlib.util import find_spec
sys.path.insert(0, find_spec("partuv").submodule_search_locations[0])
import _core
data = np.load(sys.argv[1])
V, F = data["V"], data["F"].astype(np.int32)
tree = {{len(F) + i: dict(left=int(a), right=int(b)) for i, (a, b) in enumerate(data["tree"])}}
with open("options.yaml", "w") as file:
    file.write({OPTIONS!r})
start = time.process_time()
made = _core.pipeline_numpy(V=V, F=F, tree_dict=tree, configPath="options.yaml", threshold=1.25)[0]
seconds = time.process_time() - start
whole = made.to_components()
vertex = {{tuple(point): i for i, point in enumerate(V)}}
corner = np.array([vertex[tuple(point)] for point in whole.V])[whole.F.ravel()]
np.savez(sys.argv[2], uv=whole.UV[whole.F.ravel()], corner=corner, seconds=seconds)
"""


def make_tree(V: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Return the two children of each node; the leaves are the faces, and the last node is the root."""
    from sklearn.cluster import AgglomerativeClustering  # here, because generated.py measures its memory

    neighbour = igl.triangle_triangle_adjacency(F)[0]
    face, side = np.nonzero(neighbour >= 0)
    pairs = coo_matrix((np.ones(len(face)), (face, neighbour[face, side])), shape=(len(F), len(F)))
    normals = igl.per_face_normals(V, F, np.zeros(3))
    return AgglomerativeClustering(n_clusters=1, connectivity=pairs).fit(normals).children_


def unwrap_with_partuv(python: str, V: np.ndarray, F: np.ndarray) -> TexelAtlas:
    """Return the charts that PartUV makes, before packing, and the CPU time without building the tree."""
    return run_script(python, SCRIPT, V, F, timeout=1000, tree=make_tree(V, F))


def load_meshes(sources: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield the meshes of PartUV's demo, with coincident vertices merged, up to `MAX_TRIANGLES`."""
    for path in sorted((sources / "demo" / "meshes").glob("*.obj")):
        V, F = read_mesh(path)
        if len(F) <= MAX_TRIANGLES:
            points, merged = np.unique(V, axis=0, return_inverse=True)
            yield path.stem.split("_")[0][:8], points, merged[F]
