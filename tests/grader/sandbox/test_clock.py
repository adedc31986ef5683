"""Time limits on judging: an answer that takes too long is interrupted and left ungraded; the others are graded."""

import json
import threading
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import mpmath
import pytest

from qdot import generate
from qdot.exercises.assignment.assignment import Student
from qdot.exercises.common.time_limit import OutOfTime, Watchdog, end_watchdog
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.grading.check import check_notebook
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.compare_command import compare_lines
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.judging.verdict import Judgement, Outcome
from qdot.grader.marking import marking
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.sandbox.time_budgets import Budget, TimeBudgets
from tests.support.submitting import (
    ALL_CORRECT,
    code_cell,
    grade,
    list_outcomes,
    make_class,
    make_correct_notebook,
    submit,
)
from tests.support.suites import sample_for_suite


def compute_forever() -> None:
    while True:
        try:
            with mpmath.workdps(80):
                sum(range(1000))
        except Exception:
            continue


def is_interrupted(budget: Budget) -> bool:
    try:
        with budget.spend():
            compute_forever()
    except OutOfTime:
        return True
    return False


def test_endless_computation_is_interrupted_in_any_thread() -> None:
    budget, start, precision = Budget(0.1), time.process_time(), mpmath.mp.prec
    assert is_interrupted(budget) and time.process_time() - start < 5
    assert mpmath.mp.prec == precision and budget.remaining_seconds <= 0
    thread_budget = Budget(0.1)
    thread = threading.Thread(target=is_interrupted, args=(thread_budget,), daemon=True)
    thread.start()
    thread.join(20)
    assert not thread.is_alive() and thread_budget.remaining_seconds <= 0
    with pytest.raises(OutOfTime), budget.spend():
        raise AssertionError("the budget is already spent")


def compute_until(is_finished: Callable[[], bool]) -> None:
    """Compute in a separate frame: what Python 3.13 raises at the end of a loop escapes a `try` around it."""
    while not is_finished():
        pass


class SlowDestructor:
    """An exception raised inside a destructor is lost, as it is inside a garbage-collector callback."""

    def __del__(self) -> None:
        until = time.process_time() + 0.2
        while time.process_time() < until:
            pass


@pytest.mark.filterwarnings("ignore:Exception ignored in:pytest.PytestUnraisableExceptionWarning")
def test_a_lost_interrupt_is_repeated() -> None:
    budget, start = Budget(0.1), time.process_time()
    with pytest.raises(OutOfTime), budget.spend():
        SlowDestructor()
        compute_until(lambda: time.process_time() > start + 5)
    assert budget.remaining_seconds <= 0


def test_ending_a_watchdog_survives_its_last_interrupt() -> None:
    exceptions = [OutOfTime, None]

    class LateWatchdog(Watchdog):
        def end(self) -> None:
            super().end()
            if exception := exceptions.pop(0):
                raise exception

    end_watchdog(LateWatchdog(60))
    assert not exceptions


def test_sleep_is_free_and_blocks_share_a_budget() -> None:
    budget = Budget(1.0)
    for _ in range(3):
        with budget.spend():
            time.sleep(0.05)
            sum(range(100_000))
    assert 0.5 < budget.remaining_seconds < 1.0
    time.sleep(0.1)


def test_no_interrupt_arrives_after_the_block() -> None:
    for _ in range(30):
        budget = Budget(0.002)
        try:
            with budget.spend():
                compute_until(lambda: time.process_time() % 0.01 < 0.002)
        except OutOfTime:
            continue
    for _ in range(1000):
        time.process_time()


@pytest.fixture(scope="module")
def polar() -> Problem:
    return generate("polar-rp/1", ["position", "determinant"])


WRONG_ANSWERS = {"position": "[d2, 1]", "determinant": "d2 + 0.7"}


