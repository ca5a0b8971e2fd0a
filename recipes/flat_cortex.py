"""
Flattening a cortex from GIFTI to GIFTI
=======================================

Read a pial surface from a GIFTI file, and flatten it such that lengths and areas are preserved as well as
possible. The result is a flat GIFTI surface with the same vertex numbers. A second GIFTI file contains the
distortion at each vertex: how much the area around it has grown or shrunk.
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
# nilearn includes the surface, and the faces that remain after experts of FreeSurfer cut it.
Path("out").mkdir(exist_ok=True)
fsaverage = fetch_surf_fsaverage("fsaverage5")
pial, cut = (
    nib.GiftiImage.from_bytes(gzip.decompress(Path(fsaverage[name]).read_bytes()))
    for name in ("pial_left", "flat_left")
)
pial.darrays[1] = cut.darrays[1]
nib.save(pial, "out/lh.cortex.surf.gii")

# %%
# Flatten the surface, and write the flat surface. Vertices without a face have no position in the map.
cortex = read_file("out/lh.cortex.surf.gii")
V, F = cortex.V, cortex.F
with warnings.catch_warnings():
    # vertices without a face, and 3-D positions that the new file lacks, cause warnings
    warnings.simplefilter("ignore")
    result = flatten(V, F, method="isometric")
    write_file("out/lh.flat.surf.gii", cortex, result.uv)
measured = quality(V, F, result.uv)
print(measured)
assert measured.flips == measured.overlaps == 0
assert measured.stretch_l2 < 1.2

# %%
# Compute the distortion at each vertex, the mean over the triangles around it.
face_change = distortion(V, F, result.uv, "area")
valence = np.bincount(F.ravel(), minlength=len(V))
vertex_change = np.bincount(F.ravel(), np.repeat(face_change, 3), len(V)) / np.maximum(valence, 1)
shape = nib.gifti.GiftiDataArray(vertex_change.astype(np.float32), intent="NIFTI_INTENT_SHAPE")
nib.save(nib.GiftiImage(darrays=[shape]), "out/lh.area_distortion.shape.gii")

# %%
# Open both files again. They have a row for each vertex of the pial surface.
flat, area = nib.load("out/lh.flat.surf.gii"), nib.load("out/lh.area_distortion.shape.gii")
assert len(flat.darrays[0].data) == len(area.darrays[0].data) == len(V)
assert (flat.darrays[1].data == F).all()
np.testing.assert_allclose(flat.darrays[0].data[F[:, 0], :2], result.uv[F[:, 0]], atol=1e-4)

# %%
# Draw the logarithm of the area change on the surface and on the map.
plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1400, 700], border=False)
plot_distortion(V, F, result.uv, "area", plotter=plotter)
plotter.view_vector((-1, 0, 0), (0, 0, 1))
plotter.subplot(0, 1)
map_ = pv.PolyData.from_regular_faces(flat.darrays[0].data, F)
plotter.add_mesh(map_, scalars=face_change, lighting=False, **colour_scale([face_change], "area"))
plotter.view_xy()
plotter.show(screenshot="out/flat_cortex.png")
