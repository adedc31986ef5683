"""Short questions: every option right or wrong as it is said, none that stands out, a verdict for whatever is typed.

Small arms are asked each of them, families some in turn; a snapshot holds what the first arms are asked.
"""

import json
import os
import re
from collections import Counter
from dataclasses import replace
from functools import cache
from itertools import islice
from typing import Any

import pytest

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.figure.arm_figure import describe_part_figure, draw_part_svg
from qdot.exercises.generation import generate, list_applicable_questions, sample_chain, select_quiz_questions
from qdot.exercises.notebook.notebook import NotebookContent, make_solution_notebook, make_student_notebook
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.reference_answers import TRUE_FALSE, Choice, Matching, Number, Selection
from qdot.exercises.short_questions import ALL_QUESTIONS, SHORT_QUESTIONS
from qdot.exercises.short_questions.option_mistakes import explain_options
from qdot.exercises.short_questions.options import ConfigurationOptions
from qdot.exercises.verify.certificate import certify
from qdot.exercises.writing.problem_texts import write_hints, write_option, write_prompt, write_solution
from qdot.grader.grading.certify import find_failures
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from tests.exercises.writing.test_problem_texts import _is_clean
from tests.support import SNAPSHOTS
from tests.support.judging import diagnose, judge_matching, judge_selection
from tests.support.problems import choose_convention, replace_answer
from tests.support.suites import few_or_all_families, sample_for_suite, select_for_suite

QUIZ_SNAPSHOTS = SNAPSHOTS / "quizzes"
UPDATED = os.environ.get("QDOT_UPDATE_SNAPSHOTS") == "1"
SNAPPED = ("planar-2r", "elbow", "wrist-zyz", "scara")
NAMES, FAMILY_NAMES = list(SHORT_QUESTIONS), list(FAMILIES)
EACH = select_for_suite(1, 4)
"""Short questions that each family is asked; in `make whole` every one of them has its turn over all families."""
SMALL = ("polar-rp", "planar-pr", "elbow")
"""Families of which the first that can be asked a short question is asked it."""
LONG = ("stanford-6r", "lbr-7r", "ur-6r", "puma-560", "anthropomorphic-6r", "industrial-6r", "scorbot-tip")
small = pytest.mark.xdist_group("quizzes")  # the problems of these tests are made once


def asked_in_turn(family: str) -> list[str]:
    first = 4 * FAMILY_NAMES.index(family)
    names = (NAMES[(first + 7 * k) % len(NAMES)] for k in range(len(NAMES)))
    can = (name for name in names if SHORT_QUESTIONS[name].find_obstacle(sample_chain(_id(family, 0, name))) is None)
    return list(islice(can, EACH if family not in LONG else 1))


def _id(family: str, seed: int, name: str) -> ProblemId:
    return ProblemId(family, seed, (name,), convention=choose_convention(SHORT_QUESTIONS[name]))


@cache
def problem_of(family: str, seed: int, name: str) -> Problem:
    return generate(_id(family, seed, name))


def of_small(name: str, seed: int = 1) -> Problem:
    """Return a problem of one short question, of the first of SMALL that can be asked it."""
    can = (
        family for family in SMALL if SHORT_QUESTIONS[name].find_obstacle(sample_chain(_id(family, 1, name))) is None
    )
    return problem_of(next(can), seed, name)


@few_or_all_families
def test_short_questions_pass_their_certificate_and_are_marked(family: str) -> None:
    names = asked_in_turn(family)
    assert names
    for name in names:
        _is_certified_and_marked(problem_of(family, 0, name))


@small
@pytest.mark.parametrize("name", sample_for_suite(NAMES, 8))
def test_each_short_question_passes_its_certificate_which_fails_for_other_options_and_is_marked(name: str) -> None:
    problem = of_small(name)
    _is_certified_and_marked(problem)
    for other in _others(problem.parts[0].answer):
        assert not certify(replace_answer(problem, other)).passed


