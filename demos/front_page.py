"""The bunny in its texture
===========================

This is the picture of the first page: the Stanford bunny, unwrapped along seams that `unwrap` finds, with a
texture of coloured squares. On the right is its atlas, the image that an artist paints. The squares have
the same size everywhere on the body, because `unwrap` preserves areas, too.
"""

from pathlib import Path

import numpy as np
import pyvista as pv
from stretch import bunny

from igl_linabf import unwrap
from igl_linabf.io import replacing
from igl_linabf.plot import plot_checkerboard, plot_uv


def make_squares(n: int = 40, texels: int = 2048) -> pv.Texture:
    """Return a texture of coloured squares whose hue depends on their place in the texture."""
    at = (np.arange(texels) + 0.5) / texels
    u, v = np.meshgrid(at, at)
    waves = [0.5 + 0.5 * np.cos(2 * np.pi * (u + v - shift)) for shift in (0.0, 1 / 3, 2 / 3)]
    odd = (np.floor(u * n) + np.floor(v * n)) % 2
    light = np.where(odd == 1, 0.95, 0.6)[..., None]
    return pv.Texture((255 * light * (0.35 + 0.65 * np.stack(waves, axis=-1))).astype(np.uint8))


if __name__ == "__main__":
    V, F = bunny()
    atlas = unwrap(V, F)
    print(atlas)
    assert atlas.good
    assert atlas.quality.stretch_l2 < 1.1
    texture = make_squares()
    plotter = pv.Plotter(shape=(1, 2), off_screen=True, window_size=[1600, 800], border=False)
    plotter.subplot(0, 0)
    plot_checkerboard(V, F, atlas, texture=texture, frequency=1.0, plotter=plotter)
    plotter.view_vector((0.35, -1.0, 0.25), viewup=(0, 0, 1))
    plotter.camera.zoom(1.3)
    plotter.subplot(0, 1)
    plot_uv(atlas.TC, atlas.FTC, texture=texture, frequency=1.0, plotter=plotter)
    plotter.view_xy()
    plotter.camera.zoom(1.35)
    path = Path("out") / "front_page.png"
    path.parent.mkdir(exist_ok=True)
    with replacing(path) as temporary:
        plotter.show(screenshot=temporary)
    print(f"wrote {path}")
