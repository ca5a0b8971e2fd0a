"""Formats that other packages read and write: 3MF, GIFTI, FreeSurfer, VTP."""

from .neuroimaging import (
    FreeSurferFile,
    GiftiFile,
    parse_freesurfer,
    parse_gifti,
    save_gifti,
    save_patch,
    save_surf,
)
from .optional_packages import import_optional
from .three_mf import ThreeMfFile, parse_3mf, save_3mf
from .vtk_polydata import VtpFile, parse_vtp, save_vtp
