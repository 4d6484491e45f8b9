"""The documentation: python -m sphinx -W --keep-going -b html docs docs/_build/html."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

import overview_dsp  # noqa: E402

mpl.use("agg")

project = "overView DSP"
author = "The overView DSP developers"
copyright = "the overView DSP developers, MIT licence"
release = version = overview_dsp.__version__
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
    "sphinx_design",
    "generated_reference",
]
exclude_patterns = ["_build", "_generated/**", "gallery/**/*.md5"]
templates_path = ["_templates"]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
suppress_warnings = ["config.cache"]  # sphinx-gallery's settings hold functions

autosummary_generate = True
autodoc_typehints, autodoc_typehints_format = "signature", "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 80
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/plot_",
    "capture_repr": ("_repr_html_",),
    # or a broken example is a yellow box in a green build
    "abort_on_example_error": True,
    # that page would fetch scripts from other hosts
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "show_memory": False,
    "show_signature": False,
    "download_all_examples": False,
    "within_subsection_order": "FileNameSortKey",
    "default_thumb_file": str(HERE / "pictures" / "sweeps.png"),
    "remove_config_comments": True,
}

html_theme = "pydata_sphinx_theme"
html_title = project
html_favicon = "../overview_dsp/web/site/icon.svg"
html_static_path = ["_static"]
html_css_files = ["overview.css"]
html_extra_path = ["_generated/extra"]
html_show_sourcelink = False
html_context = {"default_mode": "auto"}
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
# pages of one level have nothing to show beside them
html_sidebars = {page: [] for page in ("index", "quickstart", "touch", "benchmarks", "changelog")}
copybutton_exclude = ".linenos, .gp, .go"
