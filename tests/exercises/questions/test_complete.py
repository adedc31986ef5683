"""Every question is diagnosed, followed through, hinted at, asked by platforms and practised, or says why it is not."""

from collections.abc import Iterator
from dataclasses import FrozenInstanceError, fields
from functools import cache

import pytest

from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.numbers import ask_in_numbers
from qdot.exercises.exports.stack_parts import convert_part as asked_by_stack
from qdot.exercises.exports.stack_parts import remove_rounding_if_exact
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate
from qdot.exercises.mistakes.catalogue import generate_mistaken_answers
from qdot.exercises.problem.problem import Details, Part, Problem, ProblemId
from qdot.exercises.questions.results import is_derived
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.short_questions.options import list_blames
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solution
from tests.support.judging import list_earlier_parts
from tests.support.problems import choose_convention

NOT_DIAGNOSED = {
    "path-limit": "a distance at which a limit is met does not tell one mistake from another",
    "true-or-false": "one of two answers tells of no way to it",
    "dependence": "the letters of joints tell of no way to them",
    **dict.fromkeys(
        ("determinant-value", "speed"), "short questions in numbers are not held against the catalogue yet"
    ),
}
NOT_FOLLOWED = {
    "rank": "a wrong Jacobian mostly has full rank where J has not",
    "lost-direction": "a wrong Jacobian mostly loses no direction where J does",
    "path-limit": "it is searched for along the line, and rates are asked for at one distance only",
}
NOT_ON_PLATFORMS = {"singular-angles": "conditions are asked as a choice of configurations there"}
NOT_IN_STACK = {
    name: "STACK has no input for several letters"
    for name, question in ALL_QUESTIONS.items()
    if question.form in ("selection", "matching")
}
LACKS = {
    "diagnosis": NOT_DIAGNOSED,
    "follow-through": NOT_FOLLOWED,
    "platforms": NOT_ON_PLATFORMS,
    "STACK": NOT_IN_STACK,
}
"""Questions that lack something, and why."""


@cache
def problem_with(name: str) -> Problem:
    """Return a problem of the first family that has an arm for a question, told in its own convention."""
    convention = choose_convention(ALL_QUESTIONS[name])
    for family in FAMILIES:
        try:
            return generate(ProblemId(family, 1, (name,), variation="chapter", convention=convention))
        except QdotError:
            continue
    raise AssertionError(f"no family can be asked {name}")


def works(problem: Problem, part: Part) -> dict[str, bool]:
    """Return which of LACKS a question has: platforms as Moodle and Canvas ask for letters or numbers."""
    behind_options = any(list_blames(part, index) for index in range(len(part.answer.offered_options)))
    return {
        "diagnosis": is_derived(part)
        or behind_options
        or next(generate_mistaken_answers(problem.chain, part), None) is not None,
        "follow-through": not ALL_QUESTIONS[part.kind].prerequisites or any(list_earlier_parts(part)),
        "platforms": bool(part.answer.offered_options) or ask_in_numbers(problem, part) is not None,
        "STACK": not isinstance(asked_by_stack(problem, remove_rounding_if_exact(part)), str),
    }


def below(kind: type[Details]) -> Iterator[type[Details]]:
    for other in kind.__subclasses__():
        yield from (other, *below(other))


@pytest.mark.parametrize("name", ALL_QUESTIONS)
def test_the_details_of_a_question_are_frozen_and_of_one_class(name: str) -> None:
    (part,) = problem_with(name).parts
    own = type(part.details)
    assert own is Details or own in below(Details)
    assert part.details_as(own) is part.details
    assert [*vars(part.details)] == [field.name for field in fields(part.details)]
    for detail in fields(part.details):
        with pytest.raises(FrozenInstanceError):
            setattr(part.details, detail.name, None)
    for other in below(Details):
        if not issubclass(own, other):
            with pytest.raises(TypeError, match=rf"'{name}' are {own.__name__}, not {other.__name__}$"):
                part.details_as(other)


@pytest.mark.parametrize("name", ALL_QUESTIONS)
def test_a_question_does_each_duty_or_says_why_not_and_is_asked_hinted_at_and_solved(name: str) -> None:
    problem = problem_with(name)
    part = problem.parts[-1]
    assert works(problem, part) == {duty: name not in lacking for duty, lacking in LACKS.items()}
    assert len(write_prompt(problem, part)) > 40
    assert len(set(write_hints(problem, part))) == 3
    assert write_solution(problem, part)
    named, shape = ALL_QUESTIONS[name].name_entries(problem.chain, part), part.shape or (1, 1)
    assert len(named) in (0, shape[0] * shape[1])
    assert len(ALL_QUESTIONS[part.kind].list_labels(problem.chain)) in (0, shape[0])
