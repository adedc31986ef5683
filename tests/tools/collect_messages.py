"""Collect the messages of all texts from the sources, and merge them into the file of every language.

Run `make messages` after a text has changed, and once for a new line in `languages.LANGUAGES`. It writes
`locale/CODE.po`, on which translators work, and from it the texts of the site, `site/src/text/CODE.json`. The same
sources give the same bytes, because there are no dates and no line numbers; each text is on one line.
"""

import io
import json
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import chain
from pathlib import Path

from babel.messages.catalog import Catalog, Message
from babel.messages.extract import extract
from babel.messages.pofile import read_po, write_po

from qdot.exercises.chapter import read_entries
from qdot.exercises.common.files import write_atomically
from qdot.exercises.families import FAMILIES
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.site.guide import GROUPS
from qdot.exercises.writing.languages import (
    ARM_HEADING,
    ARM_IN_SENTENCE,
    FAMILY,
    LANGUAGES,
    LOCALE,
    PHRASE,
    QUESTION,
    SOURCE,
    Catalogue,
    is_formula_number,
    name_mistake_context,
    read_catalogue,
)
from qdot.exercises.writing.render import EXTENSIONS, find_template_folder
from qdot.exercises.writing.translatable_phrases import ARMS, PHRASES

_ROOT = Path(__file__).resolve().parents[2]
_EXERCISES = _ROOT / "exercises"
SITE = _ROOT / "site" / "src" / "text"
"""The folder with the texts of the site; en.json has the English ones."""

Key = tuple[str | None, tuple[str, ...]]
"""The context of a message, and the message itself."""

FoundMessage = tuple[str, str | tuple[str, ...], str | None]
"""The file of a message, the message (or its singular and plural), and its context."""

_DATED_HEADERS = re.compile(
    r'^"(Project-Id|Report-Msgid|POT-|PO-|Last-|Language-Team|Generated-)[^"]*"\n', re.MULTILINE
)

PERCENT_PLACEHOLDER = re.compile(r"%\((\w+)\)s")
BRACE_PLACEHOLDER = re.compile(r"\{([\w-]+)\}")


def collect_catalog() -> Catalog:
    """Return all messages without a translation, in the order of their source files."""
    catalog = Catalog(header_comment="", fuzzy=False)
    for file, text, context in _find_messages():
        catalog.add(text, locations=[(file, 0)], context=context)
    return catalog


def _find_messages() -> Iterator[FoundMessage]:
    for path in sorted(_EXERCISES.rglob("*.py")):
        yield from _extract_messages("python", path, f"exercises/{path.relative_to(_EXERCISES).as_posix()}")
    for path in sorted(find_template_folder().rglob("*.j2")):
        yield from _extract_messages("jinja2", path, f"templates/{path.relative_to(find_template_folder()).as_posix()}")
    for name in ARMS:
        yield "exercises/writing/translatable_phrases.py", name, ARM_HEADING
        yield "exercises/writing/translatable_phrases.py", name, ARM_IN_SENTENCE
    for phrase in PHRASES:
        yield "exercises/writing/translatable_phrases.py", phrase, PHRASE
    for family in FAMILIES.values():
        yield "exercises/families", family.title, FAMILY
    for question in ALL_QUESTIONS.values():
        yield f"exercises/{'questions' if question.form == 'chapter' else 'quizzes'}", question.title, QUESTION
    for mistake in CATALOGUE.values():
        yield "exercises/mistakes", mistake.title, name_mistake_context(mistake.name)
        yield "exercises/mistakes", mistake.message, name_mistake_context(mistake.name)
    references = {mistake.chapter_reference for mistake in CATALOGUE.values() if mistake.source}
    for reference in sorted(reference for reference in references if not is_formula_number(reference)):
        yield "exercises/mistakes", reference, SOURCE
    yield from _find_messages_in_toml_files()
    for key, text in load_site_texts().items():
        yield "site/src/text/en.json", text, make_site_context(key)


def _find_messages_in_toml_files() -> Iterator[FoundMessage]:
    for text in _find_errata_texts():
        yield "exercises/chapter/errata.toml", text, "erratum"
    for example in read_entries("examples"):
        yield "exercises/chapter/examples.toml", example["title"], None
    for group, pages in GROUPS.items():
        for text in (group, *chain.from_iterable(pages.values())):
            yield "exercises/site/guide.toml", text, None


def _find_errata_texts() -> Iterator[str]:
    """Yield the texts of the chapter's errata that have words outside of formulas."""
    for entry in read_entries("errata"):
        *texts, values = entry.values()
        for text in (*texts, *(text for pair in values for text in pair)):
            if re.search("[a-z]{2}", re.sub(r"\$[^$]*\$", "", text)):
                yield text


@cache
def _extract_messages(method: str, path: Path, file_name: str) -> list[FoundMessage]:
    """Return the messages in a file, as Babel finds them; a message with a plural has two texts."""
    names = ",".join(name if isinstance(name, str) else f"{name.__module__}.{name.__name__}" for name in EXTENSIONS)
    options = {"extensions": names, "silent": "false"} if method == "jinja2" else {}
    with path.open("rb") as file:
        return [(file_name, text, context) for _, text, _, context in extract(method, file, options=options)]


def make_site_context(key: str) -> str:
    """Return the context of a text of the site."""
    return f"site {key}"


def load_site_texts() -> dict[str, str]:
    english: dict[str, str] = json.loads((SITE / "en.json").read_text(encoding="utf-8"))
    return english


