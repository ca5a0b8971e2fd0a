"""Constants of texture coordinates that are measured and packed."""

# The share of an island that is turned over from which on it is a mirrored half, not flipped triangles.
# With less, a fold in a map counts as a mirrored chart; with more, halves of different size count as flips.
# tests/uv_sets/test_checking.py has both.
LEAST_MIRRORED_SHARE = 0.25

# The share of the largest coordinate up to which two places in a map are one: so charts that lie on each
# other are found. With less, single precision parts them; with more, neighbours are one.
# tests/uv_sets/test_checking.py
SAME_PLACE = 1e-6

# The share of both charts' areas that has to lie on the other one, so that they are stacked on purpose.
# With less, accidents are; with more, halves with other triangles are not. tests/uv_sets/test_checking.py
STACKED = 0.9

# Texels along the side of a page whose density and margins are told, where no resolution is given. It scales
# figures, and decides nothing. docs/checking.md
CHECKED_RESOLUTION = 1024

# The distance in pages within which the nearest charts are looked for first; it is doubled until some are
# found. With less, there are more rounds; with more, many charts are compared. pages of a
# thousand charts take as long from 1e-4 to 1e-2. tests/uv_sets/test_checking.py has the right distance from
# 1e-4 to 0.4.
FIRST_REACH = 1e-3

# The share by which a figure may be beyond its limit, by rounding: charts packed with a padding keep it as
# a limit. With less, they fail by a digit of the last place; with more, what is beyond passes.
# tests/uv_sets/test_checking.py
LIMIT_ROUNDING = 1e-6

# The area of a chart in the map, over its largest coordinate squared, up to which it has none: packing
# could not turn it. With less, rounding counts as an area; with more, thin charts are left out.
# tests/uv_sets/test_repacking.py
ROUNDING = 1e-14
