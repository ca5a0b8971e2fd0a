"""The numbers of sparse linear algebra, and what each decides."""

# Memory

# Bytes that a map takes at its peak for each face, but for factors. Less lets work begin that does not fit;
# more refuses what would. benchmarks/memory.py prints it.
BYTES_PER_FACE = 1000
# Bytes, over 8 n log2 n, of the factor of a planar Laplacian with n rows: 1.8 to 2.2 entries were measured,
# 3 is assumed, and half as much again for the zeros of supernodes, indices and work space.
# benchmarks/memory.py.
FILL = 4.5
# Bytes up to which it is not asked whether they are free. With less, small meshes wait for the system's
# answer; with more, a small limit is found too late. tests/linalg/test_memory.py.
UNASKED_BYTES = 2**25

# Solvers

# Steps of conjugate gradients after which the whole system is factored instead. With fewer, slow systems
# that would converge are factored; with more, hopeless ones take longer. tests/linalg/test_solvers.py.
MAX_CG_STEPS = 300
# Rows up to which CHOLMOD's simplicial factor is faster than its supernodal one with a good BLAS; above, it
# is slower. benchmarks/factors.py prints the times.
SIMPLICIAL_ROWS = 25_000
