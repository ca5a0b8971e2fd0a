"""Constants of images that are moved."""

# Texels that are looked up at once. With less, calls take longer than their work; with more, a page of 4,096
# takes gigabytes of memory, as each texel has two frames of nine numbers.
# tests/textures/test_moved_textures.py
MOST_TEXELS_AT_ONCE = 1 << 18
