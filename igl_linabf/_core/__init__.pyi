from .._types import FloatArray, IntArray

# sparse Cholesky factors

class Factor:
    bad_row: int

    def solve(self, B: FloatArray) -> FloatArray: ...

class Symbolic:
    bytes: int

    def __init__(self, indptr: IntArray, indices: IntArray, block: int = 1) -> None: ...
    def factor(self, values: FloatArray) -> Factor: ...