def _is_certified_and_marked(problem: Problem) -> None:
    (part,) = problem.parts
    assert find_failures(problem) == [], part.name
    assert judge(problem, part, part.answer.as_typed(), "seed").outcome is Outcome.CORRECT, part.name
    _is_clean(write_prompt(problem, part))
    _is_clean(write_solution(problem, part))
    _hints_help_and_give_nothing_away(problem, part)
    _wrong_letters_are_wrong(problem, part)
    _options_have_one_form(problem, part)


def _options_have_one_form(problem: Problem, part: Part) -> None:
    """No option has a clause that others lack, or a value to more digits: who looks at no arm can't tell it by that."""
    if not isinstance(part.answer, Choice | Selection) or part.answer.options == TRUE_FALSE:
        return
    texts = [write_option(problem, part, index) for index in range(len(part.answer.options))]
    for clause in (r"\([^()$]*\b[a-z]{3,}", r"[:,;] [^$]*\b(?!or|with)[a-z]{3,}|, with ", r"rounded"):
        found = [bool(re.search(clause, re.sub(r"\$[^$]*\$", "$$", text))) for text in texts]
        assert len(set(found)) == 1, (part.name, clause, texts)
    assert not any("matrix" in text and not re.search(r"&|\\\\", text) for text in texts), texts  # one number is none
    if isinstance(part.details, ConfigurationOptions):
        forms = {tuple(len(number) for number in re.findall(r"\.(\d+)\^", text)) for text in texts}
        assert len(forms) == 1, (part.name, texts)


def _hints_help_and_give_nothing_away(problem: Problem, part: Part) -> None:
    given = write_hints(problem, part)
    assert len(set(given)) == 3 and all(len(hint) > 30 for hint in given), part.name
    if part.kind == "determinant-choice":  # as most options are there
        assert "$$\n0\n$$" not in given[-1], part.name
    for hint in given:
        _is_clean(hint)
        assert not re.search(r"\*\*|  \w|\(\)", hint), (part.name, hint)
        assert hint.strip().endswith((".", "?", ":", "$$")), (part.name, hint)
        if isinstance(part.answer, Choice) and part.answer.options != TRUE_FALSE:
            assert part.answer.options[part.answer.correct] not in hint


def _wrong_letters_are_wrong(problem: Problem, part: Part) -> None:
    answer = part.answer
    if isinstance(answer, Choice):
        for index in range(len(answer.options)):
            if index != answer.correct:
                letter = "ABCDEFGH"[index]
                assert judge(problem, part, letter, "seed").outcome is Outcome.WRONG
                named = diagnose(problem, part, letter, "seed")
                blames = explain_options(problem, part, Stream("seed"))[index]
                assert (named.mistakes if named else ()) == tuple(dict.fromkeys(blame.mistake for blame in blames))
    if isinstance(answer, Selection):
        everything = "ABCDEFGH"[: len(answer.options)]
        if len(answer.correct) < len(answer.options):
            assert judge(problem, part, everything, "seed").share == 0
        for letter in answer.letters:
            found = judge(problem, part, letter, "seed")
            assert found.outcome is (Outcome.CORRECT if len(answer.correct) == 1 else Outcome.PARTIAL)
    if isinstance(answer, Matching):
        turned = answer.letters[1:] + answer.letters[0]
        assert judge(problem, part, turned, "seed").outcome is Outcome.WRONG


def _others(answer: Any) -> list[Any]:
    if isinstance(answer, Choice):
        return [replace(answer, correct=index) for index in range(len(answer.options)) if index != answer.correct]
    if isinstance(answer, Selection):
        more = sorted({*answer.correct, *range(len(answer.options))})
        left = {tuple(more), answer.correct[:-1]} - {answer.correct}
        return [replace(answer, correct=correct) for correct in left]
    if isinstance(answer, Matching):
        return [replace(answer, correct=(*answer.correct[1:], answer.correct[0]))]
    assert isinstance(answer, Number)
    return [replace(answer, reference=-answer.reference), replace(answer, reference=1.02 * answer.reference)]


