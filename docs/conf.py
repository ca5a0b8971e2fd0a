"""Configuration of Sphinx, which `make docs` runs to build these pages."""

import os
import sys
import tempfile
from importlib import metadata
from pathlib import Path
from typing import Any

import pyvista as pv
from sphinx.util.inspect import TypeAliasForwardRef

HERE = Path(__file__).parent
sys.path[:0] = [
    str(HERE),
    str(HERE.parent / "demos"),
]  # for gallery_pages, and for demos that import each other

import gallery_pages  # noqa: E402  # needs the path above

pv.BUILDING_GALLERY = True  # pyvista keeps the plotters for the scraper
pv.OFF_SCREEN = True
# an existing folder prevents the download of trame's other viewer
os.environ.setdefault("VTK_WASM_DIR_OVERRIDE", tempfile.mkdtemp(prefix="no-wasm-"))

project = "igl_linabf"
author = "the igl_linabf developers"
copyright = author
release = version = metadata.version("igl-linabf")

REPOSITORY = "https://github.com/igl-linabf/igl_linabf"

extensions = [
    "myst_nb",  # Markdown and the notebook
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = [
    "_build",
    "sg_execution_times.rst",
    *(
        f"{folder}/{name}"
        for folder in ("gallery", "recipes")
        for name in ("sg_execution_times.rst", "*.ipynb")
    ),
]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 240
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

autosummary_generate = True
# avoid a clash of quality.html and Quality.html on case-insensitive file systems
templates_path = ["_templates"]
autodoc_typehints = "signature"
# show the names of array types as written, not their definitions
autodoc_type_aliases = {name: name for name in ("ArrayLike", "FloatArray", "IntArray", "BoolArray")}
autodoc_type_aliases |= {
    "Hiding": "Literal['back'] | ArrayLike",
    "GivenCones": "Literal['auto'] | ArrayLike",
    "ConeAngles": "Literal['quarter'] | ArrayLike | None",
    "Values": "ArrayLike | Callable[[FloatArray], ArrayLike]",
}
python_maximum_signature_line_length = 80  # longer signatures have one parameter per line
python_trailing_comma_in_multi_line_signatures = False
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
default_role = "code"  # single backticks, as in the docstrings
# types in signatures without a link: types of other libraries, because the build has no network, and types of
# the package that the reference describes where they are used
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|np|pv|pyvista|pathlib|os|collections|typing|torch|trimesh|open3d|meshio)\..*"),
    ("py:.*", r"(ArrayLike|FloatArray|IntArray|BoolArray)"),
    ("py:.*", r"igl_linabf\.(surface|flattening\.methods|plot\.scene|angles)\..*"),
    ("py:.*", r"igl_linabf\.(flattening\.boundary_shapes|textures\.sampling|io\.(mesh_file|references))\..*"),
]

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

sphinx_gallery_conf = {
    "examples_dirs": ["../demos", "../recipes"],
    "gallery_dirs": ["gallery", "recipes"],
    "filename_pattern": r"/(?!compare_lscm)\w+\.py$",  # a command that requires a mesh
    "within_subsection_order": "gallery_pages.sort_key",
    "image_scrapers": ("pyvista", "gallery_pages.embed_scenes"),
    "reset_modules": (),
    "run_stale_examples": True,  # a demo may be unchanged although the library has changed
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "default_thumb_file": str(HERE / "images" / "cortex.png"),
}

html_theme = "pydata_sphinx_theme"
html_title = "igl_linabf"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sourcelink = False
html_theme_options = {
    "show_prev_next": True,
    "navbar_align": "left",
    "logo": {"text": f"igl_linabf {version}"},
    "icon_links": [{"name": "Source", "url": REPOSITORY, "icon": "fa-brands fa-github"}],
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}


def _keep_alias_name(self: TypeAliasForwardRef, name: str) -> None:
    """Initialise the reference such that it is printed by its name."""
    self.name = self.__name__ = self.__qualname__ = name
    self.__module__ = "builtins"


def _replace_factory_defaults(
    app: Any, what: str, name: str, obj: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Replace `<factory>`, the printed default of dataclass fields, by `...`."""
    return signature and signature.replace("<factory>", "..."), returned


def setup(app: Any) -> None:
    TypeAliasForwardRef.__init__ = _keep_alias_name  # in unions, Sphinx 9.0 prints the class of an alias
    app.connect(
        "builder-inited", gallery_pages.crop_tall_thumbnails, priority=900
    )  # after the galleries are built
    app.connect("autodoc-process-signature", _replace_factory_defaults)
