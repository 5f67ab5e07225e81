"""How Sphinx makes a site of the pages in this folder: `make docs`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from making import reference  # noqa: E402
from making.calls import MODULES  # noqa: E402
from stickslip import __version__ as release  # noqa: E402, F401

reference.write(Path(__file__).parent / "reference")
project = "stickslip"
author = "The stickslip developers"
copyright = author  # noqa: A001
html_title = f"stickslip {release}"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "making.contents",
    "making.docstrings",
    "making.mathml",
]
exclude_patterns = ["making", "_build"]
nitpicky = True

# --- pages: plain Markdown, which reads well where there is no site ---------------------------------------------------

myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
highlight_language = "none"  # what is indented is text; what is code says its language

# --- how it looks -----------------------------------------------------------------------------------------------------

html_theme = "furo"
html_show_sphinx = False
html_copy_source = False
html_static_path = ["making/static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
pygments_style = "friendly"
pygments_dark_style = "monokai"

# --- the Python reference ---------------------------------------------------------------------------------------------

autodoc_typehints = "none"  # the docstrings say what is given, in the words of people
autodoc_member_order = "bysource"
toc_object_entries_show_parents = "hide"
public_modules = list(MODULES)
