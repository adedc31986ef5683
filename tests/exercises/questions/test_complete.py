"""Every question supports diagnosis, follow-through, hints, platforms and STACK, or has a reason in LACKS."""

from collections.abc import Iterator
from dataclasses import FrozenInstanceError, fields
from functools import cache

import pytest

from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.numeric_part import ask_in_numbers
from qdot.exercises.exports.stack_parts import convert_part as asked_by_stack
from qdot.exercises.exports.stack_parts import remove_rounding_if_exact
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate
from qdot.exercises.mistakes.catalogue import generate_mistaken_answers
from qdot.exercises.problem.problem import Details, Part, Problem, ProblemId
from qdot.exercises.questions.results import is_derived_step_by_step
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.short_questions.options import list_blames
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solution
from qdot.grader.marking.marking import compute_earned_share
from tests.support.judging import list_earlier_parts
from tests.support.problems import choose_convention
from tests.support.suites import sample_for_suite

NOT_DIAGNOSED = {
    "true-or-false": "one of two answers does not reveal how it was found",
    "dependence": "the letters of joints do not reveal how they were found",
    **dict.fromkeys(("determinant-value", "speed"), "numeric short questions are not compared with the catalogue yet"),
}
NOT_FOLLOWED = {
    "rank": "a wrong Jacobian usually has full rank where J does not",
    "lost-direction": "a wrong Jacobian usually loses no direction where J does",
}
NOT_ON_PLATFORMS = {"singular-angles": "platforms ask for conditions as a choice of configurations"}
NOT_IN_STACK = {
    name: "STACK has no input for several letters"
    for name, question in ALL_QUESTIONS.items()
    if question.form in ("selection", "matching")
}
LACKS = {
    "diagnosis": NOT_DIAGNOSED, "follow-through": NOT_FOLLOWED, "platforms": NOT_ON_PLATFORMS, "STACK": NOT_IN_STACK,
}  # fmt: skip
"""Questions that lack a duty, and why."""


@cache
def generate_with_question(name: str) -> Problem:
    """Return a problem with one question, of the first family that suits it, in the question's convention."""
    convention = choose_convention(ALL_QUESTIONS[name])
    for family in FAMILIES:
        try:
            return generate(ProblemId(family, 1, (name,), variation="chapter", convention=convention))
        except QdotError:
            continue
    raise AssertionError(f"no family can be asked {name}")


def list_duties(problem: Problem, part: Part) -> dict[str, bool]:
    """Return which duties of LACKS a question supports; platforms such as Moodle need letters or numbers."""
    behind_options = any(list_blames(part, index) for index in range(len(part.answer.offered_options)))
    return {
        "diagnosis": is_derived_step_by_step(part)
        or behind_options
        or next(generate_mistaken_answers(problem.chain, part), None) is not None,
        "follow-through": not ALL_QUESTIONS[part.kind].prerequisites or any(list_earlier_parts(part)),
        "platforms": bool(part.answer.offered_options) or ask_in_numbers(problem, part) is not None,
        "STACK": not isinstance(asked_by_stack(problem, remove_rounding_if_exact(part), compute_earned_share), str),
    }


def list_subclasses(kind: type[Details]) -> Iterator[type[Details]]:
    for subclass in kind.__subclasses__():
        yield from (subclass, *list_subclasses(subclass))


@pytest.mark.parametrize("name", sample_for_suite(ALL_QUESTIONS, 20))
def test_details_of_question_are_frozen_and_of_one_class(name: str) -> None:
    (part,) = generate_with_question(name).parts
    details_class = type(part.details)
    assert details_class is Details or details_class in list_subclasses(Details)
    assert part.details_as(details_class) is part.details
    assert [*vars(part.details)] == [field.name for field in fields(part.details)]
    for detail in fields(part.details):
        with pytest.raises(FrozenInstanceError):
            setattr(part.details, detail.name, None)
    for unrelated in list_subclasses(Details):
        if not issubclass(details_class, unrelated):
            with pytest.raises(TypeError, match=rf"'{name}' are {details_class.__name__}, not {unrelated.__name__}$"):
                part.details_as(unrelated)


@pytest.mark.parametrize("name", sample_for_suite(ALL_QUESTIONS, 30))
def test_question_supports_every_duty_or_gives_a_reason(name: str) -> None:
    problem = generate_with_question(name)
    part = problem.parts[-1]
    assert list_duties(problem, part) == {duty: name not in lacking for duty, lacking in LACKS.items()}
    assert len(write_prompt(problem, part)) > 40
    assert len(set(write_hints(problem, part))) == 3
    assert write_solution(problem, part)
    named, shape = ALL_QUESTIONS[name].name_entries(problem.chain, part.details), part.shape or (1, 1)
    assert len(named) in (0, shape[0] * shape[1])
    assert len(ALL_QUESTIONS[part.kind].list_labels(problem.chain)) in (0, shape[0])
