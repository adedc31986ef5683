"""The reference answers of every question of every family agree with tests/snapshots.

If a reference changes, an id regenerates another problem: raise exercises.ENGINE, then update the snapshots:

    QDOT_UPDATE_SNAPSHOTS=1 python -m pytest tests/exercises/questions/test_questions.py
"""

import hashlib
import json
import os
import re
from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.problem.problem import ENGINE, Part, Problem, ProblemId
from qdot.exercises.problem.record import to_plain_data
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.reference_answers import Choice, ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.writing.problem_texts import write_prompt, write_solution
from qdot.grader.grading.certify import find_failures
from tests.support import DATA, SNAPSHOTS
from tests.support.problems import get_problem
from tests.support.suites import sample_for_suite, select_for_suite

RECORDS = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
EACH = select_for_suite(1, len(RECORDS))
"""The number of textbook arms per question; `make test` prefers short arms and takes them in turn."""


def describe_answer(part: Part) -> Any:
    answer = part.answer
    if isinstance(answer, ConditionSet):
        return answer.list_pieces()
    if isinstance(answer, Choice):
        return {"options": list(answer.options), "correct": answer.letters}
    if isinstance(answer, Expression):
        return str(answer.reference)
    assert isinstance(answer, (Matrix, Number, Direction))
    return [[str(entry) for entry in row] for row in answer.reference.tolist()]


def describe_arm(problem: Problem) -> Any:
    chain = problem.chain
    rows = [[j.kind, str(j.theta), str(j.d), str(j.a), str(j.alpha)] for j in chain.joints]
    base, point = map(to_plain_data, (chain.base, chain.point))
    return {"rows": rows, "base": base, "point": point, "task": list(chain.task)}


def make_snapshot(problems: list[Problem]) -> dict[str, Any]:
    problem_data: dict[str, Any] = {
        str(problem.id): {
            "arm": describe_arm(problem),
            "parts": {
                part.name: {"answer": describe_answer(part), "details": to_plain_data(part.details)}
                for part in problem.parts
            },
        }
        for problem in problems
    }
    text = json.dumps(problem_data, sort_keys=True, ensure_ascii=False)
    return {"engine": ENGINE, "sha256": hashlib.sha256(text.encode()).hexdigest(), "problems": problem_data}


def test_id_regenerates_the_stored_problem(family: str) -> None:
    """Compare a problem of each family at each variation step; `make test` checks the last step."""
    path, updated = SNAPSHOTS / f"{family}.json", os.environ.get("QDOT_UPDATE_SNAPSHOTS") == "1"
    few = ("full",)
    steps = tuple(VARIATION_STEPS) if updated else select_for_suite(few, tuple(VARIATION_STEPS))
    current = make_snapshot([get_problem(family, 0, step) for step in steps])
    if updated:
        SNAPSHOTS.mkdir(exist_ok=True)
        path.write_text(json.dumps(current, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert path.exists(), f"no snapshot of {family} yet: QDOT_UPDATE_SNAPSHOTS=1 python -m pytest {__file__}"
    stored = json.loads(path.read_text(encoding="utf-8"))
    assert list(stored["problems"]) == [str(ProblemId(family, 0, variation=step)) for step in VARIATION_STEPS]
    stored["problems"] = {name: stored["problems"][name] for name in current["problems"]}
    for identity, problem in stored["problems"].items():
        for name, part in problem["parts"].items():
            assert current["problems"][identity]["parts"].get(name) == part, f"{identity}: {name} has changed"
    if steps == tuple(VARIATION_STEPS):
        assert current == stored
    assert current["engine"] == stored["engine"] and current["problems"] == stored["problems"]


def test_every_snapshot_belongs_to_a_family() -> None:
    assert {path.stem for path in SNAPSHOTS.glob("*.json")} <= set(FAMILIES)


def test_questions_are_registered_under_their_names_with_valid_prerequisites() -> None:
    for name, question in QUESTIONS.items():
        assert question.name == name and question.title and question.source and question.points > 0, name
        assert all(need in QUESTIONS for need in question.prerequisites), name


@pytest.mark.parametrize("name", sample_for_suite(QUESTIONS, 6))
def test_textbook_arms_pass_certificate_and_grader(name: str, textbook_arms: dict[str, Any]) -> None:
    """These arms belong to no family, and their tables use the books' symbols."""
    question, taken = QUESTIONS[name], 0
    turn = EACH * list(QUESTIONS).index(name) % len(RECORDS)
    in_turn = [textbook_arms[record["name"]] for record in (*RECORDS[turn:], *RECORDS[:turn])]
    for arm in sorted(in_turn, key=lambda arm: arm.chain.n > 4):
        chain = replace(arm.chain, convention=question.conventions[0])
        if taken < EACH and question.find_obstacle(chain) is None:
            answer, details = question.ask(chain, Stream(f"{chain.name}/{name}"))
            part = Part(name, name, answer, question.points, (), details)
            problem = Problem(ProblemId("textbook", 1, (name,)), chain, (part,))
            assert find_failures(problem) == [], chain.name
            texts = write_prompt(problem, part) + write_solution(problem, part)
            assert not re.search(r"\bNone\b(?! of)", texts), chain.name
            taken += 1
    assert taken


def test_answers_are_well_formed(family: str) -> None:
    problem = get_problem(family, select_for_suite(0, 1))
    for part in problem.parts:
        _check_answer(part, set(problem.symbols))


def _check_answer(part: Part, known: set[str]) -> None:
    answer = part.answer
    if isinstance(answer, (Expression, Matrix, Number, Direction)):
        assert {symbol.name for symbol in answer.reference.free_symbols} <= known, part.name
        assert not answer.reference.has(sp.nan, sp.oo, sp.zoo), part.name
    if isinstance(answer, (Matrix, Number, Direction)):
        assert part.shape == answer.reference.shape, part.name
    if isinstance(answer, Number):
        assert len(answer.units) == len(answer.reference), part.name
        assert 0 < answer.tolerance < 0.05 and answer.floor > 0, part.name
    if isinstance(answer, ConditionSet):
        assert answer.list_pieces(), part.name
        assert all(parse_formula(text, known) for text in answer.list_pieces()), part.name
    if isinstance(answer, Choice):
        assert len(set(answer.options)) == len(answer.options) >= 2, part.name
        assert 0 <= answer.correct < len(answer.options), part.name
