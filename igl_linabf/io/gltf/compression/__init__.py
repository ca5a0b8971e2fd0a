"""Decompress glTF files that are compressed by Draco or meshopt."""

from .buffers import decompress_gltf
