"""Problems and the site in other languages: every message is translated, and the same formulas stand in all of them."""

import json
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog, Message

from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, select_quiz_questions
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.site.bank import make_titles_json
from qdot.exercises.site.record import make_site_record, translate_record, translate_solutions
from qdot.exercises.writing import languages, translatable_phrases
from qdot.exercises.writing.languages import (
    LANGUAGES,
    LOCALE,
    load_catalogue,
    make_phrase_pattern,
    name_mistake_context,
    read_catalogue,
)
from qdot.exercises.writing.problem_texts import (
    write_hints,
    write_option,
    write_prompt,
    write_solution,
    write_statement,
)
from qdot.exercises.writing.render import find_template_folder, make_environment
from tests.support.problems import get_problem, select_parts
from tests.support.suites import few_or_all_families, select_for_suite
from tests.tools import collect_messages
from tests.tools.collect_messages import (
    collect_catalog,
    find_faults,
    load_site_texts,
    merge_messages,
    open_catalog,
    write_po_text,
    write_site_texts,
)

LEFT = re.compile(
    r"\b(the|and|of|is|are|with|joints?|axis|axes|which|that|to|by|from|revolute|prismatic|or|as|row|column|arm's"
    r"|singularity|lie|one|two|three|each|moves?|turned|radians|typed)\b"
)
"""English words that no German text has; those of a third language may have others."""
ASKED_A_QUIZ = select_for_suite(
    ("planar-2r", "wrist-zyz"), tuple(name for name in FAMILIES if not FAMILIES[name].has_varied_structure)
)
PIECES = re.compile(r"\$\$.*?\$\$|\$[^$]*\$|`[^`]*`", re.DOTALL)


def pieces(text: str) -> Counter[str]:
    """Return the formulas and the code in a text, decimals with points."""
    found = (re.sub(r"\s+", " ", piece) for piece in PIECES.findall(text))
    plain = (re.sub(r"\\text\{[^}]*[a-zäöü]{4,}[^}]*\}", "", piece) for piece in found)  # words in a formula
    return Counter(piece.replace("{,}", ".").replace("; ", ", ") for piece in plain)


def both(problem: Problem, language: str) -> Iterator[tuple[str, str, str]]:
    """Yield every text of a problem: what it is, in English, and in a language."""
    yield "statement", write_statement(problem, ""), write_statement(problem, "", language=language)
    for part in problem.parts:
        yield f"{part.name}: prompt", write_prompt(problem, part), write_prompt(problem, part, language)
        yield f"{part.name}: solution", write_solution(problem, part), write_solution(problem, part, language)
        told = zip(write_hints(problem, part), write_hints(problem, part, language), strict=True)
        for number, (english, own) in enumerate(told, 1):
            yield f"{part.name}: hint {number}", english, own
        for index in range(len(part.answer.offered_options)):
            own = write_option(problem, part, index, language)
            yield f"{part.name}: option {index}", write_option(problem, part, index), own


@pytest.mark.parametrize("language", LANGUAGES)
@few_or_all_families
def test_the_texts_of_a_family_hold_the_same_formulas_and_no_english(language: str, family: str) -> None:
    problem = get_problem(family, 0)
    problems = [replace(problem, parts=tuple(select_parts(problem)))]
    if family in ASKED_A_QUIZ:
        problems.append(generate(ProblemId(family, 1, select_quiz_questions(family))))
    for problem in problems:
        for name, english, own in both(problem, language):
            assert pieces(own) == pieces(english), (problem.id, name)
            plain, words = PIECES.sub(" ", own), PIECES.sub(" ", english)
            assert not LEFT.findall(plain), (problem.id, name, own)
            assert plain.strip() != words.strip() or not re.search(r"[a-z]{3}", words), (problem.id, name)
        assert load_catalogue(language).translate_arm_title(problem.chain.title) != problem.chain.title


