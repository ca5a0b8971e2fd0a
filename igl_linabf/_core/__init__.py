"""The loops over triangles, edges and matrices, compiled ahead from `src`: plain arrays in, plain arrays out.

There are two builds of the same source, for every processor and for those of x86-64-v3 (AVX2, since 2013).
"""

if hasattr(__loader__, "rebuild"):  # an editable install
    from ._editable import rebuild_if_changed

    rebuild_if_changed(__loader__)

from . import _baseline

if _baseline.has_v3():
    from . import _v3 as _built
else:
    _built = _baseline
