"""How Sphinx makes the site: `python -m sphinx -W --keep-going -c docs . build/site`, see decision 20."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx import addnodes
from sphinx.application import Sphinx

from gd_analyze import __version__

sys.path.insert(0, str(Path(__file__).parent))

project = "gd-analyze"
author = "The gd-analyze authors"
version = release = __version__

# The root is the source, so that the links of a repository page are those of the site.
root_doc = "docs/index"
include_patterns = ["*.md", "analysis/*.md", "docs/**.md", "docs/tutorials/*.py", "docs/tutorials/*.ipynb"]
exclude_patterns = [".*", "src", "tests", "data", "reports", "build", "dist"]

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
nb_custom_formats = {".py": "percent_format.notebook"}
nb_execution_mode = "off"  # outputs are stored, and tests compare them with those of a new run
myst_heading_anchors = 4

autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"gd-analyze {release}"
html_extra_path = ["site_root"]  # index.html, which leads to docs/index.html
html_static_path = ["static"]
html_css_files = ["formulas.css"]
html_copy_source = False
html_show_copyright = False
html_math_renderer = "mathml"

man_pages = [("docs/cli", project, "robot-arm dynamics, by effect", author, 1)]


def inline(translator: Any, node: nodes.math) -> None:
    """Write a formula as MathML, which browsers set without a script."""
    translator.body.append(tex2mathml(node.astext(), as_block=False))
    raise nodes.SkipNode


def block(translator: Any, node: nodes.math_block) -> None:
    """Write a formula on lines of its own."""
    translator.body.append(tex2mathml(node.astext(), as_block=True))
    raise nodes.SkipNode


def opened(translator: Any, node: addnodes.download_reference) -> None:
    """Write a link to a file, such as a report, that opens it in place; Sphinx's own saves it."""
    href = f"{translator.builder.dlpath}/{node['filename']}"
    translator.body.append(translator.starttag(node, "a", "", href=href))


def left(translator: Any, _: addnodes.download_reference) -> None:
    """End the link."""
    translator.body.append("</a>")


def setup(app: Sphinx) -> None:
    """Add MathML to the renderers of formulas, and links that open files."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    app.add_node(addnodes.download_reference, override=True, html=(opened, left))
