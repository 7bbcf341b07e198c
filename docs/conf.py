"""How Sphinx builds the site: ``make docs``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import fibermelt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

if TYPE_CHECKING:
    from sphinx.application import Sphinx

project = "fibermelt"
author = "The fibermelt developers"
project_copyright = author
version = release = fibermelt.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
    "mathml",
    "names",
]
exclude_patterns = ["_build", "_ext"]
nitpicky = True
default_role = "py:obj"  # docstrings have names in single backticks: each must exist
smartquotes = False  # quotes are part of what a study says
toc_object_entries_show_parents = "hide"

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

nb_execution_mode = "force"  # what a notebook shows is what comes out now
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_merge_streams = True

autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_type_aliases = {name: name for name in ("Array", "Index")}
napoleon_google_docstring = False
# Types in docstrings are words, such as "(n, 2) array": no names to look up.
napoleon_use_param = False
napoleon_use_rtype = False
maximum_signature_line_length = 88

html_theme = "furo"
html_title = "fibermelt"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#8a3b12", "color-brand-content": "#8a3b12"},
    "dark_css_variables": {"color-brand-primary": "#f2a477", "color-brand-content": "#f2a477"},
}

sphinx_gallery_conf = {
    "examples_dirs": str(HERE.parent / "examples"),
    "gallery_dirs": "gallery",
    # That for a cluster is shown, and needs a cluster to run.
    "filename_pattern": r"[/\\](?!sweep_on_slurm)\w+\.py$",
    "abort_on_example_error": True,
    "within_subsection_order": "shelf.Shelf",
    "default_thumb_file": str(HERE / "images" / "bead.png"),
    "capture_repr": (),
    "download_all_examples": False,
    "notebook_extensions": set(),
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
}


def setup(app: Sphinx) -> None:
    """Fill in what is generated, and turn links between the project's files into the site's."""
    from generated import fill_in  # noqa: PLC0415  found once _ext is on the path
    from links import rewritten  # noqa: PLC0415

    def read(_app: Sphinx, page: str, content: list[str]) -> None:
        source = HERE / f"{page}.md"
        if source.is_file():
            content[0] = rewritten(fill_in(content[0]), source, source.parent)

    def include(_app: Sphinx, path: Path, _page: str, content: list[str]) -> None:
        # Every page that includes a file lies beside this one.
        content[0] = rewritten(content[0], (HERE / path).resolve(), HERE)

    app.connect("source-read", read)
    app.connect("include-read", include)
