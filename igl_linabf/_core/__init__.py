"""The loops over triangles, edges and matrices, compiled ahead from `src`: plain arrays in, plain arrays out.

There are two builds of the same source, for every processor and for those of x86-64-v3 (AVX2, since 2013).
With IGL_LINABF_CORE=baseline in the environment the first one runs everywhere. `__init__.pyi` lists what is
bound.
"""

import os
from importlib import import_module

if hasattr(__loader__, "rebuild"):  # an editable install
    from ._editable import rebuild_if_changed

    rebuild_if_changed(__loader__)

from . import _baseline

_fast = _baseline.has_v3() and os.environ.get("IGL_LINABF_CORE") != "baseline"
_built = import_module("._v3", __name__) if _fast else _baseline
NEXT = [1, 2, 0]  # corner k + 1: where the left angle beta of corner k's fan is
PREV = [2, 0, 1]  # corner k + 2: where the right angle gamma is
BUILD = "x86-64-v3" if _fast else "baseline"

globals().update({name: value for name, value in vars(_built).items() if not name.startswith("_")})