def test_an_answer_that_takes_too_long_to_judge_is_ungraded(polar: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    def judge_slowly(problem: Problem, part: Part, answer: ParsedAnswer, seed: str) -> Judgement:
        if part.name == "determinant":
            compute_forever()
        return judge_parsed(problem, part, answer, seed)

    monkeypatch.setattr(marking, "judge_parsed", judge_slowly)
    position, determinant = mark(polar, WRONG_ANSWERS, secret="s", budgets=TimeBudgets(Budget(0.5)))
    assert position.judgement.outcome is Outcome.WRONG and position.points == 0
    assert determinant.judgement.outcome is Outcome.UNGRADED and determinant.points is None
    assert "takes more than 0.5 s of processor time" in determinant.judgement.reason
    assert determinant.judgement.over_limit and not position.judgement.over_limit


def test_running_out_of_time_for_follow_through_leaves_the_part_ungraded(
    polar: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(marking, "find_follow_through", lambda *_: compute_forever())
    _, determinant = mark(polar, WRONG_ANSWERS, secret="s", budgets=TimeBudgets(Budget(0.5)))
    assert determinant.judgement.outcome is Outcome.UNGRADED


def test_running_out_of_time_for_diagnosis_changes_no_mark(polar: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = mark(polar, WRONG_ANSWERS, secret="s")
    assert expected[1].diagnosis is not None
    monkeypatch.setattr(marking, "diagnose", lambda *_: compute_forever())
    verdicts = mark(polar, WRONG_ANSWERS, secret="s", budgets=TimeBudgets(diagnosing=Budget(0.2)))
    assert [verdict.diagnosis for verdict in verdicts] == [None, None]
    assert [(v.points, v.judgement) for v in verdicts] == [(v.points, v.judgement) for v in expected]


def test_a_sum_of_nine_thousand_terms_stays_within_its_limit(polar: Problem) -> None:
    terms = "+".join(f"sin({k}*theta1+d2)/{k + 2}" for k in range(9000))
    start = time.process_time()
    verdicts = mark(polar, {"determinant": terms}, secret="s", budgets=TimeBudgets(Budget(1.0), Budget(0.5)))
    assert verdicts[1].judgement.outcome is Outcome.UNGRADED
    assert time.process_time() - start < 5


@pytest.mark.parametrize(
    "answer", sample_for_suite(["theta1*1e308", "[1e308, 1e308]", "1e200*1e200", "[theta1*1e155, 1e-320]"], 2)
)
def test_overflow_in_answers_raises_no_warning(answer: str) -> None:
    problem = generate("planar-2r/1", ["position", "jacobian", "determinant", "joint-rates"])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mark(problem, {part.name: answer for part in problem.parts}, secret="s")
        list(compare_lines([json.dumps({"type": "matrix", "reference": ["theta1", "a1"], "student": answer})], []))
    assert caught == []


# --- one line of a batch ---


def test_a_bad_line_of_a_batch_stops_no_other_line() -> None:
    good_line = json.dumps({"id": 7, "type": "expression", "reference": "a1", "student": "a1"})
    bad_lines = [
        "no JSON", "[]", '{"id": 1}', "[" * 100_000, '{"type": "x", "reference": "a1", "student": "a1"}',
        '{"type": "expression", "reference": "(", "student": "a1"}', "9" * 5000,
        '{"id": 1, "type": "expression", "reference": "a1", "student": "a1", "joints": 5}', "\udcff\udcfe",
    ]  # fmt: skip
    errors: list[str] = []
    answers = [json.loads(line) for line in compare_lines([*bad_lines, "", good_line], errors)]
    assert [answer["outcome"] for answer in answers] == ["ungraded"] * len(bad_lines) + ["correct"]
    assert [answer["reason"] for answer in answers[:-1]] == errors and answers[-1]["id"] == 7
    assert all(error.startswith(f"line {number}") for number, error in enumerate(errors, 1))


# --- a cell that was stopped ---


@pytest.mark.whole
def test_students_are_notified_of_a_cell_stopped_after_its_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assignment = make_class(tmp_path / "hw", [Student("s01"), Student("s02")])

    def add_endless_loops(cells: list[dict[str, object]]) -> None:
        cells[2]["source"] = f"{cells[2]['source']}\nwhile True: pass"
        cells.append(code_cell("while True: pass"))

    path = submit(assignment, "s01/hw.ipynb", make_correct_notebook(assignment, "s01", add_endless_loops))
    submit(assignment, "s02/hw.ipynb", make_correct_notebook(assignment, "s02"))
    results, _ = grade(assignment, seconds=40)
    reason = "it took longer than 4 s of processor time"
    used_value = "qdot used p1_position, which the cell had already set"
    expected = [f"qdot stopped cell 3: {reason}; {used_value}", f"qdot stopped cell 6: {reason}"]
    assert list_outcomes(results["s01"]) == ALL_CORRECT
    assert list(results["s01"].notes) == list(results["s01"].staff_notes) == expected
    assert results["s02"].notes == ()
    monkeypatch.setattr("qdot.grader.grading.check.Sandbox", lambda **_: Sandbox(Limits(seconds=40, cell_seconds=1)))
    assert [note.replace("1 s", "4 s") for note in check_notebook(path).notes] == expected