@pytest.fixture(scope="module")
def due() -> Catalog:
    return collect_catalog()


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_message_is_translated_and_none_is_out_of_date(language: str, due: Catalog) -> None:
    assert find_faults(language, open_catalog(LOCALE / f"{language}.po"), due) == []


@pytest.mark.parametrize("language", LANGUAGES)
def test_make_messages_has_nothing_to_write(language: str, due: Catalog) -> None:
    path = LOCALE / f"{language}.po"
    text = path.read_text(encoding="utf-8")
    assert write_po_text(merge_messages(path, due)) == text, "run `make messages`"
    assert not re.search(r"POT-Creation|Revision-Date|Generated-By|[/]home/|:\d+$", text, re.MULTILINE)
    of_site = (collect_messages.SITE / f"{language}.json").read_text(encoding="utf-8")
    assert of_site == write_site_texts(language, read_catalogue(path))
    assert f'"./{language}.json"' in (collect_messages.SITE / "languages.ts").read_text(encoding="utf-8")


def test_messages_come_from_every_kind_of_source(due: Catalog) -> None:
    english, scara = load_site_texts(), FAMILIES["scara"].title
    for message, context in (
        ("the world frame", None),  # Python
        ("All columns are zero.", None),  # a template
        ("There,", "has rank"), (scara, "family"), ("row {n}", "phrase"),
        (english["verdict.branches"], "site verdict.branches"),
        *((mistake.message, name_mistake_context(mistake.name)) for mistake in CATALOGUE.values()),
    ):  # fmt: skip
        assert due.get(message, context) is not None, message
    assert found(due, "In this table %(links)s is zero.").id[1] == "In this table %(links)s are zero."
    assert due.get(scara) is None
    text = (collect_messages.SITE / "en.json").read_text(encoding="utf-8")
    assert list(english) == re.findall(r'^  "([^"]+)":', text, re.MULTILINE)


