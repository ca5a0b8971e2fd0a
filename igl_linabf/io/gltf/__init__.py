"""Read and write glTF 2.0, as text and as binary GLB."""

from .images import has_texture_transforms
from .reading import GltfFile, parse_gltf, select_second_uv_set
from .rewriting import save_gltf
