"""Problems in other languages: everything that is registered has its words, and the same formulas stand in them."""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import pytest

from exercises.answers import Choice, Matching, Selection
from exercises.families import FAMILIES
from exercises.generation import generate, short_quiz
from exercises.languages import LANGUAGES, pattern
from exercises.mistakes.catalogue import CATALOGUE
from exercises.problem import Part, Problem, ProblemId
from exercises.quizzes import ASKED
from exercises.render import catalogue, template_folder
from exercises.site.bank import titles_text
from exercises.site.record import site_record, translated_record, translated_solutions
from exercises.writing.statement import hints, option_text, prompt, statement, worked_solution
from tests.support.problems import parts_in_turn
from tests.support.suites import few_families, several

LEFT = re.compile(
    r"\b(the|and|of|is|are|with|joints?|axis|axes|which|that|to|by|from|revolute|prismatic|or|as|row|column|arm's"
    r"|singularity|lie|one|two|three|each|moves?|turned|radians|typed)\b"
)
"""English words that no German text has; those of a third language may have others."""

ASKED_A_QUIZ = several(("planar-2r", "wrist-zyz"), tuple(name for name in FAMILIES if not FAMILIES[name].varied))
PIECES = re.compile(r"\$\$.*?\$\$|\$[^$]*\$|`[^`]*`", re.DOTALL)


def pieces(text: str) -> Counter[str]:
    """Return the formulas and the code in a text, decimals with points."""
    found = (re.sub(r"\s+", " ", piece) for piece in PIECES.findall(text))
    plain = (re.sub(r"\\text\{[^}]*[a-zäöü]{4,}[^}]*\}", "", piece) for piece in found)  # words in a formula
    return Counter(piece.replace("{,}", ".").replace("; ", ", ") for piece in plain)


def both(problem: Problem, language: str) -> Iterator[tuple[str, str, str]]:
    """Yield every text of a problem: what it is, in English, and in a language."""
    yield "statement", statement(problem, ""), statement(problem, "", language=language)
    for part in problem.parts:
        yield f"{part.name}: prompt", prompt(problem, part), prompt(problem, part, language)
        yield f"{part.name}: solution", worked_solution(problem, part), worked_solution(problem, part, language)
        told = zip(hints(problem, part), hints(problem, part, language), strict=True)
        for number, (english, own) in enumerate(told, 1):
            yield f"{part.name}: hint {number}", english, own
        for index in range(options_of(part)):
            own = option_text(problem, part, index, language)
            yield f"{part.name}: option {index}", option_text(problem, part, index), own


def options_of(part: Part) -> int:
    return len(part.answer.options) if isinstance(part.answer, (Choice, Selection, Matching)) else 0


@pytest.mark.parametrize("language", LANGUAGES)
@few_families
def test_the_texts_of_a_family_hold_the_same_formulas_and_no_english(
    language: str, family: str, drawn: Callable[[str, int], Problem]
) -> None:
    problem = drawn(family, 0)
    problems = [replace(problem, parts=tuple(parts_in_turn(problem)))]
    if family in ASKED_A_QUIZ:
        problems.append(generate(ProblemId(family, 1, short_quiz(family))))
    for problem in problems:
        for name, english, own in both(problem, language):
            assert pieces(own) == pieces(english), (problem.id, name)
            assert not LEFT.findall(PIECES.sub(" ", own)), (problem.id, name, own)
            assert PIECES.sub("", own).strip() != PIECES.sub("", english).strip() or not re.search(
                r"[a-z]{3}", PIECES.sub("", english)
            ), (problem.id, name)
        assert catalogue(language).arm_title(problem.chain.title) != problem.chain.title


