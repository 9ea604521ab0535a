# Makes a static site of the documents with Sphinx and MyST (Debian: python3-sphinx python3-myst-parser). `tools/docs` calls it with
# the repository's root as the folder of sources, so links between documents are those of the repository.
import re

import pygments.lexer
import pygments.token as token
from sphinx.highlighting import lexers

project = "bipc"
author = "the authors of bipc"
copyright = "the authors of bipc"
extensions = ["myst_parser"]
root_doc = "compiler/docs/book/index"
include_patterns = ["README.md", "compiler/docs/*.md", "compiler/docs/book/*.md", "grammar/README.md"]
# Links to sources and folders lead out of the site; tests/meta checks that they exist.
suppress_warnings = ["ref.myst"]
myst_heading_anchors = 3
html_theme = "alabaster"
html_theme_options = {"description": "BIP: behaviour, interaction, priority", "page_width": "1120px", "sidebar_width": "240px", "code_font_size": "0.82em"}
html_sidebars = {"**": ["about.html", "searchbox.html", "navigation.html"]}
html_copy_source = False
html_show_sphinx = False
html_title = "bipc"


class BipLexer(pygments.lexer.RegexLexer):
    """Colours of BIP, of robot module descriptions and of rules."""

    name = "BIP"
    tokens = {
        "root": [
            (r"//.*?$", token.Comment.Single),
            (r"/\*.*?\*/", token.Comment.Multiline),
            (r'"[^"\n]*"', token.String),
            (r"@\w+", token.Name.Decorator),
            (pygments.lexer.words(("package", "use", "end", "as", "atom", "compound", "component", "connector", "port", "type", "extern", "export", "function", "operator", "refine",
                                   "data", "const", "define", "on", "internal", "provided", "do", "up", "down", "place", "initial", "final", "from", "to", "priority", "if", "then",
                                   "else", "fi", "clock", "unit", "lazy", "delayable", "eager", "resume", "invariant", "at", "behavior", "state", "contains", "for", "in", "and",
                                   "or", "not"), prefix=r"\b", suffix=r"\b"), token.Keyword),
            (pygments.lexer.words(("int", "bool", "float", "string"), prefix=r"\b", suffix=r"\b"), token.Keyword.Type),
            (r"\b(?:true|false)\b", token.Keyword.Constant),
            (r"\d+(?:\.\d+)?", token.Number),
            (r"\w+", token.Name),
            (r"\s+", token.Text),
            (r".", token.Punctuation),
        ]
    }


for language in ("bip", "gen", "genom", "rules"):
    lexers[language] = BipLexer()


def add_navigation(app, name, source):
    """The pages that the index links to are the site's navigation, in that order, under the index's headings."""
    if name != root_doc:
        return
    for heading, section in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", source[0], re.M | re.S):
        pages = dict.fromkeys(re.findall(r"\]\(([^)#]+)\.md\)", section))
        source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {heading}\n\n" + "\n".join(pages) + "\n```\n"


def setup(app):
    app.connect("source-read", add_navigation)
