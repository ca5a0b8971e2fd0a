"""Read and write 3MF, GIFTI, FreeSurfer, VTP and tifxyz files with optional packages."""

from .neuroimaging import (
    FreeSurferFile,
    GiftiFile,
    parse_freesurfer,
    parse_gifti,
    save_freesurfer,
    save_gifti,
)
from .patches import (
    PATCH_MAGIC,
    Patch,
    average_surfaces,
    find_companion_surfaces,
    parse_patch,
    save_patch,
    write_patch,
)
from .three_mf import ThreeMfFile, parse_3mf, save_3mf
from .tifxyz import Segment, check_target, read_tifxyz, write_tifxyz, writing_tifxyz
from .vtk_polydata import VtpFile, copy_polydata_arrays, parse_vtp, save_vtp, triangulate_strip_cells
