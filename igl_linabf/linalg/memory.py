"""Estimates of the memory that a computation needs, and the memory that is free."""

import math
import sys
from pathlib import Path

import psutil

from ..errors import MemoryLimitError
from .constants import BYTES_PER_FACE, FILL, UNASKED_BYTES


def available() -> int | None:
    """Bytes that this process can still allocate; None if the system does not report them."""
    limits = [psutil.virtual_memory().available, _left_in_cgroup()]
    if sys.platform != "win32":
        import resource

        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        if soft != resource.RLIM_INFINITY:
            limits.append(soft - psutil.Process().memory_info().vms)
    known = [limit for limit in limits if limit is not None]
    return max(min(known), 0) if known else None


def factor_bytes(n: int, block: int = 1) -> int:
    """Bytes of the factor of a planar graph's matrix, n by n, with `block` by `block` entries.

    It has O(n log n) entries (Lipton, Rose, Tarjan 1979).
    """
    return int(FILL * n * math.log2(max(n, 2)) * 8 * block**2)


def fits(wanted: int) -> bool:
    """Whether so many bytes are free."""
    free = None if wanted <= UNASKED_BYTES else available()
    return free is None or wanted <= free


def check_memory(faces: int, factor: int) -> None:
    """Raise if so many faces, and a factor of so many bytes, do not fit into memory."""
    wanted = BYTES_PER_FACE * faces + factor
    if not fits(wanted):
        raise MemoryLimitError(
            f"{faces:,} faces take about {gigabytes(wanted)}, but only {gigabytes(available() or 0)} "
            "are free: decimate the mesh (igl.qslim), cut it into parts (igl_linabf.cut), or use a machine "
            "with more memory"
        )


def gigabytes(n: int) -> str:
    """Bytes in words: "1.5 GiB"."""
    return f"{n / 2**30:.2g} GiB"


def _left_in_cgroup() -> int | None:
    """What is left of the memory limit of this process's control group (version 2 or 1), as in containers."""
    for limit, used in (
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ):
        try:
            return int(Path(limit).read_text(encoding="utf-8")) - int(Path(used).read_text(encoding="utf-8"))
        except (OSError, ValueError):  # there is none, or it is "max"
            continue
    return None