@pytest.mark.whole
def test_nothing_about_the_right_option_stands_out() -> None:
    """Always choosing the longest, shortest or most ordinary option is right only by chance."""
    hits, count = Counter[str](), 0
    for family in select_for_suite(("planar-2r", "planar-prr", "spherical"),
                          ("planar-2r", "elbow", "planar-prr", "cylindrical", "spherical")):  # fmt: skip
        for name in ("position-choice", "column-choice", "vector-choice"):
            for seed in range(select_for_suite(3, 5)):
                part = problem_of(family, seed, name).parts[0]
                texts, right = list(part.answer_as(Choice).options), part.answer_as(Choice).correct
                lengths = [len(text) for text in texts]
                hits["longest"] += lengths.index(max(lengths)) == right
                hits["shortest"] += lengths.index(min(lengths)) == right
                hits["most in common"] += _most_ordinary(texts) == right
                hits["first"] += right == 0
                count += 1
    assert all(0.08 < hit / count < 0.45 for hit in hits.values()), (hits, count)


def _most_ordinary(texts: list[str]) -> int:
    """Return the option whose pieces are found in most of the others."""
    pieces = [Counter(text.replace("(", " ").replace(",", " ").split()) for text in texts]
    scores = [sum(((a & b).total()) for b in pieces) / a.total() for a in pieces]
    return scores.index(max(scores))


@pytest.mark.parametrize(
    ("typed", "share"),
    [
        ("AC", 1), ("ca", 1), ("A, C", 1), ("['A', 'C']", 1), ("{'C', 'A'}", 1), ("A and C", 1), ('"AC"', 1),
        ("ＡＣ", 1), ("A\u200bC", 1), ("A\nC", 1),
        ("A", 0.5), ("AB", 0.5 - 1 / 3), ("ABC", 1 - 1 / 3), ("ABCDE", 0), ("B", 0), ("AACC", 1),
        ("AX", 0), ("theta2 = 0", 0), ("A" * 200, 0.5), ("A" * 5000, 0), ("((((", 0),
    ],
)  # fmt: skip
def test_letters_are_marked_one_by_one(typed: str, share: float) -> None:
    assert judge_selection(typed, 5, (0, 2)).share == pytest.approx(share, abs=1e-3)


@pytest.mark.parametrize(
    ("typed", "share"),
    [
        ("BAC", 1), ("b, a, c", 1), ("['B', 'A', 'C']", 1), ("{1: 'B', 2: 'A', 3: 'C'}", 1), ("1-B, 2-A, 3-C", 1),
        ("1: B\n2: A\n3: C", 1), ("joint 1 is B, joint 2 is A, joint 3 is C", 1),
        ("ABC", 1 / 3), ("BA", 0), ("BACD", 0), ("CBA", 0), ("BBB", 0), ("x", 0),
    ],
)  # fmt: skip
def test_matches_are_marked_one_by_one(typed: str, share: float) -> None:
    items = ("joint 1", "joint 2", "joint 3")
    assert judge_matching(typed, items, 4, (1, 0, 2)).share == pytest.approx(share, abs=1e-3)


def test_nothing_typed_is_missing() -> None:
    for typed in ("", "blank", "None", '"blank"'):
        assert judge_selection(typed, 4, (0,)).outcome is Outcome.MISSING, typed
        assert judge_matching(typed, ("joint 1", "joint 2"), 2, (1, 0)).outcome is Outcome.MISSING, typed


def test_true_is_read_in_any_form() -> None:
    problems = (problem_of("elbow", seed, "true-or-false") for seed in range(20))
    problem = next(problem for problem in problems if problem.parts[0].answer == Choice(TRUE_FALSE, 0))
    for typed in ("true", "True", '"true"', "T", "A"):
        assert judge(problem, problem.parts[0], typed, "seed").outcome is Outcome.CORRECT, typed


