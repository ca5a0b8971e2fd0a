"""
A cortex from GIFTI to a flat GIFTI
===================================

The pial surface comes in as GIFTI. It is flattened so that lengths and areas are kept as well as they can
be, and goes out as a flat GIFTI surface with the same vertex numbers. A second GIFTI file has the
distortion: how much larger or smaller the area around each vertex has become.
"""

import gzip
import warnings
from pathlib import Path

import nibabel as nib
import numpy as np
import pyvista as pv
from nilearn.datasets import fetch_surf_fsaverage

from igl_linabf import distortion, flatten, quality
from igl_linabf.io import read_file, write_file
from igl_linabf.plot import colour_scale, plot_distortion

# %%
# nilearn comes with the surface, and with the faces that are left of it after FreeSurfer's experts cut it.
Path("out").mkdir(exist_ok=True)
fsaverage = fetch_surf_fsaverage("fsaverage5")
pial, cut = (
    nib.GiftiImage.from_bytes(gzip.decompress(Path(fsaverage[name]).read_bytes()))
    for name in ("pial_left", "flat_left")
)
pial.darrays[1] = cut.darrays[1]
nib.save(pial, "out/lh.cortex.surf.gii")

# %%
# Flatten it, and write the flat surface. Vertices that no face uses are left out of the map.
cortex = read_file("out/lh.cortex.surf.gii")
V, F = cortex.V, cortex.F
with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # which say just this, and that a flat surface has no positions in space
    result = flatten(V, F, "isometric")
    write_file("out/lh.flat.surf.gii", cortex, result.uv)
measured = quality(V, F, result.uv)
print(measured)
assert measured.flips == measured.overlaps == 0
assert measured.stretch_l2 < 1.2

# %%
# The distortion at the vertices: the mean over the triangles around each.
of_faces = distortion(V, F, result.uv, "area")
around = np.bincount(F.ravel(), minlength=len(V))
of_vertices = np.bincount(F.ravel(), np.repeat(of_faces, 3), len(V)) / np.maximum(around, 1)
shape = nib.gifti.GiftiDataArray(of_vertices.astype(np.float32), intent="NIFTI_INTENT_SHAPE")
nib.save(nib.GiftiImage(darrays=[shape]), "out/lh.area_distortion.shape.gii")

# %%
# Both open again, with a row for each vertex of the pial surface.
flat, area = nib.load("out/lh.flat.surf.gii"), nib.load("out/lh.area_distortion.shape.gii")
assert len(flat.darrays[0].data) == len(area.darrays[0].data) == len(V)
assert (flat.darrays[1].data == F).all()
np.testing.assert_allclose(flat.darrays[0].data[F[:, 0], :2], result.uv[F[:, 0]], atol=1e-4)

# %%
# The logarithm of the area's change, on the surface and on the map.
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plot_distortion(V, F, result.uv, "area", plotter=plotter)
plotter.view_vector((-1, 0, 0), (0, 0, 1))
plotter.subplot(0, 1)
map_ = pv.PolyData.from_regular_faces(flat.darrays[0].data, F)
plotter.add_mesh(map_, scalars=of_faces, lighting=False, **colour_scale([of_faces], "area"))
plotter.view_xy()
plotter.show(screenshot="out/flat_cortex.png")
