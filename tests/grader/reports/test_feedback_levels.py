"""What a level of feedback keeps back: no right value below "values", no counterexample below "counterexample"."""

import re
from dataclasses import replace

import pytest

from qdot.exercises.assignment.assignment import FEEDBACK
from qdot.exercises.formula.equality import Certificate, Counterexample, EntryDifference, SetDifference
from qdot.exercises.problem.problem import Part
from qdot.grader.grading.attempt import make_part_result
from qdot.grader.grading.result import PartResult
from qdot.grader.judging.formulas import format_value
from qdot.grader.marking.marking import WRONG_OR_PARTIAL, mark
from qdot.grader.reports.feedback_levels import limit_feedback
from tests.support import results
from tests.support.problems import get_problem, select_parts
from tests.support.suites import WHOLE, few_families


def wrong_answer(part: Part, joint: str) -> str:
    """Return an answer that can be read and is wrong."""
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


def wrong_parts(family: str) -> list[PartResult]:
    problem = get_problem(family, 0)
    problem = replace(problem, parts=tuple(select_parts(problem)))
    answers = {part.name: wrong_answer(part, problem.chain.q[-1].name) for part in problem.parts}
    verdicts = mark(problem, {name: text for name, text in answers.items() if text}, secret="s")
    made = [make_part_result("p1", verdict) for verdict in verdicts]
    return [part for part in made if part.outcome in WRONG_OR_PARTIAL and part.certificate is not None]


def example_of(part: PartResult) -> Counterexample:
    assert part.certificate is not None and part.certificate.counterexample is not None
    return part.certificate.counterexample


@few_families
def test_every_level_keeps_back_what_is_above_it(family: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The mistakes behind answers, which take most of the time, are looked for in one family."""
    if not WHOLE and family != "planar-2r":
        monkeypatch.setattr("qdot.grader.marking.marking.diagnose", lambda *_: None)
    parts = wrong_parts(family)
    assert parts
    for part in parts:
        assert limit_feedback(part, "values") == limit_feedback(part, "solutions") == part
        nothing_right_is_told_below_values(part)
        no_numbers_are_told_below_counterexamples(part)


def nothing_right_is_told_below_values(part: PartResult) -> None:
    example, seen = example_of(part), limit_feedback(part, "counterexample")
    held_back = example_of(seen)
    if isinstance(example, SetDifference):
        assert isinstance(held_back, SetDifference) and held_back.missing is None
        assert not re.search(r"is missing: ", seen.reason), seen.reason
        return
    assert isinstance(held_back, EntryDifference) and held_back.expected is None
    assert not re.search(r"expected [-(\d]|, and .* is right", seen.reason), seen.reason
    right = format_value(example.expected)
    if len(right) > 4 and right not in format_value(example.yours) and right not in str(example.at):
        assert right not in seen.reason, seen.reason


def no_numbers_are_told_below_counterexamples(part: PartResult) -> None:
    seen = limit_feedback(part, "mistake")
    assert seen.certificate is not None and seen.certificate.counterexample is None
    assert not re.search(r"[a-z]\w* = -?\d|yours|expected", seen.reason.split("; it follows")[0]), seen.reason
    assert (seen.mistake, seen.entries) == (part.mistake, part.entries)
    least = limit_feedback(part, "outcome")
    assert (least.reason, least.mistake, least.advice, least.entries) == ("", None, None, None)


@pytest.mark.parametrize("level", FEEDBACK)
def test_what_could_not_be_read_and_what_is_right_is_told_at_every_level(level: str) -> None:
    problem = get_problem("planar-2r", 0)
    problem = replace(problem, parts=(problem["position"], problem["jacobian"]))
    verdicts = mark(problem, {"position": "a1 +", "jacobian": problem["jacobian"].answer.write_code()}, secret="s")
    for verdict in verdicts:
        assert limit_feedback(make_part_result("p1", verdict), level) == make_part_result("p1", verdict)
    assert "couldn't parse" in limit_feedback(make_part_result("p1", verdicts[0]), level).reason


@pytest.mark.parametrize(
    ("reason", "level", "left"),
    [
        ("differs at theta1 = 0.5: yours 1, expected 2", "mistake", "your answer is wrong"),
        ("right but for its sign, which earns 4/5; differs at a1 = 2: yours 4, expected -4", "mistake",
         "right but for its sign, which earns 4/5"),
        ("1 only in part; this configuration is not singular: theta2 = 0.5", "mistake",
         "1 only in part; your answer includes a configuration that is not singular"),
        ("correct except for rounding: theta2 = 3.14; write the exact value, such as pi/3", "mistake",
         "correct except for rounding; write the exact value, such as pi/3"),
        ("a singular configuration is missing: theta2 = 0.5, a1 = 2; this configuration is not singular: theta2 = 1",
         "counterexample", "a singular configuration is missing; this configuration is not singular: theta2 = 1"),
    ],
)  # fmt: skip
def test_what_is_left_of_a_reason_is_a_sentence(reason: str, level: str, left: str) -> None:
    wrong = results.make_part("position", "wrong", 1.0, reason=reason, certificate=Certificate("exact", 1))
    assert limit_feedback(wrong, level).reason == left


def test_a_shape_that_is_not_read_names_no_mistake_at_the_lowest_level() -> None:
    wrong = results.make_part("jacobian", "wrong", 1.0, reason="2 x 6, and 6 x 2 is due (transposed?)")
    assert limit_feedback(wrong, "outcome").reason == "2 x 6, and 6 x 2 is due"
    assert "transposed" in limit_feedback(wrong, "mistake").reason
