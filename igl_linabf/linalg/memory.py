"""Estimate the memory that a computation needs, and query the free memory."""

import math
import sys
from pathlib import Path

import psutil

from ..errors import MemoryLimitError, format_count

BYTES_PER_FACE = 1000  # peak memory per face of a map without factors, see benchmarks/memory.py
BYTES_PER_HOLE_AND_ROW = 60  # peak memory of the dense Schur columns of an uncut hole, per vertex constraint
FILL = 4.5  # entries of the factor of a planar n by n Laplacian / (n log2(n)), see benchmarks/memory.py
MIN_QUERIED_BYTES = 2**25  # query the free memory only for larger allocations


def available_memory() -> int | None:
    """Return the number of bytes that this process can still allocate, or None if it is unknown."""
    limits = [psutil.virtual_memory().available, _available_in_cgroup()]
    if sys.platform != "win32":
        import resource

        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        if soft != resource.RLIM_INFINITY:
            limits.append(soft - psutil.Process().memory_info().vms)
    known = [limit for limit in limits if limit is not None]
    return max(min(known), 0) if known else None


def factor_bytes(n: int, block: int = 1) -> int:
    """Estimate the bytes of a factor of an n by n matrix over a planar graph.

    The entries of the matrix are `block` by `block` blocks. The factor has O(n log n) blocks (Lipton, Rose,
    Tarjan 1979).
    """
    return int(FILL * n * math.log2(max(n, 2)) * 8 * block**2)


def has_free_memory(wanted: int) -> bool:
    """Return True if `wanted` bytes are free."""
    free = None if wanted <= MIN_QUERIED_BYTES else available_memory()
    return free is None or wanted <= free


def check_memory(faces: int, factor: int, holes: int = 0, rows: int = 0) -> None:
    """Raise a `MemoryLimitError` if a map of `faces` faces and a factor of `factor` bytes do not fit.

    Each of the `holes` has dense Schur columns with an entry for each of the `rows`, the vertex constraints.
    """
    wanted = BYTES_PER_FACE * faces + factor + BYTES_PER_HOLE_AND_ROW * holes * rows
    if not has_free_memory(wanted):
        what = format_count(faces, "face") + f" with {format_count(holes, 'hole')}" * bool(holes)
        fill = "fill small holes, " if holes else ""
        raise MemoryLimitError(
            f"{what} take about {format_gigabytes(wanted)}, but only "
            f"{format_gigabytes(available_memory() or 0)} are free: {fill}decimate the mesh (igl.qslim), cut "
            "it into parts (igl_linabf.cut), or use a machine with more memory"
        )


def format_gigabytes(n: int) -> str:
    """Format a number of bytes, for example as "1.5 GiB"."""
    return f"{n / 2**30:.2g} GiB"


def _available_in_cgroup() -> int | None:
    """Return how many bytes the control group (version 2 or 1) of this process can still use, if limited."""
    for limit, used in (
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ):
        try:
            return int(Path(limit).read_text(encoding="utf-8")) - int(Path(used).read_text(encoding="utf-8"))
        except (OSError, ValueError):  # no such file, or the limit is "max"
            continue
    return None
