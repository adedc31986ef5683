"""docs/dependencies.md: every library that qdot asks for, why, and what it weighs; and what install words say.

`dependencies.json` is what was found by `python -m tests.tools.dependencies`: version, licence, size, last release.
"""

import json
import re
from pathlib import Path
from typing import Any

from qdot.exercises.common.extras import EXTRAS, install_words
from qdot.exercises.writing.render import render

DATA = Path(__file__).with_suffix(".json")

WHY = {
    "sympy": "the algebra of derivations: everything that is asked and solved",
    "numpy": "arms in numbers: certificates, comparing answers, figures",
    "mpmath": "comparing answers with 50 digits; SymPy needs it anyway",
    "jinja2": "every text that people read: statements, notebooks, pages",
    "markdown-it-py": "statements are written in Markdown, and go to HTML, LaTeX and Typst by its tokens",
    "nbformat": "notebooks as Jupyter defines them, checked before they are handed out",
    "pydantic": "assignment.toml and certificates read strictly, and refused with the place that is wrong",
    "rich": "progress of long commands on a terminal, with rate and time left",
    "typer": "the command line, its help and its completion",
    "polib": "the catalogue of texts in other languages: problems in German, on the site",
    "typst": "PDF that is accessible, set by a compiler with fonts of its own: nothing else is to be installed",
    "matplotlib": "the charts of the report and the map of `qdot solve`, as SVG",
    "xlsxwriter": "workbooks for Excel, with formats and the same bytes each time",
}
"""What each library is for."""

OWN = re.compile(r"""pip install (['"]?)(?:qdot|\.)(?:\[([a-z,]+)\])?\1(?![\w=./\[-])""")
"""How people are told to install qdot itself, with extras or without."""


def with_install_words(page: str) -> str:
    """Return a page with the words by which qdot is installed as they hold now; steps of a CI stay as they are."""
    lines = (line if "- run:" in line else OWN.sub(lambda match: install_words(match[2] or ""), line) for line in
             page.split("\n"))  # fmt: skip
    return "\n".join(lines)


def dependencies_page() -> str:
    """Return docs/dependencies.md."""
    measured: dict[str, dict[str, Any]] = json.loads(DATA.read_text(encoding="utf-8"))
    rows = [{"name": name, "why": why, **measured["libraries"][name]} for name, why in WHY.items()]
    base = [row for row in rows if not row["extra"]]
    by_extra = {extra: [row for row in rows if row["extra"] == extra.name] for extra in EXTRAS.values()}
    return render("docs/dependencies.md.j2", base=base, by_extra=by_extra, found=measured, words=install_words)