def write_site_texts(code: str, words: Catalogue) -> str:
    texts = {key: words.translations.pgettext(make_site_context(key), text) for key, text in load_site_texts().items()}
    return json.dumps(texts, ensure_ascii=False, indent=2) + "\n"


def merge_messages(path: Path, messages: Catalog) -> Catalog:
    """Return the catalogue of a language with the current messages.

    Changed messages become fuzzy, and removed messages are dropped.
    """
    if path.is_file():
        catalog = open_catalog(path)
    else:
        catalog = Catalog(path.stem, header_comment=f"# {LANGUAGES.get(path.stem, path.stem)}", fuzzy=False)
    catalog.update(messages)
    catalog.obsolete.clear()
    return catalog


def open_catalog(path: Path) -> Catalog:
    with path.open("rb") as file:
        return read_po(file)


def write_po_text(catalog: Catalog) -> str:
    for message in catalog:
        _set_placeholder_flags(message)
    written = io.BytesIO()
    write_po(written, catalog, width=0, include_lineno=False)
    return _DATED_HEADERS.sub("", written.getvalue().decode())


def _set_placeholder_flags(message: Message) -> None:
    """Mark the style of a message's placeholders for translators' tools; LaTeX braces are not placeholders."""
    message.flags -= {"python-format", "python-brace-format"}
    text = " ".join(_list_texts(message.id))
    if PERCENT_PLACEHOLDER.search(text):
        message.flags.add("python-format")
    elif message.context and BRACE_PLACEHOLDER.search(text):
        message.flags.add("python-brace-format")


# --- faults of translations ---


def find_faults(code: str, catalog: Catalog, messages: Catalog) -> list[str]:
    """Return the faults of a language's catalogue, one sentence each."""
    expected, present = _index_by_key(messages), _index_by_key(catalog)
    unused_messages = [message for key, message in present.items() if key not in expected]
    obsolete_messages = [*unused_messages, *catalog.obsolete.values()]
    faults = [
        f"not in {code}.po, run `make messages`: {_quote(message)}"
        for key, message in expected.items()
        if key not in present
    ]
    faults += [f"no message any more, run `make messages`: {_quote(message)}" for message in obsolete_messages]
    if catalog.locale_identifier != code:
        faults.append(f"{code}.po says of itself that its language is {catalog.locale_identifier}")
    for key in expected:
        if key in present:
            faults += _find_message_faults(present[key], catalog.num_plurals)
    return faults


def _find_message_faults(message: Message, forms: int) -> Iterator[str]:
    texts, strings = _list_texts(message.id), _list_texts(message.string)
    if not all(strings):
        yield f"not translated: {_quote(message)}"
        return
    if message.fuzzy:
        yield f"its English has changed, or it was guessed from a text like it (“fuzzy”): check it: {_quote(message)}"
    if len(texts) > 1 and len(strings) != forms:
        yield f"has {len(strings)} plural forms, but {forms} are expected: {_quote(message)}"
    expected = _find_placeholders(message, texts[-1])
    for number, string in enumerate(strings):
        names = _find_placeholders(message, string)
        may_lack_some = len(strings) > 1 and number == 0  # the singular may spell out its number
        if names != expected and not (may_lack_some and names < expected):
            yield f"fills in {_list_names(names)} in place of {_list_names(expected)}: {_quote(message)}"
        if _find_outer_spaces(string) != _find_outer_spaces(texts[0]):
            yield f"has other spaces at its ends: {_quote(message)}"
        english_text = texts[0] if number == 0 else texts[-1]
        if (english := _count_formulas(english_text)) != (translated := _count_formulas(string)):
            differences = " ".join(sorted({*(english - translated), *(translated - english)}))
            yield f"has other formulas, {differences}: {_quote(message)}"


def _find_placeholders(message: Message, text: str) -> set[str]:
    by_percent = message.context is None or PERCENT_PLACEHOLDER.search(_list_texts(message.id)[0])
    return set((PERCENT_PLACEHOLDER if by_percent else BRACE_PLACEHOLDER).findall(text))


def _count_formulas(text: str) -> Counter[str]:
    """Return the formulas of a text, with decimal points, except those in quotations, which may be translated."""
    text_with_points = text.replace("{,}", ".").replace(r";\ ", ", ")  # a vector with decimal commas has semicolons
    return Counter(re.findall(r"\$[^$]*\$", re.sub(r"“[^”]*”|„[^“]*“", "", text_with_points)))


def _index_by_key(catalog: Catalog) -> dict[Key, Message]:
    return {(message.context, _list_texts(message.id)): message for message in catalog if message.id}


def _list_texts(text: str | Sequence[str] | None) -> tuple[str, ...]:
    return (text or "",) if isinstance(text, str | None) else tuple(text)


def _find_outer_spaces(text: str) -> tuple[bool, bool]:
    return text[:1].isspace(), text[-1:].isspace()


def _list_names(names: set[str]) -> str:
    return ", ".join(sorted(names)) or "nothing"


def _quote(message: Message) -> str:
    return f"“{_list_texts(message.id)[0]}”" + (f" ({message.context})" if message.context else "")


def main() -> None:
    """Merge the messages into all languages, rewrite the site's texts, and print what is left to translate."""
    messages = collect_catalog()
    for code in LANGUAGES:
        path = LOCALE / f"{code}.po"
        catalog = merge_messages(path, messages)
        write_atomically(path, write_po_text(catalog))
        write_atomically(SITE / f"{code}.json", write_site_texts(code, read_catalogue(path)))
        print(f"{path.relative_to(_ROOT)}: {len(messages)} messages")
        for fault in find_faults(code, catalog, messages):
            print(f"  {fault}")


if __name__ == "__main__":
    main()
