from .._types import BoolArray, ComplexArray, FloatArray, IntArray

# packing
def divisions(
    points: FloatArray,
    ends: IntArray,
    length: FloatArray,
    outer: BoolArray,
    normal: FloatArray,
    offset: FloatArray,
    outwards: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]: ...
def drawn(
    start: ComplexArray,
    end: ComplexArray,
    weight: IntArray,
    sides: IntArray,
    turns: ComplexArray,
    of: IntArray,
    half: float,
) -> tuple[IntArray, ComplexArray, IntArray, IntArray]: ...
def drawn_loops(
    vertex: IntArray, start: IntArray, turning: FloatArray, log_ratio: FloatArray
) -> tuple[ComplexArray, ComplexArray]: ...
def narrowest_turns(z: ComplexArray, start: IntArray) -> ComplexArray: ...
def on_shelves(sizes: FloatArray, taken: BoolArray) -> FloatArray: ...
def placed(
    side: int,
    most: int,
    spans: IntArray,
    shapes: IntArray,
    blocks: IntArray,
    start: IntArray,
    known: IntArray,
) -> tuple[IntArray, IntArray]: ...
def taken_cells(side: int, places: IntArray, blocks: IntArray, start: IntArray) -> BoolArray: ...
