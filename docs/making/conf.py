"""The configuration of Sphinx."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from ecume import __version__

project = "ecume"
author = "the ecume developers"
copyright = "the ecume developers"  # noqa: A001  (Sphinx's name)
version = release = __version__
language = "en"

extensions = ["myst_parser", "mathml"]
myst_enable_extensions = ["dollarmath", "attrs_inline", "deflist"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
pygments_style = "a11y-high-contrast-light"  # comments, too, dark enough to be read (WCAG, 4.5 to 1)
pygments_dark_style = "monokai"

html_theme = "furo"
html_title = "ecume"
html_static_path = [str(Path(__file__).parent / "static")]
html_css_files = ["site.css"]
html_js_files = [("films.js", {"defer": "defer"})]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"sidebar_hide_name": False}
