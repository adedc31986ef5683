"""Mistakes behind wrong options of choice questions, and behind wrong integers such as the size or rank of J."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace

import sympy as sp

from qdot.exercises.answer_types import Choice, Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.mistakes.base import AnswerGenerator, Mistake, MistakenAnswer
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.concepts import INVERTIBILITY_ANSWERS
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.questions.rank import MeaningDetails
from qdot.exercises.questions.singular import KIND_OPTIONS


def _answers_with_option(part_kind: str, is_mistake: Callable[[Part, int, int], bool]) -> AnswerGenerator:
    """Return a function that yields answers with the wrong options that a mistake leads to.

    `is_mistake` returns whether it does, given the part and the indices of a wrong option and of the correct one.
    """

    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == part_kind and isinstance(part.answer, Choice):
            correct_index = part.answer.correct
            for index in range(len(part.answer.options)):
                if index != correct_index and is_mistake(part, index, correct_index):
                    yield MistakenAnswer(replace(part.answer, correct=index))

    return answers


def _confuse_meanings(
    part_kind: str, text_by_meaning: Mapping[str, str], confused_meanings: Collection[tuple[str, str]]
) -> AnswerGenerator:
    """Return a function that yields answers in which one meaning is confused with another.

    `confused_meanings` are pairs of the correct meaning and the one that is chosen instead.
    """
    meanings_by_text = {text: name for name, text in text_by_meaning.items()}

    def is_chosen(part: Part, chosen_index: int, correct_index: int) -> bool:
        options = part.answer_as(Choice).options
        return (meanings_by_text[options[correct_index]], meanings_by_text[options[chosen_index]]) in confused_meanings

    return _answers_with_option(part_kind, is_chosen)


def _confuse_statements(is_same_meaning: bool) -> AnswerGenerator:
    """Return a function that yields answers with a wrong kind of singularity or a wrong geometric cause.

    If `is_same_meaning`, the geometric cause is correct and the kind is wrong.
    """

    def is_chosen(part: Part, chosen_index: int, correct_index: int) -> bool:
        offered = part.details_as(MeaningDetails).asked.offered
        return (offered[chosen_index][0] is offered[correct_index][0]) is is_same_meaning

    return _answers_with_option("singularity-meaning", is_chosen)


def _combine(*all_answers: AnswerGenerator) -> AnswerGenerator:
    return lambda chain, part: (mistaken for answers in all_answers for mistaken in answers(chain, part))


def _answers_with_numbers(
    part_kind: str, wrong_numbers: Callable[[Chain, Part], Iterable[list[int]]]
) -> AnswerGenerator:
    """Return a function that yields answers with wrong integers."""

    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == part_kind and isinstance(part.answer, Number):
            for values in wrong_numbers(chain, part):
                if values != list(part.answer.reference):
                    yield MistakenAnswer(replace(part.answer, reference=sp.Matrix(values)))

    return answers


def _task_size(part: Part) -> int:
    return len(part.details_as(TaskDetails).task)


def _full_rank(chain: Chain) -> int:
    return min(len(chain.task), chain.n)


def _correct_rank(part: Part) -> int:
    return int(part.answer_as(Number).reference[0])


def _miscount_rows(chain: Chain, part: Part) -> Iterator[list[int]]:
    """Yield the rows and columns of J, with the orientation or the position counted as a single component."""
    linear = sum(row[0] == "v" for row in part.details_as(TaskDetails).task)
    angular = _task_size(part) - linear
    yield [linear + min(angular, 1), chain.n]
    yield [min(linear, 1) + angular, chain.n]
    yield [min(linear, 1) + min(angular, 1), chain.n]


_SINGULARITY_TYPES = {"boundary", "internal"}

MISTAKES = (
    Mistake("boundary-and-internal", "Boundary and internal confused",
            "You seem to have confused boundary and internal singularities. Is the point at the boundary of the "
            "workspace, or inside it?", "below 6.7",
            answers=_combine(
                _confuse_meanings(
                    "singularity-type", KIND_OPTIONS, {("boundary", "internal"), ("internal", "boundary")}
                ),
                _confuse_statements(is_same_meaning=True),
            )),
    Mistake("singular-taken-for-regular", "A singular configuration taken for a regular one",
            "You seem to have taken a singular configuration for a regular one. Substitute its values into det J, or "
            "check the rank.",
            "6.8",
            answers=_combine(
                    _confuse_meanings(
                        "singularity-type", KIND_OPTIONS, {(kind, "regular") for kind in _SINGULARITY_TYPES}
                    ),
                    _confuse_meanings("invertibility", INVERTIBILITY_ANSWERS, {("singular", "regular")}),
                )),
    Mistake("regular-taken-for-singular", "A regular configuration taken for a singular one",
            "You seem to have taken a regular configuration for a singular one. Substitute its values into det J, or "
            "check the rank.",
            "6.8",
            answers=_combine(
                    _confuse_meanings(
                        "singularity-type", KIND_OPTIONS, {("regular", kind) for kind in _SINGULARITY_TYPES}
                    ),
                    _confuse_meanings("invertibility", INVERTIBILITY_ANSWERS, {("regular", "singular")}),
                )),
    Mistake("shape-of-jacobian", "Shape of J not considered",
            "You seem not to have considered the shape of J. Count its rows and columns first: only a square matrix "
            "can have an inverse.", "6.7",
            answers=_confuse_meanings(
                    "invertibility", INVERTIBILITY_ANSWERS,
                    {(a, b) for a in INVERTIBILITY_ANSWERS for b in INVERTIBILITY_ANSWERS if a != b}
                    - {("singular", "regular"), ("regular", "singular")},
                )),
    Mistake("other-meaning", "Another meaning of a singularity",
            "Your option does not describe the arm in this configuration. Draw the arm with these joint values.",
            "below 6.7",
            answers=_confuse_statements(is_same_meaning=False)),
    Mistake("direction-not-lost", "A direction that is not lost",
            "The arm can still move along the line that you chose. Look for the direction along which no column of J "
            "has a component.",
            "6.8", answers=_answers_with_option("lost-motion", lambda *_: True)),
    Mistake("reachable-and-not", "Velocities that can and can't be produced confused",
            "You seem to have confused velocities that the arm can and can't produce. It can produce a velocity that "
            "has no component along the lost direction: check the scalar products.",
            "6.8", answers=_answers_with_option("unreachable-velocity", lambda *_: True)),
    Mistake("motion-turned-round", "Motion of a joint in the wrong direction",
            "The component seems to have the wrong sign. A positive rate rotates the links counterclockwise as seen "
            "from the tip of the axis, or moves them along the axis.", "6.12"),
    Mistake("joint-without-effect", "Joint that has no effect there",
            "If only {joint} changes and all other joints are at rest, nothing changes there.", "6.4"),
    Mistake("column-of-other-joint", "Column of another joint",
            "You seem to have assigned a column to the wrong joint. A column is the velocity for a unit rate of its "
            "own joint, with all other joints at rest.", "6.12"),
    Mistake("size-transposed", "Rows and columns exchanged",
            "You seem to have exchanged the rows and the columns of J. J has one row for each component of velocity "
            "and one column for each joint.", "6.4",
            answers=_answers_with_numbers("jacobian-size", lambda chain, part: [[chain.n, _task_size(part)]])),
    Mistake("size-of-own-task", "Size for another task",
            "You seem to have counted the rows for another task. Check which components of velocity this question "
            "asks for.", "6.6",
            answers=_answers_with_numbers("jacobian-size", lambda chain, _: [[len(chain.task), chain.n]])),
    Mistake("size-six-rows", "Six rows for every task",
            "You seem to have given J all six rows. J has one row for each component of velocity in the task.", "6.6",
            answers=_answers_with_numbers("jacobian-size", lambda chain, _: [[6, chain.n]])),
    Mistake("size-square", "Jacobian assumed to be square",
            "You seem to have assumed that J is square. J has one row for each component of velocity and one column "
            "for each joint.",
            "6.4",
            answers=_answers_with_numbers(
                    "jacobian-size", lambda chain, part: [[size, size] for size in (chain.n, _task_size(part))]
                ), rare=True),
    Mistake("rank-full", "Full rank given",
            "You seem to have given the rank for a regular configuration. How many columns are linearly independent "
            "here?", "6.8",
            answers=_answers_with_numbers("rank", lambda chain, _: [[_full_rank(chain)]])),
    Mistake("rank-of-shape", "Number of rows or columns instead of the rank",
            "You seem to have given the number of rows or columns. The rank is at most the smaller of the two, and "
            "less if J is singular.", "6.8",
            answers=_answers_with_numbers("rank", lambda chain, _: [[chain.n], [len(chain.task)]])),
    Mistake("rank-less", "Rank of a singular configuration given",
            "You seem to have given the rank for a singular configuration. How many columns are linearly independent "
            "here?", "6.8",
            answers=_answers_with_numbers(
                    "rank",
                    lambda chain, part: [[_correct_rank(part) - 1]] if _correct_rank(part) == _full_rank(chain) else [],
                )),
    Mistake("rank-of-one-condition", "Only one of several conditions counted",
            "You seem to have subtracted one from the full rank. Does more than one condition hold in this "
            "configuration?", "6.8",
            answers=_answers_with_numbers(
                    "rank",
                    lambda chain, part: (
                        [[_full_rank(chain) - 1]] if _correct_rank(part) < _full_rank(chain) - 1 else []
                    ),
                ), rare=True),
    Mistake("rank-zero", "Rank zero because the determinant is zero",
            "You seem to have given rank zero because the determinant is zero. This only shows that the rank is less "
            "than full: count the independent columns.",
            "6.8", answers=_answers_with_numbers("rank", lambda chain, part: [[0]]), rare=True),
    Mistake("size-of-kinds", "Orientation counted as one component",
            "You seem to have counted the position or the orientation as one component. J has one row for each "
            "component of velocity in the task.",
            "6.6", answers=_answers_with_numbers("jacobian-size", _miscount_rows), rare=True),
)  # fmt: skip
