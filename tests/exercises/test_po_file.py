"""Files of translations are read as Babel reads them, which writes them."""

import io
from gettext import GNUTranslations
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po as babels
from babel.messages.pofile import write_po
from hypothesis import given
from hypothesis import strategies as st

from exercises.languages import LANGUAGES, LOCALE
from exercises.po_file import read_po

FILE = r"""# A comment, and the head of the file.
msgid ""
msgstr ""
"Language: fr\n"
"Plural-Forms: nplurals=3; plural=(n%10==1 ? 0 : n > 4 ? 1 : 2);\n"
"Content-Type: text/plain; charset=utf-8\n"
msgid "no blank line before"
msgstr "sans"

#. from whoever translated
#: exercises/a.py
#, python-format
msgid ""
"row %(n)s, "
"\"quoted\", \\theta\n"
msgstr "ligne %(n)s, "
"«\"», \\theta\n"

msgctxt "family"
msgid "arm"
msgstr "bras"

msgctxt ""
msgid "arm"
msgstr "vide"

#, python-format, fuzzy
#| msgid "as it was"
msgid "as it is"
msgstr "comme c'était"

msgid "not yet"
msgstr ""

msgid "%(n)s joint"
msgid_plural "%(n)s joints"
msgstr[0] "a"
msgstr[1] "b"
msgstr[2] ""
"c"

msgid "half of it"
msgid_plural "halves"
msgstr[0] "une moitié"
msgstr[1] ""
msgstr[2] ""

#~ msgid "gone"
#~ msgstr "parti"

msgid "at the end of the file"
msgstr "fin"""


def by_babel(path: Path) -> GNUTranslations:
    compiled = io.BytesIO()
    with path.open("rb") as file:
        write_mo(compiled, babels(file))
    compiled.seek(0)
    return GNUTranslations(compiled)


@pytest.mark.parametrize("language", LANGUAGES)
def test_our_catalogues_say_what_they_say_to_babel(language: str) -> None:
    path = LOCALE / f"{language}.po"
    ours, theirs = read_po(path), by_babel(path)
    with path.open("rb") as file:
        messages = [message for message in babels(file) if message.id]
    assert len(messages) > 2000
    for message in messages:
        one, *plural = [message.id] if isinstance(message.id, str) else message.id
        for n in range(4) if plural else ():
            assert ours.ngettext(one, plural[0], n) == theirs.ngettext(one, plural[0], n)
        if message.context:
            assert ours.pgettext(message.context, one) == theirs.pgettext(message.context, one) != ""
        else:
            assert ours.gettext(one) == theirs.gettext(one) != ""


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_a_file_as_any_tool_may_write_it(tmp_path: Path, ends: str) -> None:
    path = tmp_path / "fr.po"
    path.write_bytes(f'{FILE}"'.replace("\n", ends).encode())
    read = read_po(path)
    assert read.gettext("no blank line before") == "sans"
    assert read.gettext('row %(n)s, "quoted", \\theta\n') == 'ligne %(n)s, «"», \\theta\n'
    assert (read.pgettext("family", "arm"), read.pgettext("", "arm"), read.gettext("arm")) == ("bras", "vide", "arm")
    assert read.gettext("as it is") == "as it is", "what is fuzzy is left out"
    assert read.gettext("not yet") == "not yet" and read.gettext("gone") == "gone"
    assert [read.ngettext("%(n)s joint", "%(n)s joints", n) for n in (1, 5, 2)] == ["a", "b", "c"]
    assert [read.ngettext("half of it", "halves", n) for n in (1, 5)] == ["half of it", "halves"]
    assert read.gettext("at the end of the file") == "fin"
    assert read.info()["language"] == "fr"


@pytest.mark.parametrize("line", ["msgid arm", '"nothing before"', 'msgid "arm', "<html>", 'msgfoo "a"'])
def test_a_line_of_something_else_is_named(tmp_path: Path, line: str) -> None:
    path = tmp_path / "fr.po"
    path.write_text(f"# French\n{line}\n")
    with pytest.raises(ValueError, match=r"fr\.po: line 2 is none of a \.po file"):
        read_po(path)


TEXTS = st.text(st.sampled_from('ab é"\\\n\t\r%{}#,~|[]msgid'), min_size=1, max_size=120)


@given(
    rows=st.lists(st.tuples(st.none() | TEXTS, TEXTS, st.none() | TEXTS, TEXTS, st.booleans()), max_size=6),
    width=st.sampled_from([0, 20, 76]),
)
def test_whatever_babel_writes_is_read_as_babel_reads_it(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[str | None, str, str | None, str, bool]], width: int
) -> None:
    made = Catalog("de")
    for context, one, many, own, fuzzy in rows:
        flags = ("fuzzy",) if fuzzy else ()
        if many is None:
            made.add(one, own, flags=flags, context=context)
        else:
            made.add((one, many), (own, own), flags=flags, context=context)
    path = tmp_path_factory.mktemp("po") / "de.po"
    with path.open("wb") as file:
        write_po(file, made, width=width)
    ours, theirs = read_po(path), by_babel(path)
    for context, one, many, _, _ in rows:
        for n in (1, 2):
            asked = (one, many or one, n)
            assert ours.ngettext(*asked) == theirs.ngettext(*asked)
            if context:
                assert ours.npgettext(context, *asked) == theirs.npgettext(context, *asked)
        assert ours.gettext(one) == theirs.gettext(one)
