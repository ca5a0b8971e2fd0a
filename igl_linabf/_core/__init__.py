"""The loops over triangles, edges and matrices, compiled ahead from `src`: plain arrays in, plain arrays out.

There are two builds of the same source, for every processor and for those of x86-64-v3 (AVX2, since 2013).
"""

from . import _baseline

if _baseline.has_v3():
    from . import _v3 as _built
else:
    _built = _baseline

# sparse Cholesky factors
Factor, Symbolic = _built.Factor, _built.Symbolic
