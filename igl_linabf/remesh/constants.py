"""Constants of remeshing."""

# The number of cells of a grid by default. With fewer, quadrangles leave a curved surface; with more, a first
# look takes long. `demos/quads.py` draws one.
DEFAULT_CELLS = 1000

# The number of cells above which a spacing is refused: most likely it is in another unit than uv. With less,
# real grids are refused; with more, memory runs out. tests/remesh/test_grid.py asks for too many.
MAX_CELLS = 10_000_000

# What is rounding: a distance from a line, in cells; and the sine of the angle by which a boundary turns at a
# vertex. With less, slivers of cells stay; with more, the grid leaves the surface. tests/remesh/test_grid.py.
ROUNDING = 1e-9
