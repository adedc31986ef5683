"""Find, configure and render the Jinja2 templates. Templates format text and never compute."""

import hashlib
import json
import re
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from jinja2.ext import Extension

from qdot.exercises.writing import custom_texts
from qdot.exercises.writing.languages import ENGLISH, load_catalogue
from qdot.exercises.writing.latex import tex, tex_angle, tex_length, tex_lines, tex_result, tex_value, tex_zero
from qdot.exercises.writing.markup import escape_latex
from qdot.exercises.writing.units import tex_unit, write_unit

_PACKAGE_FOLDER = Path(__file__).resolve().parents[1]
_MARKUP_EXTENSIONS = (".html.j2", ".svg.j2", ".xml.j2")
_MARKDOWN_SYNTAX = re.compile(r"[\\`*<\[$]|~~|(?<!\w)_|_(?!\w)|&(?=#?\w+;)")
"""Matches characters that have a meaning in Markdown."""


def find_folder(name_in_package: str, path_in_checkout: str) -> Path | None:
    """Return a folder inside the installed package or, if there is none, in a checkout of the repository."""
    folders = _PACKAGE_FOLDER / name_in_package, _PACKAGE_FOLDER.parent / path_in_checkout
    return next((folder for folder in folders if folder.is_dir()), None)


def find_template_folder() -> Path:
    """Return the folder of the templates."""
    folder = find_folder("templates", "templates")
    if folder is None:
        raise FileNotFoundError(f"no templates folder in {_PACKAGE_FOLDER} or beside it")
    return folder


class MessageLines(Extension):
    """An extension of Jinja2 that keeps the line break after a translated message."""

    def preprocess(self, source: str, name: str | None, filename: str | None = None) -> str:
        """Mark these line breaks in a template's source, because Jinja2 removes line breaks after blocks."""
        return source.replace("{% endtrans %}\n", "{% endtrans +%}\n")


EXTENSIONS = (MessageLines, "jinja2.ext.i18n")


class TemplateCache(jinja2.FileSystemBytecodeCache):
    """Stores compiled templates in a folder __pycache__ beside the templates, because compiling one takes 10 ms.

    Nothing is stored if the folder can't be written, or if Python is configured not to write bytecode. The stored files
    contain digests of the template and of Python. Their names contain a digest of everything else that affects the
    compiled templates.
    """

    def __init__(self, folder: Path) -> None:
        versions = f"{jinja2.__version__}/{sys.implementation.cache_tag}/{Path(__file__).read_text(encoding='utf-8')}"
        digest = hashlib.sha256(versions.encode()).hexdigest()[:16]
        super().__init__(str(folder / "__pycache__"), f"%s.{digest}.cache")

    def load_bytecode(self, bucket: jinja2.bccache.Bucket) -> None:
        """Load the bucket's code if it is stored."""
        with suppress(OSError):
            super().load_bytecode(bucket)

    def dump_bytecode(self, bucket: jinja2.bccache.Bucket) -> None:
        """Store the bucket's code."""
        if not sys.dont_write_bytecode:
            with suppress(OSError):
                Path(self.directory).mkdir(exist_ok=True)
                super().dump_bytecode(bucket)


@cache
def make_environment(language: str = ENGLISH) -> jinja2.Environment:
    """Return the Jinja2 environment of a language: undefined names are errors, and values are escaped in markup.

    Messages are translated to the language. The filters `phrase` and `mistake` translate words from problems.
    """
    templates = jinja2.Environment(
        extensions=EXTENSIONS, loader=jinja2.FileSystemLoader(find_template_folder()),
        undefined=jinja2.StrictUndefined, autoescape=lambda name: bool(name and name.endswith(_MARKUP_EXTENSIONS)),
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
        bytecode_cache=TemplateCache(find_template_folder()),
        optimized=False,  # constant folding makes loading slower by a fifth, and rendering hardly faster
    )  # fmt: skip
    messages = load_catalogue(language)
    templates.filters |= {
        "tex": tex, "tex_lines": tex_lines, "tex_length": tex_length, "tex_angle": tex_angle,
        "tex_value": tex_value, "tex_result": tex_result,
        "tex_zero": tex_zero, "unit": write_unit, "tex_unit": tex_unit, "phrase": messages.translate_phrase,
        "plain": escape_markdown, "heading": escape_heading, "latex": escape_latex,
        "mistake": lambda blame: messages.translate_title_in_sentence(blame.mistake, blame.title),
        "json": lambda value: json.dumps(value, ensure_ascii=False), "custom_text": custom_texts.write_custom_text,
        "custom_hints": custom_texts.write_custom_hints, "custom_options": custom_texts.write_custom_options,
        "custom_symbols": custom_texts.write_custom_symbols,
    }  # fmt: skip
    templates.install_gettext_translations(messages.translations, newstyle=True)  # type: ignore[attr-defined]  # the extension defines it
    return templates


def escape_markdown(text: str) -> str:
    r"""Escape a text for Markdown, so that it is shown literally: `<` in a title does not start a tag.

    >>> print(escape_markdown("Arms & <signs>"))
    Arms & \<signs>
    """
    return _MARKDOWN_SYNTAX.sub(r"\\\g<0>", text)


def escape_heading(title: str) -> str:
    r"""Escape a title for a heading in Markdown; a star after a word begins no emphasis, so it is not escaped.

    >>> print(escape_heading("Vectors p*"), escape_heading("Speed of *P* & <b>"))
    Vectors p* Speed of \*P* & \<b>
    """
    return re.sub(r"(?<=\w)\\\*(?!\S)", "*", escape_markdown(title))


def render(template: str, **context: Any) -> str:
    """Return the text of a template, a file in templates/, with the values of `context`."""
    return make_environment().get_template(template).render(**context)
