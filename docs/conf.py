"""How Sphinx builds these pages: `make docs`."""

import os
import sys
import tempfile
from importlib import metadata
from pathlib import Path
from typing import Any

import pyvista as pv
from sphinx.util.inspect import TypeAliasForwardRef

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "demos")]  # gallery_pages; the demos import each other

import gallery_pages  # noqa: E402  # of this folder

pv.BUILDING_GALLERY = True  # keeps the plotters for the scraper
pv.OFF_SCREEN = True
# trame's other viewer would be downloaded, were there no folder said to have it
os.environ.setdefault("VTK_WASM_DIR_OVERRIDE", tempfile.mkdtemp(prefix="no-wasm-"))

project = "igl_linabf"
author = "the igl_linabf developers"
copyright = author
release = version = metadata.version("igl-linabf")

REPOSITORY = "https://github.com/igl-linabf/igl_linabf"

extensions = [
    "myst_nb",  # Markdown, and the notebook
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
    *(f"{made}/{name}" for made in ("gallery", "recipes") for name in ("sg_execution_times.rst", "*.ipynb")),
]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 240
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

autosummary_generate = True
# file systems that do not tell quality.html from Quality.html
autosummary_filename_map = {"igl_linabf.Quality": "igl_linabf.Quality-class"}
templates_path = ["_templates"]
autodoc_typehints = "signature"
# names of arrays as they are written, not what they stand for
autodoc_type_aliases = {name: name for name in ("ArrayLike", "FloatArray", "IntArray", "BoolArray")}
autodoc_type_aliases |= {
    "Hiding": "Literal['back'] | ArrayLike",
    "GivenCones": "Literal['auto'] | ArrayLike",
    "ConeAngles": "Literal['quarter'] | ArrayLike | None",
    "Values": "ArrayLike | Callable[[FloatArray], ArrayLike]",
}
python_maximum_signature_line_length = 80  # else a parameter a line
python_trailing_comma_in_multi_line_signatures = False
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
default_role = "code"  # single backticks, as in the docstrings
# types in signatures: other libraries', which there is no network to look up, and the package's own that the
# reference describes where they are used
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|np|pv|pyvista|pathlib|os|collections|typing|torch|trimesh|open3d|meshio)\..*"),
    ("py:.*", r"(ArrayLike|FloatArray|IntArray|BoolArray)"),
    ("py:.*", r"igl_linabf\.(surface|flattening\.methods|plot\.scene|angles)\..*"),
    ("py:.*", r"igl_linabf\.(flattening\.boundary_shapes|textures\.sampling|io\.mesh_file)\..*"),
]

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

sphinx_gallery_conf = {
    "examples_dirs": ["../demos", "../recipes"],
    "gallery_dirs": ["gallery", "recipes"],
    "filename_pattern": r"/(?!compare_lscm)\w+\.py$",  # it is a command, and wants a mesh
    "within_subsection_order": "gallery_pages.order",
    "image_scrapers": ("pyvista", "gallery_pages.scenes"),
    "reset_modules": (),
    "run_stale_examples": True,  # the library may have changed where a demo has not
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
html_sidebars = {"results": []}  # it has no pages below
html_theme_options = {
    "show_prev_next": True,
    "navbar_align": "left",
    "logo": {"text": f"igl_linabf {version}"},
    "icon_links": [{"name": "Source", "url": REPOSITORY, "icon": "fa-brands fa-github"}],
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}


def _named(self: TypeAliasForwardRef, name: str) -> None:
    self.name = self.__name__ = self.__qualname__ = name
    self.__module__ = "builtins"


def _readable(
    app: Any, what: str, name: str, obj: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """A signature that is Python: defaults of dataclasses are printed as `<factory>`."""
    return signature and signature.replace("<factory>", "..."), returned


def setup(app: Any) -> None:
    TypeAliasForwardRef.__init__ = _named  # within a union, Sphinx 9.0 prints the class of an alias
    app.connect("builder-inited", gallery_pages.wide_thumbnails, priority=900)  # once the galleries are made
    app.connect("autodoc-process-signature", _readable)