@small
def test_forms_of_questions_are_the_ones_that_platforms_have() -> None:
    types = {"choice": Choice, "selection": Selection, "matching": Matching, "number": Number, "true or false": Choice}
    assert {question.form for question in SHORT_QUESTIONS.values()} == set(types)
    for name, question in SHORT_QUESTIONS.items():
        assert isinstance(of_small(name).parts[0].answer, types[question.form])


def test_a_quiz_asks_each_form_once() -> None:
    for family in select_for_suite(("planar-2r", "wrist-zyz"), ("planar-2r", "scara", "wrist-zyz")):
        names = select_quiz_questions(family)
        assert 4 <= len(names) == len({SHORT_QUESTIONS[name].form for name in names})
        assert [part.name for part in generate(ProblemId(family, 3, names)).parts] == list(names)


def test_short_questions_are_not_among_all_that_apply() -> None:
    arm = sample_chain(ProblemId("planar-2r", 1))
    assert not set(list_applicable_questions(arm)) & set(SHORT_QUESTIONS)
    assert list_applicable_questions(arm, SHORT_QUESTIONS)


def test_an_answer_is_not_shown_beside_the_question() -> None:
    for name, shown in (
        (name, shown) for name, question in SHORT_QUESTIONS.items() for shown in question.shown_answers
    ):
        assert shown in ALL_QUESTIONS
        with pytest.raises(QdotError, match=rf"'{name}' .*'{shown}'"):
            generate(ProblemId("planar-2r", 1, (name, shown)))


@small
@pytest.mark.parametrize("family", select_for_suite(SNAPPED if UPDATED else SNAPPED[:1], SNAPPED))
def test_what_an_id_is_asked_has_not_changed(family: str) -> None:
    path = QUIZ_SNAPSHOTS / f"{family}.json"
    names = list(list_applicable_questions(sample_chain(ProblemId(family, 1)), SHORT_QUESTIONS))
    if not UPDATED:
        stored = json.loads(path.read_text(encoding="utf-8"))
        assert set(stored) == {f"1/{name}" for name in names}
    found = {f"1/{name}": compute_digests(problem_of(family, 1, name)).parts[name][:16] for name in names}
    if UPDATED:
        QUIZ_SNAPSHOTS.mkdir(exist_ok=True)
        path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    else:
        assert found == {name: stored[name] for name in found}


def test_notebooks_hold_drawings_to_choose_from() -> None:
    problem = generate(ProblemId("elbow", 2, ("singular-drawing", "true-or-false", "singular-configurations")))
    for made in (make_student_notebook, make_solution_notebook):
        cells = made(NotebookContent("Quiz", "quiz", "ada", [("p1", problem)])).cells
        (drawing,) = [cell.source for cell in cells if "data:image/svg+xml" in cell.source and "A: " in cell.source]
        assert "theta1 = " in drawing
    assert len([cell for cell in cells if cell.metadata.get("qdot")]) == 3
    part = problem.parts[0]
    svg = draw_part_svg(problem.chain, part, "p1")
    assert all(f">{letter}</text>" in svg for letter in "ABCD")
    assert describe_part_figure(problem.chain, part).count("theta1") == 4


@pytest.mark.whole  # an arm whose texts are long; short ones are among those of each short question
def test_columns_are_asked_of_every_arm_of_which_they_are_asked_at_all() -> None:
    """With numbers and offsets columns are longer texts; how long they may be is looked at without."""
    plain = sample_chain(ProblemId("orthogonal-3r", 0, variation="chapter"))
    assert ALL_QUESTIONS["match-columns"].find_objection(plain) is None
    answer = problem_of("orthogonal-3r", 0, "match-columns").parts[0].answer
    assert isinstance(answer, Matching) and len(answer.items) == 3
