from .._types import ComplexArray, FloatArray, IntArray

# overlaps
DEPTH: float

def assembled(
    triangle: ComplexArray,
    depth: FloatArray,
    start: IntArray,
    pairs: IntArray,
    turn: ComplexArray,
    shift: ComplexArray,
    worth: FloatArray,
    page: FloatArray,
) -> tuple[IntArray, ComplexArray, ComplexArray]: ...
def lie_over(some: ComplexArray, others: ComplexArray) -> bool: ...
def overlap_sheets(
    upper: IntArray, lower: IntArray, begin: IntArray, neighbour: IntArray, most: int
) -> tuple[IntArray, IntArray]: ...
def overlapping(z: ComplexArray, F: IntArray, chart: IntArray) -> IntArray: ...
