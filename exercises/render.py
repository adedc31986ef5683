"""Jinja2 templates: found, configured and rendered in one place; templates format and never compute."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import jinja2

from exercises.languages import ENGLISH, Catalogue
from exercises.writing.latex import tex, tex_angle, tex_length, tex_lines

_HERE = Path(__file__).parent
_MARKUP = (".html.j2", ".svg.j2", ".xml.j2")


def template_folder() -> Path:
    """Return the folder of the templates: inside the package (wheel) or beside it (checkout)."""
    for folder in (_HERE / "templates", _HERE.parent / "templates"):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"no templates folder in {_HERE} or beside it")


@cache
def catalogue(language: str) -> Catalogue:
    """Return the catalogue of a language other than English."""
    return Catalogue.read(template_folder() / language / "catalogue.toml")


@cache
def environment(language: str = ENGLISH) -> jinja2.Environment:
    """Return the environment: undefined names are errors, markup is escaped, line ends are kept plain.

    In another language its own templates come before those of the same name in English; `phrase` and `mistake` are
    filters.
    """
    folders = [template_folder()] if language == ENGLISH else [template_folder() / language, template_folder()]
    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folders),
        undefined=jinja2.StrictUndefined,
        autoescape=lambda name: bool(name and name.endswith(_MARKUP)),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters.update(tex=tex, tex_lines=tex_lines, tex_length=tex_length, tex_angle=tex_angle)
    if language != ENGLISH:
        made.filters["phrase"] = catalogue(language).phrase
        made.filters["mistake"] = catalogue(language).mistake_title
    made.filters["json"] = lambda value: json.dumps(value, ensure_ascii=False)
    return made


def render(template: str, **context: Any) -> str:
    """Return the text of `template` (a file of templates/) with `context` filled in."""
    return environment().get_template(template).render(**context)
