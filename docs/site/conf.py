"""Sphinx's settings for the site that `make docs` builds from the staged sources (stage.py)."""

from __future__ import annotations

project = "aeroslosh"
author = "the aeroslosh authors"
html_title = "aeroslosh"
root_doc = "index"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_enable_extensions = ["attrs_inline"]
myst_heading_anchors = 4  # headings can be linked to as on GitHub
# a page of docs/ is read on GitHub too, where a fence of a console has no prompt lexer to please; headings there may skip a level
suppress_warnings = ["misc.highlighting_failure", "myst.header"]
html_theme = "furo"  # light and dark as the reader's system asks, one column on a phone
html_theme_options = {"source_repository": "", "navigation_with_keys": True}
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_show_sourcelink = False
pygments_style = "tango"
pygments_dark_style = "monokai"
nitpicky = True
