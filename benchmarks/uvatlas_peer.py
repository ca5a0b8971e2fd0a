"""Make atlases with UVAtlas (Microsoft), by Open3D in a Python of its own."""

from __future__ import annotations

import numpy as np
from peers import PADDING, RESOLUTION, TexelAtlas, run_script

SCRIPT = f"""
import numpy as np, open3d, sys, time
data = np.load(sys.argv[1])
F = data["F"]
mesh = open3d.t.geometry.TriangleMesh(open3d.core.Tensor(data["V"].astype("float32")), open3d.core.Tensor(F))
start = time.process_time()
mesh.compute_uvatlas(size={RESOLUTION}, gutter={PADDING}.0, parallel_partitions=1, nthreads=1)
seconds = time.process_time() - start
uv = mesh.triangle.texture_uvs.numpy().reshape(-1, 2)
np.savez(sys.argv[2], uv=uv, corner=F.ravel(), seconds=seconds)
"""


def unwrap_with_uvatlas(python: str, V: np.ndarray, F: np.ndarray) -> TexelAtlas:
    """Return the atlas that UVAtlas makes with its default options, and the CPU time."""
    return run_script(python, SCRIPT, V, F, timeout=1000)
