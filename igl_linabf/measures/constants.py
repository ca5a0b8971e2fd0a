"""The constants of measures: the grid on which overlaps are sought, and geodesic distances."""

# --- overlaps ---

# Cells along a side of the grid, at most; of n faces there are sqrt(n). With fewer, more faces are
# compared in vain; with more, marking cells takes longer. tests/measures/test_overlapping.py compares pairs.
MOST_GRID_CELLS = 512

# Share of a cell by which a side may miss it and yet marks it: rounding moves points by less. With less, a
# pair may be missed; with more, more cells are marked. tests/measures/test_overlapping.py compares pairs.
CELL_MARGIN = 1e-6

# --- distances ---

# Rings of neighbours within which distances are compared: FreeSurfer's number. Fewer tell only of single
# triangles; more cost time with their square. benchmarks/cortex.py
RINGS = 7

# Vertices from which distances are measured, at most. Of fewer, the error differs by more from that of all
# (by 0.002 of 1 at this number); more take longer, 3 ms each. tests/measures/test_distances.py
MAX_SOURCES = 1000

# Vertices whose distances igl computes in one call, each on its own piece of the surface. With fewer, calls
# cost more than distances; with many, igl's one queue over all pieces gets slow. benchmarks/cortex.py
SOURCES_A_CALL = 8
