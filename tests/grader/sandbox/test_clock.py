"""Judging has a limit of its own: what takes too long is broken off, is no mark, and stops nothing else."""

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
from qdot.grader.grading import marking
from qdot.grader.grading.check import check_notebook
from qdot.grader.grading.marking import mark
from qdot.grader.judging.answer import ParsedAnswer
from qdot.grader.judging.compare_command import compare_lines
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.judging.verdict import Judgement, Outcome
from qdot.grader.sandbox.clock import Budget, TimeBudgets
from qdot.grader.sandbox.sandbox import Limits, Sandbox
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


def endless() -> None:
    while True:
        try:
            with mpmath.workdps(80):
                sum(range(1000))
        except Exception:
            continue


def broken_off(budget: Budget) -> bool:
    try:
        with budget.spend():
            endless()
    except OutOfTime:
        return True
    return False


def test_what_takes_too_long_is_broken_off_in_any_thread_and_leaves_nothing() -> None:
    budget, begun, digits = Budget(0.1), time.process_time(), mpmath.mp.prec
    assert broken_off(budget) and time.process_time() - begun < 5
    assert mpmath.mp.prec == digits and budget.remaining_seconds <= 0
    other = Budget(0.1)
    thread = threading.Thread(target=broken_off, args=(other,), daemon=True)
    thread.start()
    thread.join(20)
    assert not thread.is_alive() and other.remaining_seconds <= 0
    with pytest.raises(OutOfTime), budget.spend():
        raise AssertionError("nothing is left of it")


def compute_until(is_over: Callable[[], bool]) -> None:
    """Compute in a frame of its own: what Python 3.13 raises at the end of a loop passes by a `try` around the loop."""
    while not is_over():
        pass


class Swallowing:
    """What comes inside of a destructor is lost, as inside of a callback of the garbage collector."""

    def __del__(self) -> None:
        until = time.process_time() + 0.2
        while time.process_time() < until:
            pass


@pytest.mark.filterwarnings("ignore:Exception ignored in:pytest.PytestUnraisableExceptionWarning")
def test_it_is_broken_off_where_the_first_time_was_lost() -> None:
    budget, begun = Budget(0.1), time.process_time()
    with pytest.raises(OutOfTime), budget.spend():
        Swallowing()
        compute_until(lambda: time.process_time() > begun + 5)
    assert budget.remaining_seconds <= 0


def test_a_stop_on_the_way_to_the_end_changes_nothing() -> None:
    ends = [OutOfTime, None]

    class Late(Watchdog):
        def end(self) -> None:
            super().end()
            if kind := ends.pop(0):
                raise kind

    end_watchdog(Late(60))
    assert not ends


def test_sleeping_costs_nothing_and_several_share_a_budget() -> None:
    budget = Budget(1.0)
    for _ in range(3):
        with budget.spend():
            time.sleep(0.05)
            sum(range(100_000))
    assert 0.5 < budget.remaining_seconds < 1.0
    time.sleep(0.1)


def test_nothing_is_raised_after_the_block() -> None:
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


WRONG = {"position": "[d2, 1]", "determinant": "d2 + 0.7"}


