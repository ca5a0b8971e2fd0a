"""
Texels and pages
================

Charts should fill a texture, but keep a distance from each other. `resolution` is the number of texels along
each side of a page, and `padding` the number of texels between two charts. `pack_together` puts several
surfaces on one page, all at the same scale. `texel_density` sets the scale; as many pages as necessary are
then filled.

The upper row shows the bunny with 2 and with 12 texels of padding, and together with a cortical hemisphere on
one page. The lower row shows three pages of both surfaces at a higher density. Texels covered by a chart are
coloured. A texel shared by two charts would be red, but no texel is shared::

    python demos/packing.py
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
import pyvista as pv
from even_texels import decimate, hemisphere
from stretch import bunny

from igl_linabf import Atlas, ChartOptions, Packing, unwrap
from igl_linabf.charts import pack_together
from igl_linabf.io import replacing
from igl_linabf.plot import WARNING
from igl_linabf.textures import find_covered_texels

RESOLUTION = 256
SHARED = -2  # value of a texel with two charts
# five colours for charts, one for texels without a chart, one for texels with two charts
COLOURS = ("#2f6690", "#81a4cd", "#d9a441", "#5f8a5f", "#8d6a9f", "#f5f3ee", WARNING)


def make_charts(atlases: Sequence[Atlas], page: int) -> np.ndarray:
    """Return the index of the chart at each texel of a page, over all atlases; -1 without a chart."""
    image, charts = np.full(RESOLUTION**2, -1), 0
    for atlas in atlases:
        chart = igl.vertex_components(atlas.triangles)[atlas.triangles[:, 0]]
        corners = atlas.TC[atlas.triangles]
        here = np.floor(corners.mean(axis=1)) @ [1, 10] == page
        for k in np.unique(chart[here]):
            triangles = (corners[here & (chart == k)] - [page % 10, page // 10]) * RESOLUTION - 0.5
            texels = find_covered_texels(triangles, (RESOLUTION, RESOLUTION)).index
            image[texels] = np.where(image[texels] == -1, charts + k, SHARED)
        charts += int(chart.max()) + 1
    return image.reshape(RESOLUTION, RESOLUTION)


def show(
    plotter: pv.Plotter, place: tuple[int, int], caption: str, atlases: Sequence[Atlas], page: int
) -> None:
    """Draw a page with the row v = 0 at the bottom."""
    charts = make_charts(atlases, page)
    caption = f"{caption}: {(charts != -1).mean():.0%} covered"
    print(f"{caption}, {(charts == SHARED).sum()} texels shared")
    assert not (charts == SHARED).any()
    palette = np.array([pv.Color(name).int_rgb for name in COLOURS], dtype=np.uint8)
    image = palette[np.choose(-np.minimum(charts, 0), (charts % 5, 5, 6))]
    texture = pv.Texture(np.ascontiguousarray(image[::-1]))
    texture.interpolate = False
    plotter.subplot(*place)
    plotter.add_mesh(pv.Plane(direction=(0, 0, 1)), texture=texture, lighting=False)
    plotter.add_text(caption, font_size=10)
    plotter.view_xy()
    plotter.camera.zoom(1.3)


if __name__ == "__main__":
    rabbit, triangles = decimate(*bunny(), 3000)
    brain = decimate(*hemisphere(), 4000)
    charts, close = ChartOptions(trade=15), Packing(resolution=RESOLUTION, padding=2)
    near, far = (
        unwrap(3 * rabbit, triangles, charts=charts, packing=packing)
        for packing in (close, Packing(resolution=RESOLUTION, padding=12))
    )
    other = unwrap(*brain, charts=charts, packing=close)
    assert near.good and far.good and other.good
    assert near.report.scale > far.report.scale  # more padding leaves less space for charts

    together = pack_together([near, other], close)
    assert np.isclose(together[0].report.scale, together[1].report.scale)
    density = 1.4 * together[0].report.scale * RESOLUTION
    dense = pack_together([near, other], replace(close, texel_density=density))
    pages = max(atlas.pages for atlas in dense)
    print(f"{density:.3f} texels per millimetre take {pages} pages")
    np.testing.assert_allclose([atlas.report.scale * RESOLUTION for atlas in dense], density)

    with pv.vtk_verbosity("error"):
        plotter = pv.Plotter(shape=(2, 3), off_screen=True, window_size=[1500, 1000], border=False)
    show(plotter, (0, 0), "padding 2", [near], 0)
    show(plotter, (0, 1), "padding 12", [far], 0)
    show(plotter, (0, 2), "two surfaces", together, 0)
    for page in range(min(pages, 3)):
        show(plotter, (1, page), f"page {1001 + page}", dense, page)
    Path("out").mkdir(exist_ok=True)
    with replacing("out/packing.png") as temporary:
        plotter.show(screenshot=temporary)
    plotter.close()
    print("wrote out/packing.png")
