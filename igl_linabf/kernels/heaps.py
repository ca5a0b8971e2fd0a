"""A binary heap of the nodes that a search has reached, for loops."""

from .._types import FloatArray, IntArray
from .choice import inlined


@inlined
def _risen(heap: IntArray, place: IntArray, key: FloatArray, i: int) -> None:
    """Restore a binary heap of nodes, the least key first, above place i; `place` is that of each node."""
    node = heap[i]
    while i > 0 and key[heap[(i - 1) >> 1]] > key[node]:
        heap[i] = heap[(i - 1) >> 1]
        place[heap[i]] = i
        i = (i - 1) >> 1
    heap[i] = node
    place[node] = i


@inlined
def taken_first(heap: IntArray, place: IntArray, key: FloatArray, size: int) -> int:
    """The first node of a heap of this size, which is a heap of the others then."""
    first, node, i = heap[0], heap[size - 1], 0
    while 2 * i + 1 < size - 1:
        child = 2 * i + 1
        if child + 2 < size and key[heap[child + 1]] < key[heap[child]]:
            child += 1
        if key[heap[child]] >= key[node]:
            break
        heap[i] = heap[child]
        place[heap[i]] = i
        i = child
    heap[i] = node
    place[node] = i
    return int(first)


@inlined
def reached(
    there: int,
    way: float,
    node: int,
    heap: IntArray,
    place: IntArray,
    distance: FloatArray,
    before: IntArray,
    size: int,
) -> int:
    """Give a node its way over another one, and its place in the heap; return the heap's size."""
    if place[there] < 0:
        heap[size], place[there] = there, size
        size += 1
    distance[there], before[there] = way, node
    _risen(heap, place, distance, place[there])
    return size
