"""Levels of feedback: no right value below "values", no counterexample below "counterexample"."""

import re
from dataclasses import replace

import pytest

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS
from qdot.exercises.formula.equality import Certificate, Counterexample, EntryDifference, SetDifference
from qdot.exercises.problem.problem import Part
from qdot.grader.grading.attempt import make_part_result
from qdot.grader.grading.result import PartResult
from qdot.grader.judging.formulas import format_value
from qdot.grader.marking.marking import WRONG_OR_PARTIAL, mark
from qdot.grader.reports.feedback_levels import limit_feedback
from tests.support import read_cases, results
from tests.support.problems import get_problem, select_parts
from tests.support.suites import FEW, WHOLE, on_families


def make_wrong_answer(part: Part, joint: str) -> str:
    """Return a readable wrong answer."""
    if part.answer.offered_options:
        return ""
    rows, columns = part.shape or (1, 1)
    entry = "1.23456" if part.answer.is_numeric else f"1.23456*sin({joint}) + {joint}"
    if part.answer.is_set:
        return f"[{joint} = 0.7, {joint} = 1.9]"
    listed = [", ".join([entry] * columns)] * rows
    if rows * columns == 1:
        return entry
    return f"[{', '.join(listed if columns == 1 else [f'[{row}]' for row in listed])}]"


def mark_wrong_answers(family: str) -> list[PartResult]:
    problem = get_problem(family, 0)
    problem = replace(problem, parts=tuple(select_parts(problem)))
    answers = {part.name: make_wrong_answer(part, problem.chain.q[-1].name) for part in problem.parts}
    verdicts = mark(problem, {name: text for name, text in answers.items() if text}, secret="s")
    part_results = [make_part_result("p1", verdict) for verdict in verdicts]
    return [part for part in part_results if part.outcome in WRONG_OR_PARTIAL and part.certificate is not None]


def get_counterexample(part: PartResult) -> Counterexample:
    assert part.certificate is not None and part.certificate.counterexample is not None
    return part.certificate.counterexample


@on_families(FEW)
def test_each_level_hides_what_higher_levels_show(family: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if not WHOLE:  # because that takes most of the time
        monkeypatch.setattr("qdot.grader.marking.marking.diagnose", lambda *_: None)
    parts = mark_wrong_answers(family)
    assert parts
    for part in parts:
        assert limit_feedback(part, "values") == limit_feedback(part, "solutions") == part
        assert_no_right_value_below_values(part)
        assert_no_numbers_below_counterexamples(part)


def assert_no_right_value_below_values(part: PartResult) -> None:
    example, limited = get_counterexample(part), limit_feedback(part, "counterexample")
    limited_example = get_counterexample(limited)
    if isinstance(example, SetDifference):
        assert isinstance(limited_example, SetDifference) and limited_example.missing is None
        assert not re.search(r"is missing: ", limited.reason), limited.reason
        return
    assert isinstance(limited_example, EntryDifference) and limited_example.expected is None
    assert not re.search(r"expected [-(\d]|, and .* is right", limited.reason), limited.reason
    right = format_value(example.expected)
    if len(right) > 4 and right not in format_value(example.yours) and right not in str(example.at):
        assert right not in limited.reason, limited.reason


def assert_no_numbers_below_counterexamples(part: PartResult) -> None:
    limited = limit_feedback(part, "mistake")
    assert limited.certificate is not None and limited.certificate.counterexample is None
    assert not re.search(r"[a-z]\w* = -?\d|yours|expected", limited.reason.split("; it follows")[0]), limited.reason
    assert (limited.mistake, limited.entries) == (part.mistake, part.entries)
    least = limit_feedback(part, "outcome")
    assert (least.reason, least.mistake, least.advice, least.entries) == ("", None, None, None)


@pytest.mark.parametrize("level", FEEDBACK_LEVELS)
def test_unreadable_and_right_answers_are_reported_at_every_level(level: str) -> None:
    problem = get_problem("planar-2r", 0)
    problem = replace(problem, parts=(problem["position"], problem["jacobian"]))
    verdicts = mark(problem, {"position": "a1 +", "jacobian": problem["jacobian"].answer.write_code()}, secret="s")
    for verdict in verdicts:
        assert limit_feedback(make_part_result("p1", verdict), level) == make_part_result("p1", verdict)
    assert "couldn't parse" in limit_feedback(make_part_result("p1", verdicts[0]), level).reason


@pytest.mark.parametrize(("reason", "level", "expected"), read_cases("answers")["limited_reasons"])
def test_a_limited_reason_is_still_a_sentence(reason: str, level: str, expected: str) -> None:
    wrong = results.make_part("position", "wrong", 1.0, reason=reason, certificate=Certificate("exact", 1))
    assert limit_feedback(wrong, level).reason == expected


def test_a_wrong_shape_names_no_mistake_at_the_lowest_level() -> None:
    wrong = results.make_part("jacobian", "wrong", 1.0, reason="2 x 6, and 6 x 2 is due (transposed?)")
    assert limit_feedback(wrong, "outcome").reason == "2 x 6, and 6 x 2 is due"
    assert "transposed" in limit_feedback(wrong, "mistake").reason