def test_an_answer_that_takes_too_long_to_judge_is_no_mark(polar: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> Judgement:
        if part.name == "determinant":
            endless()
        return judge_parsed(problem, part, given, seed)

    monkeypatch.setattr(marking, "judge_parsed", slow)
    position, determinant = mark(polar, WRONG, secret="s", allowance=TimeBudgets(Budget(0.5)))
    assert position.judgement.outcome is Outcome.WRONG and position.points == 0
    assert determinant.judgement.outcome is Outcome.UNGRADED and determinant.points is None
    assert "takes more than 0.5 s of processor time" in determinant.judgement.reason
    assert determinant.judgement.over_limit and not position.judgement.over_limit


def test_what_follows_from_an_answer_may_not_be_lost_for_want_of_time(
    polar: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(marking, "find_follow_through", lambda *_: endless())
    _, determinant = mark(polar, WRONG, secret="s", allowance=TimeBudgets(Budget(0.5)))
    assert determinant.judgement.outcome is Outcome.UNGRADED


def test_what_is_behind_a_wrong_answer_is_looked_for_within_limits(
    polar: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = mark(polar, WRONG, secret="s")
    assert known[1].diagnosis is not None
    monkeypatch.setattr(marking, "diagnose", lambda *_: endless())
    found = mark(polar, WRONG, secret="s", allowance=TimeBudgets(diagnosing=Budget(0.2)))
    assert [one.diagnosis for one in found] == [None, None]
    assert [(one.points, one.judgement) for one in found] == [(one.points, one.judgement) for one in known]


def test_sums_of_nine_thousand_terms_take_no_longer_than_they_may(polar: Problem) -> None:
    terms = "+".join(f"sin({k}*theta1+d2)/{k + 2}" for k in range(9000))
    begun = time.process_time()
    verdicts = mark(polar, {"determinant": terms}, secret="s", allowance=TimeBudgets(Budget(1.0), Budget(0.5)))
    assert verdicts[1].judgement.outcome is Outcome.UNGRADED
    assert time.process_time() - begun < 5


@pytest.mark.parametrize(
    "answer", sample_for_suite(["theta1*1e308", "[1e308, 1e308]", "1e200*1e200", "[theta1*1e155, 1e-320]"], 2)
)
def test_answers_that_overflow_print_nothing(answer: str) -> None:
    problem = generate("planar-2r/1", ["position", "jacobian", "determinant", "joint-rates"])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mark(problem, {part.name: answer for part in problem.parts}, secret="s")
        list(compare_lines([json.dumps({"type": "matrix", "reference": ["theta1", "a1"], "student": answer})], []))
    assert caught == []


# --- one line of a batch ---


def test_a_bad_line_stops_no_other() -> None:
    good = json.dumps({"id": 7, "type": "expression", "reference": "a1", "student": "a1"})
    bad = [
        "no JSON", "[]", '{"id": 1}', "[" * 100_000, '{"type": "x", "reference": "a1", "student": "a1"}',
        '{"type": "expression", "reference": "(", "student": "a1"}', "9" * 5000,
        '{"id": 1, "type": "expression", "reference": "a1", "student": "a1", "joints": 5}', "\udcff\udcfe",
    ]  # fmt: skip
    refused: list[str] = []
    answers = [json.loads(line) for line in compare_lines([*bad, "", good], refused)]
    assert [answer["outcome"] for answer in answers] == ["ungraded"] * len(bad) + ["correct"]
    assert [answer["reason"] for answer in answers[:-1]] == refused and answers[-1]["id"] == 7
    assert all(said.startswith(f"line {number}") for number, said in enumerate(refused, 1))


# --- a cell that was stopped ---


@pytest.mark.whole
def test_a_cell_that_is_stopped_behind_its_answer_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assignment = make_class(tmp_path / "hw", [Student("s01"), Student("s02")])

    def loop_behind(cells: list[dict[str, object]]) -> None:
        cells[2]["source"] = f"{cells[2]['source']}\nwhile True: pass"
        cells.append(code_cell("while True: pass"))

    path = submit(assignment, "s01/hw.ipynb", make_correct_notebook(assignment, "s01", loop_behind))
    submit(assignment, "s02/hw.ipynb", make_correct_notebook(assignment, "s02"))
    results, _ = grade(assignment, seconds=40)
    why = "it took longer than 4 s of processor time"
    read = "qdot used p1_position, which the cell had already set"
    expected = [f"cell 3 was stopped: {why}; {read}", f"cell 6 was stopped: {why}"]
    assert list_outcomes(results["s01"]) == ALL_CORRECT
    assert list(results["s01"].notes) == list(results["s01"].staff_notes) == expected
    assert results["s02"].notes == ()
    monkeypatch.setattr("qdot.grader.grading.check.Sandbox", lambda **_: Sandbox(Limits(seconds=40, cell_seconds=1)))
    assert [note.replace("1 s", "4 s") for note in check_notebook(path).notes] == expected
