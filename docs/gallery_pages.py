"""The order of the galleries, their interactive scenes, and their thumbnails."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

# the paper's figures in its order, then further demos; the recipes from files to programs
FIRST = (
    "cortex",
    "flat_subject",
    "in_the_browser",
    "interactive",
    "checkerboards",
    "angle_error",
    "obtuse",
    "second_iteration",
    "high_curvature",
    "greedy",
    "stretch",
    "holes",
    "boundaries",
    "pins",
    "quads",
    "seams_bunny",
    "hidden_seams",
    "cones_bunny",
    "even_texels",
    "packing",
    "baking",
    "front_page",
    "polygons",
    "pattern",
    "colours_into_glb",
    "xatlas_pipeline",
    "flat_cortex",
    "sheet_metal",
    "quads_from_scan",
    "folder_of_meshes",
    "deforming_mesh",
    "differentiable_renderer",
    "blender_python",
)


def sort_key(filename: str) -> tuple[int, str]:
    """Return the sort key of a script: its position in `FIRST`; other scripts follow by name."""
    name = Path(filename).stem
    return (FIRST.index(name) if name in FIRST else len(FIRST), name)


def embed_scenes(block: object, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Return frames with the HTML pages that a demo wrote to `out/`, and move these pages to the site."""
    folder = Path(gallery_conf["src_dir"]) / "_static" / "scenes"
    frames = []
    for page in sorted(Path("out").glob("*.html")):
        folder.mkdir(exist_ok=True)
        shutil.move(page, folder / page.name)
        frame = f'<iframe class="scene" title="{page.stem}" src="../_static/scenes/{page.name}"></iframe>'
        frames.append(f".. raw:: html\n\n    {frame}\n")
    return "\n".join(frames)


def crop_tall_thumbnails(app: Any) -> None:
    """Replace the thumbnails of tall pictures, whose rows are similar, by their upper part."""
    from PIL import Image

    conf = app.config.sphinx_gallery_conf
    width, height = conf.get("thumbnail_size", (400, 280))
    for folder in conf["gallery_dirs"]:
        for thumbnail in Path(app.srcdir, folder, "images", "thumb").glob("sphx_glr_*_thumb.png"):
            source = thumbnail.parent.parent / thumbnail.name.replace("_thumb.png", "_001.png")
            if not source.is_file():
                continue
            with Image.open(source) as picture:
                tall = picture.width * height // width
                if picture.height > 1.3 * tall:
                    upper = picture.convert("RGB").crop((0, 0, picture.width, tall))
                    upper.resize((width, height), Image.Resampling.LANCZOS).save(thumbnail)
