"""The types of answers: each is of one form, and all that is asked of a type holds for each."""

from typing import Any

import pytest
import sympy as sp

from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions.custom.definition import Definition, Texts
from qdot.exercises.reference_answers import TYPES, AnswerVisitor, Choice, Expression, Number
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from tests.support.problems import get_problem

FORMS = tuple(f"visit_{name}" for name in TYPES)


class Named(AnswerVisitor[str]):
    def __getattribute__(self, name: str) -> Any:
        return (lambda _: name) if name in FORMS else super().__getattribute__(name)


class OfLettersOnly(AnswerVisitor[str]):
    """Knows letters, and a way for formulas."""

    def visit_letters(self, answer: Any) -> str:
        return str(answer.letters)

    def visit_formulas(self, answer: Any) -> str:
        return str(len(answer.list_entries()))


def parts() -> dict[str, tuple[Problem, Part]]:
    problems = [
        get_problem("planar-2r", 0), generate(ProblemId("planar-3r", 1, ("match-columns",))),
        generate(ProblemId("planar-2r", 1, ("singular-configurations",))),
        generate(ProblemId("planar-2r", 1, ("lost-direction",))),
        generate("planar-2r/1", ["why"], definitions=[Definition("why", "text", (Texts("Why", "Why?"),))]),
    ]  # fmt: skip
    return {part.type: (problem, part) for problem in problems for part in problem.parts}


def test_every_type_is_asked_for_and_is_of_one_form() -> None:
    found = parts()
    assert found.keys() == TYPES.keys()
    forms = {name: Named().visit(part.answer) for name, (_, part) in found.items()}
    assert forms == {name: f"visit_{name}" for name in TYPES}


def test_what_is_typed_is_read_and_right(problem: Problem) -> None:
    known = problem.symbols
    for part in problem.parts:
        answer = part.answer
        assert judge(problem, part, answer.as_typed(), "typed").outcome is Outcome.CORRECT, part.name
        assert all(parse_formula(text, known) for text in answer.list_formulas())
        assert bool(answer.list_formulas()) == (not answer.offered_options)
        assert all(text in answer.as_typed() for text in answer.list_formulas())
        if answer.shape is not None:
            assert answer.as_matrix().shape == answer.shape
            assert len(answer.list_formulas()) == answer.shape[0] * answer.shape[1]


def test_a_placeholder_is_missing_and_not_wrong(problem: Problem) -> None:
    for part in problem.parts:
        blank = part.answer.write_placeholder().strip('"').removeprefix("Matrix(").removesuffix(")")
        assert judge(problem, part, blank, "blank").outcome is Outcome.MISSING, part.name


def test_a_way_that_is_not_written_is_that_of_a_wider_form() -> None:
    choice, formula = Choice(("yes", "no"), 1), Expression(sp.Symbol("a1"))
    assert OfLettersOnly().visit(choice) == "B"
    assert OfLettersOnly().visit(formula) == "1"
    with pytest.raises(TypeError, match="OfLettersOnly does not support answers of type number"):
        OfLettersOnly().visit(Number(sp.Matrix([1]), ("m",), 0.01, 0.0))


def test_an_answer_of_another_type_than_its_question_has_is_told() -> None:
    with pytest.raises(TypeError, match="the answer to 'rank' is of type choice, not number"):
        Part("rank", "rank", Choice(("1", "2"), 0)).answer_as(Number)
    with pytest.raises(TypeError, match="the answer is of type choice, not a matrix"):
        Choice(("1", "2"), 0).as_matrix()
