"""Read and write 3MF, GIFTI, FreeSurfer, VTP and tifxyz files with optional packages."""

from .neuroimaging import FreeSurferFile, GiftiFile, parse_freesurfer, parse_gifti, save_gifti, save_surf
from .optional_packages import call_reader, import_optional
from .patches import (
    PATCH_MAGIC,
    Patch,
    find_companion_surfaces,
    mean_surface,
    parse_patch,
    save_patch,
    write_patch,
)
from .three_mf import ThreeMfFile, parse_3mf, save_3mf
from .tifxyz import Segment, check_target, read_tifxyz, write_tifxyz, writing_tifxyz
from .vtk_polydata import VtpFile, keep_data_of_polydata, parse_vtp, save_vtp, without_strips
