"""The compiled core: loops over triangles, edges and matrices, on plain arrays.

The source in `src` is built twice: for any processor, and for x86-64-v3 (AVX2, since 2013). Set the
environment variable IGL_LINABF_CORE to "baseline" to use the first build everywhere. `__init__.pyi` declares
the functions.
"""

import os
from importlib import import_module

if hasattr(__loader__, "rebuild"):  # an editable install
    from ._editable import rebuild_if_changed

    rebuild_if_changed(__loader__)

from . import _baseline

_fast = _baseline.has_v3() and os.environ.get("IGL_LINABF_CORE") != "baseline"
_built = import_module("._v3", __name__) if _fast else _baseline
NEXT = [1, 2, 0]  # corner k + 1, whose angle is the left angle beta in the wheel of corner k
PREV = [2, 0, 1]  # corner k + 2, whose angle is the right angle gamma in the wheel of corner k
BUILD = "x86-64-v3" if _fast else "baseline"

globals().update({name: value for name, value in vars(_built).items() if not name.startswith("_")})