def test_templates_that_tell_a_problem_have_no_words_outside_of_messages() -> None:
    names = ("hint", "solution", "statement")
    folder = find_template_folder()
    paths = [*folder.glob("questions/*.j2"), *(folder / "writing" / f"{name}.md.j2" for name in names)]
    for path in paths:
        text = re.sub(r"\{% trans .*?\{% endtrans [+-]?%\}", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        plain = re.sub(r"\{#.*?#\}|\{%.*?%\}|\{\{.*?\}\}", "", text, flags=re.DOTALL)
        assert re.findall(r"[A-Za-z]{2,}", re.sub(r"\\[A-Za-z]+", "", PIECES.sub("", plain))) == [], path


def found(catalog: Catalog, message: str, context: str | None = None) -> Message:
    one = catalog.get(message, context)
    assert one is not None, message
    return one


def german() -> Catalog:
    return open_catalog(LOCALE / "de.po")


@pytest.mark.parametrize(
    ("message", "context", "string", "said"),
    [
        ("By (6.7),", None, "", "not translated"),
        ("By (6.7),", None, " Nach (6.7) ist", "spaces"),
        ("By (6.7),", None, "Nach (6.7) für $P$", "other formulas, $P$"),
        ("The answer is **%(letter)s**.", None, "Die Antwort ist **%(brief)s**.", "brief in place of letter"),
        ("row {n}", "phrase", "Zeile", "nothing in place of n"),
        ("In this table %(links)s is zero.", None, ("In dieser Tabelle ist %(links)s null.",), "1 plural forms"),
    ],
)
def test_what_is_wrong_with_a_translation_is_said(
    due: Catalog, message: str, context: str | None, string: str | tuple[str, ...], said: str
) -> None:
    catalog = german()
    found(catalog, message, context).string = string
    first, *_ = find_faults("de", catalog, due)
    assert said in first and f"“{message}”" in first


def test_a_source_that_changed_is_noticed(due: Catalog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changed = tuple("row number {n}" if phrase == "row {n}" else phrase for phrase in translatable_phrases.PHRASES)
    monkeypatch.setattr(collect_messages, "PHRASES", changed)
    now = collect_catalog()
    new, gone = find_faults("de", german(), now)
    assert "not in de.po" in new and "“row number {n}”" in new and "no message any more" in gone and "“row {n}”" in gone
    again = merge_messages(LOCALE / "de.po", now)
    (fuzzy,) = find_faults("de", again, now)
    assert "fuzzy" in fuzzy and "“row number {n}”" in fuzzy
    path = tmp_path / "de.po"
    path.write_text(write_po_text(again), encoding="utf-8")
    assert write_po_text(merge_messages(path, now)) == write_po_text(again)
    assert read_catalogue(path).translate_phrase("row number 2") == "row number 2", "what is fuzzy is shown in English"


ACCENTS = str.maketrans("eouEOU", "éóúÉÓÚ")
PLAIN = str.maketrans("éóúÉÓÚ", "eouEOU")
WORDLESS = re.compile(rf"{PIECES.pattern}|\*\*[A-H]+\.?\*\*", re.DOTALL)
"""Texts without words of a language: formulas, code, and the letters of options."""
KEPT = re.compile(r"(\$\$.*?\$\$|\$[^$]*\$|`[^`]*`|%\(\w+\)s|\{[\w-]+\})", re.DOTALL)


def accented(text: str) -> str:
    """Return text with accents outside of formulas, code and what is filled in."""
    return "".join(piece if i % 2 else piece.translate(ACCENTS) for i, piece in enumerate(KEPT.split(text)))


SOME = ("planar-2r", "scara", "elbow-3r", "wrist-zyz")


@pytest.fixture
def scratch(due: Catalog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A language `eo` of which there is a file and a line in LANGUAGES, and nothing else."""
    monkeypatch.setattr(languages, "LOCALE", tmp_path)
    monkeypatch.setitem(LANGUAGES, "eo", "Scratch")
    made = merge_messages(tmp_path / "eo.po", due)
    for message in made:
        if message.id and message.context != "decimal sign":
            one = message.id
            message.string = accented(one) if isinstance(one, str) else tuple(map(accented, one))
    for name in translatable_phrases.ARMS:
        in_sentence = load_catalogue("en").translate_arm_in_sentence(name)
        found(made, name, languages.ARM_IN_SENTENCE).string = accented(in_sentence)
    found(made, ".", "decimal sign").string = "."
    (tmp_path / "eo.po").write_text(write_po_text(made), encoding="utf-8")
    yield "eo"
    load_catalogue.cache_clear()
    make_environment.cache_clear()


@pytest.mark.parametrize("family", select_for_suite(("planar-2r", "scara"), SOME))
def test_all_words_of_a_problem_are_messages(scratch: str, family: str) -> None:
    problems = [replace(get_problem(family, 0), parts=tuple(select_parts(get_problem(family, 0))))]
    if family not in select_for_suite(("scara",), ()):
        problems.append(generate(ProblemId(family, 1, select_quiz_questions(family))))
    for one in problems:
        for name, english, own in both(one, scratch):
            assert own.translate(PLAIN) == english, (one.id, name)
            assert WORDLESS.sub("", own) == WORDLESS.sub("", english).translate(ACCENTS), (one.id, name)


def test_a_new_language_is_whole_from_problem_to_site(scratch: str, due: Catalog) -> None:
    problem = generate("planar-2r/7@chapter", ["jacobian", "singularity-type"])
    record = make_site_record(problem)
    own = translate_record(problem, record, scratch)
    assert own["title"] == accented(record["title"])
    assert [row[1:] for row in own["said"]] == [[accented(text) for text in row[1:]] for row in record["said"]]
    titles = json.loads(make_titles_json(scratch, [("scara", FAMILIES["scara"].title, "")]))
    assert titles["families"] == {"scara": accented(FAMILIES["scara"].title)}
    texts = json.loads(write_site_texts(scratch, load_catalogue(scratch)))
    assert texts == {key: accented(text) for key, text in load_site_texts().items()}
    assert find_faults(scratch, open_catalog(languages.LOCALE / f"{scratch}.po"), due) == []


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_sentences_on_mistakes_are_found_again_in_the_language(language: str) -> None:
    for name, kind in CATALOGUE.items():
        fields = re.findall(r"\{(\w+)\}", kind.message)
        words = {field: str(number) for number, field in enumerate(dict.fromkeys(fields), 1)}
        catalogue, english = load_catalogue(language), kind.format_message(words)
        own = catalogue.translate_mistake_sentence(kind.name, kind.message, kind.chapter_reference, english)
        says = catalogue.translations.pgettext(name_mistake_context(name), kind.message)
        assert says != kind.message and own.startswith(says.format(**words)), name
        assert not LEFT.findall(own), own


def test_decimals_are_german_in_formulas_and_nowhere_else() -> None:
    german = load_catalogue("de").localize_formulas
    assert german(r"$a = 0.5\,\text{m}$ (6.12) `0.5`") == r"$a = 0{,}5\,\text{m}$ (6.12) `0.5`"
    assert german("$(0.5, 1)$ and $(x, y)$") == "$(0{,}5; 1)$ and $(x, y)$"
    assert german("$T_z(0.5)\\, R_x$ $$a = 1.5, \\qquad b$$") == "$T_z(0{,}5)\\, R_x$ $$a = 1{,}5, \\qquad b$$"
    assert load_catalogue("de").translate_phrase("within 0.01 rad/s") == "auf 0,01 rad/s genau"


def test_a_mistake_without_optional_words_is_translated() -> None:
    mistake, every = CATALOGUE["shoulder-missed"], "Set every factor of det J to zero"
    sentence = mistake.format_message({"instead": "", "every": every})
    assert load_catalogue("de").translate_mistake_sentence(mistake.name, mistake.message, "(6.8)", sentence) == (
        "Anscheinend hast du eine Bedingung vergessen, die mehrere Gelenke verknüpft. "
        "Setze jeden Faktor von det J gleich null. Siehe (6.8)."
    )


def test_an_arm_or_a_phrase_that_nobody_translated_is_shown_as_it_is() -> None:
    words, own = load_catalogue("de"), "The one in our lab"
    assert words.translate_arm_title(own) == own and words.translate_arm_in_sentence(own) == f"den Arm „{own}“"
    assert words.translate_phrase("no such phrase") == "no such phrase"
    assert words.translate_arm_in_sentence("RPRR arm") == "einen RPRR-Arm"
    assert make_phrase_pattern("{a} for {a}").fullmatch("x for y") is None
    titles = [("scara", FAMILIES["scara"].title, ""), ("elbow", own, ""), ("p1", "First place", "")]
    assert json.loads(make_titles_json("de", titles))["families"] == {"scara": "SCARA-Arm (RRPR)"}


def test_a_translated_record_fits_its_problem_and_holds_nothing_of_the_key() -> None:
    problem = generate(ProblemId("planar-2r", 7, ("jacobian", "rank", "singularity-type")))
    record = make_site_record(problem)
    own, solved = translate_record(problem, record, "de"), translate_solutions(problem, "de")
    names = [part["name"] for part in record["parts"]]
    assert [part["name"] for part in own["parts"]] == [part["name"] for part in solved["parts"]] == names
    for row, english in zip(own["said"], record["said"], strict=True):
        assert row[0] == english[0] and row[1] != english[1]
    for part, english in zip(own["parts"], record["parts"], strict=True):
        assert len(part["hints"]) == 3 and (part["options"] is None) == (english["options"] is None)
        assert set(part) == {"name", "title", "prompt", "hints", "options"}
