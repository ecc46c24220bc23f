"""The site: `make docs` builds it into build/site from these pages and the docstrings."""

import re
import sys
from pathlib import Path

from pygments.lexers.special import TextLexer

import gspcli

_ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(_ROOT), str(_ROOT / "docs" / "_ext")]

project = "gsp"
author = "The gsp authors"
project_copyright = author
release = version = gspcli.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "made_pages",
]
html_theme = "furo"
html_title = f"gsp {release}"
exclude_patterns = ["conf.py"]
# Headings can be linked as on GitHub.
myst_heading_anchors = 4
# Attributes of one name in several classes are not links to any of them.
suppress_warnings = ["myst.header", "ref.python"]
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

_README = _ROOT / "README.md"
html_css_files = ["gallery.css"]
html_static_path = ["static"]
_LITERAL = re.compile(r"(?<![`\w:])`([^`\n]+)`(?!`|_)")


def _literals(app, what, name, obj, options, lines):
    """Show names between single quotation marks as code, as the docstrings mean them."""
    del app, what, name, obj, options
    lines[:] = [_LITERAL.sub(r"``\1``", line) for line in lines]


def _first_page(app, name, source):
    """Put the README before the contents; what it links outside docs/ is only named here."""
    del app
    if name == "index":
        text = _README.read_text(encoding="utf-8").replace("](docs/", "](")
        # Badges are pictures of services: the site works offline.
        text = re.sub(r"^\[!\[.*\n", "", text, flags=re.MULTILINE)
        text = re.sub(r"(?<!!)\[([^]]+)\]\([A-Z][^)]*\)", r"\1", text)
        source[0] = text + "\n" + source[0]


def _gallery(app, name, source):
    """Put the drawings into their page."""
    del app
    if name == "gallery":
        from docs._ext import site_gallery

        source[0] = source[0].partition("<!--")[0] + site_gallery.grid()


def _views(app, exception):
    """Write the pages to which the gallery leads."""
    if exception is None and app.builder.name == "html":
        from docs._ext import site_gallery

        site_gallery.write(Path(app.outdir))


def setup(app):
    """Connect what the docstrings and the first page need."""
    app.connect("source-read", _first_page)
    app.connect("source-read", _gallery)
    app.connect("build-finished", _views)
    app.connect("autodoc-process-docstring", _literals, priority=400)
    # Examples of CSV have nothing to highlight.
    app.add_lexer("csv", TextLexer)