@pytest.mark.parametrize("language", LANGUAGES)
def test_everything_that_is_registered_has_its_words(language: str) -> None:
    words = catalogue(language)
    assert set(words.families) == set(FAMILIES)
    assert set(words.questions) == set(ASKED)
    assert set(words.mistakes) == set(CATALOGUE)
    sources = {mistake.source for mistake in CATALOGUE.values()}
    assert {source for source in sources if not re.fullmatch(r"\d+\.\d+", source)} == set(words.sources)
    own, english = template_folder() / language, template_folder()
    assert {path.name for path in (own / "questions").iterdir()} == {
        path.name for path in (english / "questions").iterdir()
    }
    for name in ("statement.md.j2", "hint.md.j2", "solution.md.j2"):
        assert (own / name).is_file(), name


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_filled_in_is_filled_in_in_both(language: str) -> None:
    words = catalogue(language)
    rows: list[tuple[str, Sequence[str]]] = [(english, (own,)) for english, own in words.phrases.items()]
    rows += words.arms.items()
    rows += [(CATALOGUE[name].says, (own,)) for name, (_, own) in words.mistakes.items()]
    for english, owns in rows:
        for own in owns:
            assert set(re.findall(r"\{(\w*)\}", own)) == set(re.findall(r"\{(\w*)\}", english)), english
    assert "{where}" in words.see


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("mistake", CATALOGUE)
def test_the_sentence_on_a_mistake_is_found_again_in_the_language(language: str, mistake: str) -> None:
    found = CATALOGUE[mistake]
    names = re.findall(r"\{(\w+)\}", found.says)
    words = {name: str(number) for number, name in enumerate(dict.fromkeys(names), 1)}
    own = catalogue(language).mistake_said(found.name, found.says, found.source, found.sentence(words))
    assert own.startswith(catalogue(language).mistakes[found.name][1].format(**words))
    assert not LEFT.findall(own), own


def test_the_german_of_an_arm_reads_as_german() -> None:
    problem = generate(ProblemId("planar-2r", 7, ("jacobian", "jacobian-size")))
    text = statement(problem, "", language="de")
    assert "Die Abbildung zeigt einen ebenen 2R-Arm mit abgewinkeltem Werkzeug; sie ist nicht maßstäblich." in text
    assert "Der Arm hat zwei Gelenke: Beide sind Drehgelenke." in text
    assert prompt(problem, problem.parts[0], "de").startswith("Bestimme die Jacobi-Matrix $J$ von $P$ für die Aufgabe")


def test_decimals_are_german_in_formulas_and_nowhere_else() -> None:
    german = catalogue("de").with_decimals
    assert german(r"$a = 0.5\,\text{m}$ (6.12) `0.5`") == r"$a = 0{,}5\,\text{m}$ (6.12) `0.5`"
    assert german("$(0.5, 1)$ and $(x, y)$") == "$(0{,}5; 1)$ and $(x, y)$"
    assert german("$T_z(0.5)\\, R_x$ $$a = 1.5, \\qquad b$$") == "$T_z(0{,}5)\\, R_x$ $$a = 1{,}5, \\qquad b$$"
    assert catalogue("de").phrase("within 0.01 rad/s") == "auf 0,01 rad/s genau"


def test_an_arm_or_a_phrase_that_nobody_translated_is_shown_as_it_is() -> None:
    words = catalogue("de")
    assert words.arm_title("The one in our lab") == "The one in our lab"
    assert words.arm_shown("The one in our lab") == "den Arm „The one in our lab“"
    assert words.phrase("no such phrase") == "no such phrase"
    assert words.arm_shown("RPRR arm") == "einen RPRR-Arm"
    assert pattern("{a} for {a}").fullmatch("x for y") is None


def test_titles_of_places_stay_as_they_were_written() -> None:
    titles = [("scara", FAMILIES["scara"].title, ""), ("elbow", "The arm in our lab", ""), ("p1", "First place", "")]
    assert json.loads(titles_text("de", titles))["families"] == {"scara": "SCARA-Arm (RRPR)"}


def test_a_translated_record_fits_its_problem_and_holds_nothing_of_the_key() -> None:
    problem = generate(ProblemId("planar-2r", 7, ("jacobian", "rank", "singularity-type")))
    record = site_record(problem)
    own = translated_record(problem, record, "de")
    assert [part["name"] for part in own["parts"]] == [part["name"] for part in record["parts"]]
    assert [row[0] for row in own["said"]] == [row[0] for row in record["said"]]
    assert all(row[1] != english[1] for row, english in zip(own["said"], record["said"], strict=True))
    assert all("Siehe" in row[2] for row in own["said"])
    solved = translated_solutions(problem, "de")
    assert [part["name"] for part in solved["parts"]] == [part["name"] for part in record["parts"]]
    for part, english in zip(own["parts"], record["parts"], strict=True):
        assert len(part["hints"]) == 3 and (part["options"] is None) == (english["options"] is None)
        assert set(part) == {"name", "title", "prompt", "hints", "options"}
