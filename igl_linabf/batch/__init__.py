"""Flatten many mesh files, in parallel with Dask, and record the results in a table.

`running` plans and runs a batch, `one_mesh` is the work of one Dask worker, `file_contents` reads the seams
and materials of a file, `baking` bakes its textures, `clusters` connects to Dask, `table` stores the results
so that they survive a crash, and `places` finds and writes files in folders and at URLs.
"""

from .baking import (
    BAKED_RESOLUTION,
    BakedPacking,
    bake_images,
    check_contents,
    check_target,
    list_image_kinds,
)
from .file_contents import (
    find_texture_seams,
    get_material_labels,
    warn_of_missing_coordinates,
    warn_of_parts_without_texture,
)
from .running import Batch, flatten_files
from .table import Row
